//! Tests the methods on whole batches of rays and triangles, in every layout and on closed meshes.

use intertri::Ray;
use intertri::simd::Level;
use intertri_reference::THRESHOLD;

use intertri_lab::families::find;
use intertri_lab::layout::{Form, Layout};
use intertri_lab::methods::{METHODS, on_grid};
use intertri_lab::oracle::{self, LinePosition, exact_t};
use intertri_lab::rng::Rng;
use intertri_lab::test_batch::{Answer, ClosestHit, TestBatch};
use intertri_lab::workloads::{Model, Workload};

#[test]
fn watertight_methods_hold_water_and_others_leak() {
    // The rays start inside a closed mesh and meet its edges and vertices exactly. Rays from
    // outside the mesh are skipped, because they can hit it twice.
    let scene = find("icosphere-exact").unwrap().scene(&mut Rng::new(44), 320, 2000);
    let inside = |ray: &&Ray| ray.origin.iter().all(|x| x.abs() <= 0.4);
    let rays: Vec<_> = scene.rays.iter().filter(inside).collect();
    let hits = |name: &str| -> (usize, usize) {
        let method = METHODS.iter().find(|s| s.name == name).unwrap();
        let mut to = vec![Answer::default(); scene.triangles.len()];
        let (mut leaks, mut doubles) = (0, 0);
        for &&ray in &rays {
            method.pairs(Level::best(), THRESHOLD, &scene.triangles, &vec![ray; to.len()], &mut to);
            match to.iter().filter(|answer| answer.hit).count() {
                0 => leaks += 1,
                1 => {}
                _ => doubles += 1,
            }
        }
        (leaks, doubles)
    };
    let n = rays.len();
    assert!(n > 900);
    for name in ["Woop f32", "Embree robust f32"] {
        let (leaks, doubles) = hits(name);
        assert!(leaks == 0 && doubles > n / 20, "{name}: {leaks} {doubles} of {n}");
    }
    for name in ["InterTri f32", "Möller–Trumbore f32", "Embree fast f32"] {
        let (leaks, doubles) = hits(name);
        assert!(leaks > 5 && doubles > n / 50, "{name}: {leaks} {doubles} of {n}");
    }
}

/// Returns batches of every workload. In half of them, the last register is only partly filled,
/// both with rays and with triangles.
fn batches() -> Vec<TestBatch> {
    let (mut rng, model) = (Rng::new(5), Model::built_in());
    let mut all = Vec::new();
    for workload in Workload::ALL {
        for odd in [0, 3] {
            let mut batch = workload.batch(&mut rng, &model);
            batch.rays.truncate(batch.rays.len() - odd);
            batch.triangles.truncate(batch.triangles.len() - odd);
            all.push(batch);
        }
    }
    all
}

#[test]
fn every_layout_finds_the_hits_of_the_pairs() {
    for batch in batches() {
        for method in METHODS.iter().filter(|method| method.name != "fixed") {
            // Find the closest hit and the number of hits of each ray, pair by pair.
            let (mut expected, mut counts) = (Vec::new(), Vec::new());
            for ray in &batch.rays {
                let rays = vec![*ray; batch.triangles.len()];
                let mut to = vec![Answer::default(); rays.len()];
                method.pairs(Level::best(), THRESHOLD, &batch.triangles, &rays, &mut to);
                let mut best = ClosestHit::MISS;
                for (triangle, answer) in (0..).zip(&to) {
                    if answer.hit && answer.t < best.t {
                        best = ClosestHit { t: answer.t, triangle };
                    }
                }
                expected.push(best);
                counts.push(to.iter().filter(|answer| answer.hit).count() as u32);
            }
            // If a ray hits a shared edge, `once` counts only one of the two triangles.
            if method.name != "exact, once" {
                assert_eq!(method.counts(Level::best(), &batch), counts);
            }
            let batches = [batch.clone(), batch.clone()];
            for form in [Form::Packets, Form::Blocks] {
                for lanes in [1, 4, 8, 16] {
                    let mut nearest = Vec::new();
                    let layout = Layout { form, lanes };
                    if method.closest(Level::best(), &batches, layout, &mut nearest).is_some() {
                        let name = method.name;
                        assert_eq!(
                            nearest,
                            [&expected[..], &expected].concat(),
                            "{name} {layout:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn fixed_on_its_grid_agrees_with_the_oracle() {
    let fixed = METHODS.iter().find(|method| method.name == "fixed").unwrap();
    let mut seen = 0;
    for batch in batches().iter().filter_map(on_grid) {
        for (form, lanes) in
            [(Form::Packets, 4), (Form::Packets, 8), (Form::Blocks, 4), (Form::Blocks, 8)]
        {
            let (mut nearest, layout) = (Vec::new(), Layout { form, lanes });
            let batches = std::slice::from_ref(&batch);
            assert!(fixed.closest(Level::best(), batches, layout, &mut nearest).is_some());
            for (ray, nearest) in batch.rays.iter().zip(nearest) {
                // The reported triangle must be hit, and no triangle that is hit in its interior
                // may be nearer.
                for triangle in &batch.triangles {
                    let exact = oracle::answer(triangle, ray);
                    if exact.is_hit() && exact.place == LinePosition::Inside {
                        let t = exact_t(triangle, ray).unwrap().to_f64().value();
                        assert!(nearest.t <= t);
                        seen += 1;
                    }
                }
                if nearest != ClosestHit::MISS {
                    assert!(
                        oracle::answer(&batch.triangles[nearest.triangle as usize], ray).is_hit()
                    );
                }
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
