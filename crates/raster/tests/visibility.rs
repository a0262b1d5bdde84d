//! The z-buffer against the rays, on every shared model.

use std::time::Instant;

use intertri::{Certified, Hit, Ray, Threshold};
use intertri_raster::{
    Adjacency, Light, Verdict, View, Volume, differences, lit, shadow_differences, triangles,
};
use intertri_scene::{Camera, Scene, hit_point, load};
use intertri_trace::Bvh;

pub fn view(camera: &Camera, width: u32, height: u32) -> View {
    View::new(camera.eye(), camera.axes(), camera.half_height(), width, height).unwrap()
}

fn check(name: &str, scene: &Scene, width: u32, height: u32) {
    let camera = &scene.camera;
    let soup = scene.mesh.to_triangles();
    let view = view(camera, width, height);
    let start = Instant::now();
    let drawn = triangles(&view, &soup, Threshold::DEFAULT.get());
    let took = start.elapsed();

    let rays: Vec<Ray> = (0..height)
        .flat_map(|y| (0..width).map(move |x| camera.ray(x, y, width, height)))
        .collect();
    let mut traced = vec![Hit::MISS; rays.len()];
    let bvh = Bvh::new(&soup).unwrap();
    let start = Instant::now();
    bvh.closest_of_each(&Certified::default(), &rays, &mut traced);
    let rays_took = start.elapsed();

    let verdicts = differences(&view, &soup, &drawn, &traced);
    let count = |wanted| verdicts.iter().filter(|&&v| v == wanted).count();
    let covered = drawn.iter().filter(|h| h.is_hit()).count();
    println!(
        "{name}: {} triangles, {covered} covered, {} excused, {} unexcused, tolerance {:.2e}, raster {took:?}, rays {rays_took:?}",
        soup.len(),
        count(Verdict::Excused),
        count(Verdict::Unexcused),
        view.tolerance()
    );
    let mut worst: [f64; 3] = [0.0; 3];
    for ((a, b), ray) in drawn.iter().zip(&traced).zip(&rays) {
        if a.is_hit() && a.triangle == b.triangle {
            let tri = soup[a.triangle as usize].0.map(|c| c.map(f64::from));
            let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
            let cross = |a: [f64; 3], b: [f64; 3]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let n = cross(sub(tri[1], tri[0]), sub(tri[2], tri[0]));
            let cos = dot(n, ray.dir.map(f64::from)).abs() / dot(n, n).sqrt();
            worst[0] = worst[0].max((a.t - b.t).abs() / b.t * cos);
            worst[1] = worst[1].max((a.u - b.u).abs());
            worst[2] = worst[2].max((a.v - b.v).abs());
        }
    }
    println!("   worst relative t * cos {:.2e}, u {:.2e}, v {:.2e}", worst[0], worst[1], worst[2]);
    for (i, v) in verdicts.iter().enumerate().filter(|(_, v)| **v == Verdict::Unexcused).take(5) {
        println!(
            "   {v:?} {} {}: {:?} {:?}",
            i as u32 % width,
            i as u32 / width,
            drawn[i],
            traced[i]
        );
    }
    shadows(name, scene, &view, &rays, &traced, &soup, &bvh);
    assert_eq!(count(Verdict::Unexcused), 0, "{name}");
    assert!(worst[0] < 2e-7, "{name}: {worst:?}");
}

fn shadows(
    name: &str,
    scene: &Scene,
    view: &View,
    rays: &[Ray],
    hits: &[Hit],
    soup: &[intertri::Triangle],
    bvh: &Bvh,
) {
    let adjacency = Adjacency::new(soup);
    let light = Light::Point {
        position: scene.light.position,
        reach: f64::from(intertri_scene::Light::REACH),
    };
    let volume = Volume::new(&adjacency, light).unwrap();
    let start = Instant::now();
    let mask = lit(view, hits, &volume);
    let took = start.elapsed();
    let start = Instant::now();
    let shadow: Vec<Ray> =
        rays.iter().zip(hits).map(|(r, h)| scene.light.shadow_ray(hit_point(r, h))).collect();
    let mut traced = vec![false; shadow.len()];
    bvh.any_of_each(&Certified::default(), &shadow, &mut traced);
    let traced: Vec<bool> = traced.iter().zip(hits).map(|(b, h)| !b || !h.is_hit()).collect();
    let rays_took = start.elapsed();
    let verdicts = shadow_differences(view, hits, &volume, &mask, &traced);
    let count = |wanted| verdicts.iter().filter(|&&v| v == wanted).count();
    println!(
        "   shadows: {} points, {} silhouette edges, {} dark, {} excused, {} unexcused, volumes {took:?}, rays {rays_took:?}",
        adjacency.points().len(),
        volume.silhouette().len(),
        mask.iter().filter(|l| !**l).count(),
        count(Verdict::Excused),
        count(Verdict::Unexcused)
    );
    for (i, v) in verdicts.iter().enumerate().filter(|(_, v)| **v == Verdict::Unexcused).take(5) {
        println!(
            "   {v:?} {} {}: {:?} {:?} {:?}",
            i as u32 % view.width(),
            i as u32 / view.width(),
            hits[i],
            mask[i],
            traced[i]
        );
    }
    let _ = name;
}

#[test]
fn the_built_in_scene() {
    check("built in", &Scene::built_in(), 1024, 768);
}

#[test]
fn the_models() {
    let folder = std::env::var("INTERTRI_MODELS")
        .unwrap_or(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/models").into());
    for name in ["suzanne", "spot", "teapot", "fandisk", "stanford-bunny", "kitchen"] {
        let path = std::path::Path::new(&folder).join(name).with_extension("obj");
        if !path.exists() {
            println!("no {}: not tested", path.display());
            return;
        }
        let scene = Scene::of(load(&path).unwrap(), 1024.0 / 768.0).unwrap();
        check(name, &scene, 1024, 768);
    }
}
