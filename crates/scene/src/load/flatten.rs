//! Flattens a model's instances into one mesh, in order.

use super::builder::not_finite;
use super::error::{Fault, fault};
use crate::coordinate::Coordinate;
use crate::instances::{Instance, InstancedMesh, placed};
use crate::mesh::Mesh;

/// The number of vertices and triangles that a glTF file may expand to, in addition to its size.
/// Without this limit, any number of nodes could repeat the same mesh, and any number of accessors
/// the same bytes.
pub(super) const REPEATS: u64 = 1 << 24;

/// The error message if a file exceeds its limit; see [`REPEATS`].
pub(super) const REPEATED: &str =
    "the file repeats its meshes beyond 16777216 vertices and triangles; export fewer copies";

/// Returns one mesh with the triangles of all instances, or an error if it would have more than
/// `most` vertices and triangles in total.
pub(super) fn flatten<S: Coordinate>(model: InstancedMesh, most: u64) -> Result<Mesh<S>, Fault> {
    let InstancedMesh { meshes, instances } = model;
    check_size(&meshes, &instances, most)?;
    let has_uvs = meshes.iter().any(|mesh| mesh.corner_uvs.is_some());
    let mut left = vec![0_usize; meshes.len()];
    for instance in &instances {
        left[instance.mesh as usize] += 1;
    }

    let mut meshes: Vec<Option<Mesh<f64>>> = meshes.into_iter().map(Some).collect();
    let mut all = Mesh { corner_uvs: has_uvs.then(Vec::new), ..Mesh::default() };
    for Instance { mesh: index, matrix } in &instances {
        let index = *index as usize;
        if let Some(mesh) = &meshes[index] {
            append(&mut all, mesh, matrix)?;
        }
        // Drop each mesh after its last use, so that a large model is not in memory twice.
        left[index] -= 1;
        if left[index] == 0 {
            meshes[index] = None;
        }
    }
    check_vertices(&all)?;
    Ok(all)
}

fn check_size(meshes: &[Mesh<f64>], instances: &[Instance], most: u64) -> Result<(), Fault> {
    let (mut vertices, mut triangles) = (0_u64, 0_u64);
    for instance in instances {
        let mesh = &meshes[instance.mesh as usize];
        vertices += mesh.positions.len() as u64;
        triangles += mesh.triangles.len() as u64;
    }
    if vertices + triangles > most {
        return fault(REPEATED);
    }
    if vertices > u64::from(u32::MAX) || triangles > u64::from(u32::MAX) {
        return fault("more than 4294967295 vertices or triangles; cut the model into parts");
    }
    Ok(())
}

/// Appends the triangles of an instance to `all`.
fn append<S: Coordinate>(
    all: &mut Mesh<S>,
    mesh: &Mesh<f64>,
    matrix: &[f64; 12],
) -> Result<(), Fault> {
    let first = all.positions.len() as u32;
    all.positions.try_reserve(mesh.positions.len())?;
    let positions = mesh.positions.iter();
    all.positions.extend(positions.map(|&point| placed(matrix, point).map(S::nearest)));
    all.triangles.try_reserve(mesh.triangles.len())?;
    let triangles = mesh.triangles.iter();
    all.triangles.extend(triangles.map(|corners| corners.map(|corner| first + corner)));
    if let (Some(all), Some(uvs)) = (&mut all.corner_uvs, &mesh.corner_uvs) {
        all.try_reserve(uvs.len())?;
        all.extend(uvs);
    }
    Ok(())
}

/// Rejects a model if an instance moves a triangle's corner to coordinates that are not finite, or
/// if this check would visit more than `most` vertices and triangles.
pub(super) fn check(model: &InstancedMesh, most: u64) -> Result<(), Fault> {
    let mut left = most;
    let sizes: Vec<[f64; 3]> = model.meshes.iter().map(largest).collect();
    for Instance { mesh, matrix: m } in &model.instances {
        let [x, y, z] = sizes[*mesh as usize];
        let bound =
            |i: usize| m[i].abs() * x + m[i + 1].abs() * y + m[i + 2].abs() * z + m[i + 3].abs();
        // Visit a mesh's corners only if they might overflow. Even a small file may have many such
        // instances, so the visits count toward the same limit as for flattening.
        if [0, 4, 8].iter().all(|&i| bound(i) < f64::MAX / 2.0) {
            continue;
        }
        let mesh = &model.meshes[*mesh as usize];
        match left.checked_sub((mesh.positions.len() + mesh.triangles.len()) as u64) {
            Some(rest) => left = rest,
            None => return fault(REPEATED),
        }
        let mut points = mesh.points().map(|point| placed(m, point));
        if let Some(point) = points.find(|point| point.iter().any(|x| !x.is_finite())) {
            return fault(not_finite(point));
        }
    }
    Ok(())
}

/// Returns the largest absolute value of the coordinates along each axis.
fn largest(mesh: &Mesh<f64>) -> [f64; 3] {
    mesh.points().fold([0.0; 3], |most, point| [0, 1, 2].map(|k| point[k].abs().max(most[k])))
}

/// Rejects triangles with a vertex that is not finite.
fn check_vertices<S: Coordinate>(mesh: &Mesh<S>) -> Result<(), Fault> {
    match mesh.points().find(|point| point.iter().any(|x| !x.is_finite())) {
        Some(point) => fault(not_finite(point)),
        None => Ok(()),
    }
}
