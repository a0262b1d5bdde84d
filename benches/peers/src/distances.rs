//! Measures how fast intertri and parry3d compute the signed distances of points near a mesh.

use std::path::{Path, PathBuf};
use std::time::Instant;

use intertri_scene::Mesh;
use intertri_trace::{ClosestPoint, Solid};
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};
use rayon::ThreadPool;
use rayon::prelude::*;

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to measure; see the `rays` command. The sign is only meaningful for closed meshes.
    #[arg(long, value_delimiter = ',', default_value = "bunny,torus")]
    scene: Vec<String>,
    /// Number of points, in a box 1.5 times as large as the mesh in each direction.
    #[arg(long, default_value_t = 1_000_000)]
    points: usize,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Folder to save the mesh, the points and intertri's answers to, for use by other programs:
    /// NAME.obj, NAME.points (f32) and NAME.distances (f64), both little-endian.
    #[arg(long, value_name = "FOLDER")]
    dump: Option<PathBuf>,
}

/// Returns a generator that yields the same random numbers in `0..1` in every run.
fn random() -> impl FnMut() -> f32 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 40) as f32 / (1 << 24) as f32
    }
}

pub fn run(options: &Options) -> Result<(), String> {
    let pool = crate::pool(options.threads)?;
    println!("threads: {}", pool.current_num_threads());
    for name in &options.scene {
        let mesh = crate::scenes::scene(name)?.mesh;
        let bounds = mesh.bounds().ok_or("the mesh has no triangles")?;
        let mut number = random();
        let mut coordinate = |k: usize| {
            let (lo, hi) = (bounds.min[k], bounds.max[k]);
            lo + (hi - lo) * (number() * 1.5 - 0.25)
        };
        let points: Vec<[f32; 3]> =
            (0..options.points).map(|_| [coordinate(0), coordinate(1), coordinate(2)]).collect();
        println!("{name}: {} triangles, {} random points", mesh.triangles.len(), points.len());
        compare(&mesh, &points, &pool, options.dump.as_deref().map(|folder| folder.join(name)))?;

        // Also measure the points of a grid, whose order in the slice follows their position in
        // space.
        let side = (options.points as f64).cbrt() as usize;
        let at = |k: usize, i: usize| {
            let (lo, hi) = (bounds.min[k], bounds.max[k]);
            lo + (hi - lo) * (i as f32 / side as f32 * 1.5 - 0.25)
        };
        let grid: Vec<[f32; 3]> = (0..side * side * side)
            .map(|i| [at(0, i % side), at(1, i / side % side), at(2, i / side / side)])
            .collect();
        println!("{name}: {} points on a grid", grid.len());
        compare(&mesh, &grid, &pool, None)?;
    }
    Ok(())
}

/// Returns the microseconds per point in the fastest of three runs.
fn fastest<R>(count: usize, mut work: impl FnMut() -> R) -> f64 {
    let mut once = || {
        let start = Instant::now();
        let _kept = work();
        start.elapsed().as_secs_f64() * 1e6 / count as f64
    };
    (0..3).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn compare(
    mesh: &Mesh,
    points: &[[f32; 3]],
    pool: &ThreadPool,
    dump: Option<PathBuf>,
) -> Result<(), String> {
    let solid = Solid::assume_closed(&mesh.to_triangles()).map_err(|e| e.to_string())?;
    let closed = Solid::new(&mesh.to_triangles()).is_ok();
    let mut closest = vec![ClosestPoint::NONE; points.len()];
    let mut signed = vec![0.0; points.len()];
    let infinity = f64::INFINITY;
    let time = fastest(points.len(), || {
        pool.install(|| solid.bvh().closest_point_batch_into(points, infinity, &mut closest));
    });
    println!("  intertri, closest point    {time:7.3} us/point");
    let time = fastest(points.len(), || {
        pool.install(|| solid.signed_distance_batch_into(points, &mut signed));
    });
    println!("  intertri, signed distance  {time:7.3} us/point");
    if let Some(path) = dump {
        write_down(&path, mesh, points, &signed)?;
    }

    let vertices = || mesh.positions.iter().map(|&p| Vector::from_array(p)).collect();
    let mesh = TriMesh::with_flags(vertices(), mesh.triangles.clone(), TriMeshFlags::ORIENTED)
        .or_else(|_| TriMesh::new(vertices(), mesh.triangles.clone()))
        .map_err(|e| e.to_string())?;
    let project = |p: &[f32; 3]| {
        let point = Vector::from_array(*p);
        let found = mesh.project_local_point(point, false);
        let distance = (found.point - point).length();
        if found.is_inside { -distance } else { distance }
    };
    let mut theirs = vec![0.0_f32; points.len()];
    let time = fastest(points.len(), || {
        pool.install(|| {
            theirs
                .par_iter_mut()
                .zip(points)
                .with_min_len(4096)
                .for_each(|(to, p)| *to = project(p));
        });
    });
    println!("  parry3d, signed distance   {time:7.3} us/point");

    // intertri's distances are within an f64 ulp of the true ones, so they serve as the reference
    // for parry3d's.
    let (mut signs, mut worst) = (0, 0.0_f64);
    for (&theirs, &ours) in theirs.iter().zip(&signed) {
        signs += usize::from((theirs < 0.0) != (ours < 0.0));
        worst = worst.max((f64::from(theirs).abs() - ours.abs()).abs() / ours.abs().max(1e-300));
    }
    let said = if closed { "closed" } else { "open, so signs are not meaningful" };
    println!(
        "  parry3d: {signs} signs differ (the mesh is {said}); largest relative error {worst:.1e}"
    );
    Ok(())
}

fn write_down(path: &Path, mesh: &Mesh, points: &[[f32; 3]], signed: &[f64]) -> Result<(), String> {
    use std::fmt::Write;
    let mut obj = String::new();
    for [x, y, z] in &mesh.positions {
        let _ = writeln!(obj, "v {x} {y} {z}");
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    let points: Vec<u8> = points.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let signed: Vec<u8> = signed.iter().flat_map(|x| x.to_le_bytes()).collect();
    crate::write(&path.with_extension("obj"), obj.as_bytes())?;
    crate::write(&path.with_extension("points"), &points)?;
    crate::write(&path.with_extension("distances"), &signed)
}
