//! The hierarchy against a plain loop: index, bits of t, any, all, batches.

use crate::scene::Scene;
use crate::truth::Truth;
use crate::{bits, same_closest};
use intertri::simd::Level;
use intertri::{Certified, Double, Exact, Hit, Mode, Threshold};
use intertri_trace::Bvh;

/// Every query of the hierarchy about every ray of a scene, in every mode; how many rays hit the reference.
///
/// # Errors
/// The first difference.
pub fn check_hierarchy(scene: &Scene, levels: &[Level]) -> Result<usize, String> {
    let (truth, exact) = (Truth::of(scene), Truth::exact(scene));
    let bvh = Bvh::new(&scene.triangles).map_err(|e| e.to_string())?;
    let threshold = Threshold::new(scene.threshold).map_err(|e| e.to_string())?;
    let mut hits = 0;
    for &level in levels {
        check_mode(scene, &truth, &bvh, &Double::new(threshold).at(level), "double")?;
        check_mode(scene, &exact, &bvh, &Exact::at(level), "exact")?;
        hits = check_mode(scene, &truth, &bvh, &Certified::new(threshold).at(level), "certified")?;
    }
    Ok(hits)
}

fn check_mode<M: Mode>(
    scene: &Scene,
    truth: &Truth,
    bvh: &Bvh,
    mode: &M,
    name: &str,
) -> Result<usize, String> {
    let rays = &scene.rays;
    let (mut closest, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
    bvh.closest_batch(mode, rays, &mut closest);
    bvh.any_batch(mode, rays, &mut any);
    let limits = [None, Some(0), Some(1), Some(3), Some(usize::MAX)];
    let mut lists = vec![];
    for limit in limits {
        lists.push((limit, bvh.all_batch(mode, rays, limit).map_err(|e| e.to_string())?));
    }
    let mut intersector = bvh.intersector(mode);
    for (i, ray) in rays.iter().enumerate() {
        let answers = &truth.answers[i];
        let want = answers.closest;
        let of = |query: &str, e: String| {
            format!("{name} {} {query}, ray {i}: {e}\n{ray:?}", mode.level().name())
        };
        same_closest(want, closest[i].some()).map_err(|e| of("closest batch", e))?;
        let one = bvh.closest(mode, ray);
        same_closest(want, one).map_err(|e| of("closest", e))?;
        if let (Some((u, v)), Some(one)) = (answers.weights, one)
            && [one.u, one.v].map(f64::to_bits) != [u, v].map(f64::to_bits)
        {
            return Err(of("weights", format!("{}, {} are not {u}, {v}", one.u, one.v)));
        }
        if bits(one.unwrap_or(Hit::MISS)) != bits(closest[i]) {
            return Err(of("closest batch", format!("{:?} is not {one:?}", closest[i])));
        }
        let kept = (intersector.closest(ray), intersector.triangle(ray), intersector.any(ray));
        let plain = (one.map(bits), one.map(|hit| hit.triangle), one.is_some());
        if (kept.0.map(bits), kept.1, kept.2) != plain {
            return Err(of("intersector", format!("{kept:?} is not that of {one:?}")));
        }
        if any[i] != want.is_some() || bvh.any(mode, ray) != want.is_some() {
            return Err(of("any", format!("is not that of {want:?}")));
        }
        let all = bvh.all(mode, ray);
        for (limit, lists) in &lists {
            let some = &all[..all.len().min(limit.unwrap_or(usize::MAX))];
            if !lists.of(i).iter().copied().map(bits).eq(some.iter().copied().map(bits)) {
                let got = lists.of(i);
                return Err(of("all batch", format!("{limit:?}: {got:?} is not {some:?}")));
            }
        }
        let all: Vec<_> = all.iter().map(|h| (h.triangle as usize, h.t.to_bits())).collect();
        if all != answers.all {
            return Err(of("all", format!("{all:x?} is not {:x?}", answers.all)));
        }
    }
    Ok(closest.iter().filter(|hit| hit.is_hit()).count())
}
