//! The scenes for which golden answers are computed.

use intertri::{Ray, Threshold, Triangle};
use intertri_lab::families::FAMILIES;
use intertri_lab::meshes::Mesh;
use intertri_lab::rng::Rng;

/// A named set of triangles and rays.
pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) rays: Vec<Ray>,
    pub(crate) threshold: Threshold,
    /// Whether the triangles form a closed mesh.
    pub(crate) closed: bool,
}

/// Returns triangles and rays from every family, and closed meshes with rays from one origin, some
/// of them toward vertices and edges.
pub(crate) fn scenes() -> Vec<Scene> {
    let mut scenes = vec![];
    for family in FAMILIES {
        let scene = family.scene(&mut Rng::new(11), 60, 40);
        let threshold =
            Threshold::new(scene.threshold).expect("the threshold of a family is valid");
        let (triangles, rays) = (scene.triangles, scene.rays);
        scenes.push(Scene { name: family.name.into(), triangles, rays, threshold, closed: false });
    }
    for (name, mesh, eye) in [
        ("sphere", Mesh::icosphere(3), [0.25, 0.1, -0.3]),
        ("sphere from outside", Mesh::icosphere(2), [0.5, 3.0, -2.5]),
    ] {
        let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| v.map(|x| x as f32)).collect();
        let triangles: Vec<Triangle> =
            mesh.faces.iter().map(|face| Triangle(face.map(|i| vertices[i]))).collect();
        let mut rng = Rng::new(12);
        let ray = |i: usize| {
            let [a, b, c] = triangles[i * 7 % triangles.len()].0;
            let at = match i % 4 {
                0 => a,
                1 => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
                2 => [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0),
                _ => rng.direction().map(|x| x as f32),
            };
            Ray::new(eye, [0, 1, 2].map(|k| at[k] - eye[k]))
        };
        let rays = (0..2048).map(ray).collect();
        let (name, threshold) = (name.into(), Threshold::DEFAULT);
        scenes.push(Scene { name, triangles, rays, threshold, closed: true });
    }
    scenes
}
