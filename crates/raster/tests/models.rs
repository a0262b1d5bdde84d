//! Compares the z-buffer with rays, and shadow volumes with shadow rays, in whole scenes at
//! 1024×768.

use crate::common::{rays_of, view_of};
use intertri::{Hit, Mode, Ray, Threshold};
use intertri_raster::{
    Adjacency, Light, Verdict, Volume, differences, lit, shadow_differences, triangles,
};
use intertri_scene::{Light as Lamp, Scene, hit_point, load, shade};
use intertri_trace::Bvh;

/// Draws and traces a scene, and compares the images and the shadows. Only a few pixels may differ,
/// each for a known reason, because a rule that excused many differences could hide an error.
fn check(name: &str, scene: &Scene) {
    let (width, height) = (1024, 768);
    let soup = scene.mesh.to_triangles();
    let view = view_of(&scene.camera, width, height);
    let drawn = triangles(&view, &soup, Threshold::DEFAULT.get());

    let bvh = Bvh::new(&soup).unwrap();
    let rays = rays_of(&scene.camera, width, height);
    let mut traced = vec![Hit::MISS; rays.len()];
    bvh.query().mode(Mode::certified()).closest_batch_into(&rays, &mut traced);
    let seen = differences(&view, &soup, &drawn, &traced);

    let adjacency = Adjacency::new(&soup);
    let position = scene.light.origin([0.0; 3]);
    let light = Light::Point { position, reach: f64::from(Lamp::REACH) };
    let volume = Volume::new(&adjacency, light).unwrap();
    let counted = lit(&view, &traced, &volume);
    let shadow_rays: Vec<Ray> = rays
        .iter()
        .zip(&traced)
        .map(|(ray, hit)| scene.light.shadow_ray(hit_point(ray, hit)))
        .collect();
    let mut blocked = vec![false; rays.len()];
    bvh.query().mode(Mode::certified()).any_batch_into(&shadow_rays, &mut blocked);
    let by_rays: Vec<bool> = blocked.iter().map(|blocked| !blocked).collect();
    let shadows = shadow_differences(&view, &traced, &volume, &counted, &by_rays);

    let count = |of: &[Verdict], wanted| of.iter().filter(|&&verdict| verdict == wanted).count();
    let covered = drawn.iter().filter(|hit| hit.is_hit()).count();
    let dark = counted.iter().filter(|lit| !**lit).count();
    println!(
        "{name}: {} triangles, {covered} pixels covered, {} excused, {} not; {} silhouette edges, {dark} pixels dark, {} excused, {} not",
        soup.len(),
        count(&seen, Verdict::Excused),
        count(&seen, Verdict::Unexcused),
        volume.silhouette().len(),
        count(&shadows, Verdict::Excused),
        count(&shadows, Verdict::Unexcused),
    );
    assert!(covered > 50_000 && dark > 5_000, "{name}");
    for verdicts in [&seen, &shadows] {
        assert_eq!(count(verdicts, Verdict::Unexcused), 0, "{name}");
        assert!(count(verdicts, Verdict::Excused) < 50, "{name}");
    }

    // With the same texture coordinates, colours differ only by rounding, except at texel borders.
    if scene.texture.is_some() {
        let [one, other] = [&drawn, &traced]
            .map(|hits| shade(scene, width, height, hits, &by_rays).unwrap().pixels().to_vec());
        let far = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|k| a[k].abs_diff(b[k]) > 1);
        let differ = one.iter().zip(&other).filter(|&pair| far(pair)).count();
        assert!(differ < 20, "{name}: {differ}");
    }

    // The rule does not excuse everything: rows that are shifted by one pixel are detected.
    let mut shifted = traced.clone();
    let middle = width as usize * 380..width as usize * 400;
    shifted[middle].rotate_right(1);
    let found = differences(&view, &soup, &drawn, &shifted);
    assert!(count(&found, Verdict::Unexcused) > 100, "{name}");
}

#[test]
fn the_built_in_scene() {
    check("built in", &Scene::built_in());
}

#[test]
fn the_models() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/models");
    let folder = std::env::var("INTERTRI_MODELS").unwrap_or(beside.into());
    for name in ["suzanne", "spot", "teapot", "fandisk", "stanford-bunny", "kitchen"] {
        let path = std::path::Path::new(&folder).join(name).with_extension("obj");
        if !path.exists() {
            println!("{}: not found, skipped", path.display());
            continue;
        }
        check(name, &Scene::of(load(&path).unwrap(), 1024.0 / 768.0).unwrap());
    }
}
