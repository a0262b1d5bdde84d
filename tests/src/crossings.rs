//! Compares the `fixed` mode and the *once* rule of the kernel with the scalar i128 reference: single
//! rays, packets and blocks, at every width and every SIMD level.

use intertri::fixed::{Fixed, Ray, Triangle, blocks};
use intertri::simd::{Lane, Level, Width};
use intertri::{Blocks, Crossings, Hit, Mode, PreparedTriangle, RayPacket, TriangleBlock};

use crate::grid_reference::{Crossing, crossing};

/// The reference's result for each ray and triangle.
type Answers = [[Option<Crossing>; 8]; 8];

/// Compares the result for every ray and triangle. Returns the number of pairs in which the ray
/// crosses the triangle.
///
/// # Errors
/// Returns an error that describes the first difference.
pub fn check_crossings(rays: &[Ray; 8], triangles: &[Triangle; 8]) -> Result<usize, String> {
    let answers = rays.map(|ray| triangles.map(|triangle| crossing(&ray, &triangle)));
    let all = blocks(triangles);
    for level in Level::all() {
        for (ray, answers) in rays.iter().zip(&answers) {
            one_ray(Fixed::at(level), &all, ray, answers)
                .map_err(|why| format!("{} {why}\n{ray:?}\n{triangles:?}", level.name()))?;
        }
        let mode = Mode::once().at(level);
        for result in [
            lanes::<4>(mode, rays, triangles, &answers),
            lanes::<8>(mode, rays, triangles, &answers),
            lanes::<16>(mode, rays, triangles, &answers),
        ] {
            result.map_err(|why| format!("{} {why}\n{rays:?}\n{triangles:?}", level.name()))?;
        }
    }
    Ok(answers.as_flattened().iter().flatten().count())
}

/// Compares the queries of one ray over all triangles.
fn one_ray(
    fixed: Fixed,
    all: &Blocks,
    ray: &Ray,
    answers: &[Option<Crossing>; 8],
) -> Result<(), String> {
    let mut want: Vec<_> = answers.iter().zip(0..).filter_map(|(a, i)| Some(((*a)?, i))).collect();
    want.sort_unstable_by_key(|(crossing, index)| (crossing.t, *index));
    let hits: Vec<Hit> = want.iter().map(|(crossing, i)| crossing.to_hit(ray, *i)).collect();
    let mut count = Crossings::default();
    for (crossing, _) in &want {
        count.add(crossing.leaves);
    }

    let found = (fixed.closest(all, ray), fixed.any(all, ray), fixed.all(all, ray));
    let expected = (hits.first().copied(), !hits.is_empty(), hits);
    if found != expected {
        return Err(format!("one ray: found {found:?}\n expected {expected:?}"));
    }
    let counted = fixed.crossings(all, ray);
    if counted == count { Ok(()) } else { Err(format!("counted {counted:?} instead of {count:?}")) }
}

/// Compares packets of N rays with each triangle, and each ray with blocks of N triangles.
fn lanes<const N: usize>(
    mode: Mode,
    rays: &[Ray; 8],
    triangles: &[Triangle; 8],
    answers: &Answers,
) -> Result<(), String>
where
    Lane<N>: Width,
{
    let lines = rays.map(|ray| *ray.to_f32());
    let corners = triangles.map(|triangle| triangle.to_f32());
    // The bits of t, or `None` for a miss.
    let t = |answer: &Option<Crossing>| answer.map(|crossing| crossing.t.to_f64(0).to_bits());
    for first in (0..8).step_by(N) {
        let last = 8.min(first + N);
        let packet = RayPacket::<N>::new(&lines[first..last]);
        for (i, triangle) in corners.iter().enumerate() {
            let hits = mode.packet(&packet, &PreparedTriangle::new(triangle));
            for (lane, answers) in answers[first..last].iter().enumerate() {
                let found = (hits.bits >> lane & 1 != 0).then(|| hits.t[lane].to_bits());
                if found != t(&answers[i]) {
                    return Err(format!("packet {N}, ray {}, triangle {i}", first + lane));
                }
            }
        }
        let block = TriangleBlock::<N>::new(&corners[first..last]);
        for (i, line) in lines.iter().enumerate() {
            let hits = mode.block(line, &block);
            for (lane, answer) in answers[i][first..last].iter().enumerate() {
                let found = (hits.bits >> lane & 1 != 0).then(|| hits.t[lane].to_bits());
                if found != t(answer) {
                    return Err(format!("block {N}, ray {i}, triangle {}", first + lane));
                }
            }
        }
    }
    Ok(())
}
