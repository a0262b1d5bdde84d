//! Compares the hierarchy with a plain loop, down to the bits of t: closest hits, any hits and all
//! hits, one ray at a time and in batches.

use crate::scene::Scene;
use crate::truth::Truth;
use crate::{TrueMode, at, bits, same_closest};
use intertri::simd::Level;
use intertri::{Hit, Mode, Threshold};
use intertri_trace::{Bvh, MeshTriangle};

/// Runs every query of the hierarchy for every ray of a scene, in every mode. Returns the number of
/// rays that hit something, according to the reference.
///
/// # Errors
/// Returns an error that describes the first difference.
pub fn check_hierarchy(scene: &Scene, levels: &[Level]) -> Result<usize, String> {
    let truths = [Truth::of(scene), Truth::exact(scene), Truth::once(scene)];
    let bvh = Bvh::new(&scene.triangles).map_err(|e| e.to_string())?;
    let threshold = Threshold::new(scene.threshold).map_err(|e| e.to_string())?;
    let certified = (Mode::certified_with(threshold), "certified", &truths[0]);
    let mut hits = 0;
    for &level in levels {
        check_mode(scene, &bvh, at((Mode::exact(), "exact", &truths[1]), level))?;
        check_mode(scene, &bvh, at((Mode::once(), "once", &truths[2]), level))?;
        hits = check_mode(scene, &bvh, at(certified, level))?;
    }
    Ok(hits)
}

fn check_mode(
    scene: &Scene,
    bvh: &Bvh,
    (mode, name, truth): TrueMode<'_>,
) -> Result<usize, String> {
    let rays = &scene.rays;
    // Use one query for all rays, so that its scratch memory is reused.
    let mut query = bvh.query().mode(mode);
    let (closest, any) = (query.closest_batch(rays), query.any_batch(rays));
    let limits = [None, Some(0), Some(1), Some(3), Some(usize::MAX)];
    let mut lists = vec![];
    for limit in limits {
        lists.push((limit, query.all_batch(rays, limit).map_err(|e| e.to_string())?));
    }
    for (i, ray) in rays.iter().enumerate() {
        let answers = &truth.answers[i];
        let want = answers.closest;
        let of = |query: &str, e: String| {
            format!("{name} {} {query}, ray {i}: {e}\n{ray:?}", mode.level().name())
        };
        same_closest(want, closest[i].some()).map_err(|e| of("closest batch", e))?;
        let one = bvh.query().mode(mode).closest(ray);
        same_closest(want, one).map_err(|e| of("closest", e))?;
        if let (Some((u, v)), Some(one)) = (answers.weights, one)
            && [one.u, one.v].map(f64::to_bits) != [u, v].map(f64::to_bits)
        {
            return Err(of("weights", format!("{}, {} are not {u}, {v}", one.u, one.v)));
        }
        if bits(one.unwrap_or(Hit::MISS)) != bits(closest[i]) {
            return Err(of("closest batch", format!("{:?} is not {one:?}", closest[i])));
        }
        let kept = (query.closest(ray), query.closest_triangle(ray), query.any(ray));
        let name = |hit: Hit| MeshTriangle { triangle: hit.triangle, geometry: hit.geometry };
        let plain = (one.map(bits), one.map(name), one.is_some());
        if (kept.0.map(bits), kept.1, kept.2) != plain {
            return Err(of("kept query", format!("{kept:?} differs from {one:?}")));
        }
        if any[i] != want.is_some() || bvh.query().mode(mode).any(ray) != want.is_some() {
            return Err(of("any", format!("differs from {want:?}")));
        }
        let all = query.all(ray);
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
