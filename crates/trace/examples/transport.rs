//! Traces particles through concrete, steel, and water at UTM coordinates:
//! `cargo run --release --example transport 10000000`.
//!
//! A particle flies straight until it collides and is either absorbed or scattered. A third of the
//! particles are aimed exactly at corners, and a third at edges. A particle is lost if the medium
//! of a segment differs from the medium at the segment's midpoint, if the particle's path has a
//! gap, or if the path does not end outside. Points that are closer to a wall than the spacing of
//! adjacent coordinates may be rounded to the other side of the wall, so they are counted
//! separately.

use std::f64::consts::TAU;
use std::time::Instant;

use intertri::{Ray64, Triangle64};
use intertri_trace::{Media, MediaError};

const CONCRETE: u32 = 0;
const STEEL: u32 = 1;
const WATER: u32 = 2;

/// Collisions per metre in each medium.
const PER_METRE: [f64; 3] = [1.5, 6.0, 2.0];
/// The fraction of collisions that absorb the particle.
const ABSORBED: f64 = 0.5;

/// A corner of the site, in metres.
const SITE: [f64; 3] = [500_123.0, 4_649_776.0, 311.0];

/// Points closer to a wall than this distance may be rounded to the other side of the wall. The
/// distance is larger than the rounding error of coordinates.
const BESIDE: f64 = 1e-8;

/// Returns a pseudorandom number in `0..1`.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Rounds a number to a grid, so that differences are exact.
fn on_grid(x: f64) -> f64 {
    (x * 1024.0).round() / 1024.0
}

fn globe(rings: usize, middle: [f64; 3], radius: f64) -> Vec<Triangle64> {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f64 / rings as f64, (i % (2 * rings)) as f64 / rings as f64);
        let (a, b) = (0.5 * TAU * a, 0.5 * TAU * b);
        let r = if ring.is_multiple_of(rings) { 0.0 } else { a.sin() };
        let unit = [r * b.cos(), a.cos(), r * b.sin()];
        [0, 1, 2].map(|k| SITE[k] + on_grid(middle[k] + radius * unit[k]))
    };
    let squares = (0..2 * rings * rings).map(|k| (k / (2 * rings), k % (2 * rings)));
    let halves = squares.flat_map(|(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [Triangle64::new(a, b, c), Triangle64::new(d, c, b)]
    });
    halves.collect()
}

fn block(low: [f64; 3], high: [f64; 3]) -> Vec<Triangle64> {
    let corner = |i: usize| [0, 1, 2].map(|k| SITE[k] + [low, high][i >> k & 1][k]);
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|face| Triangle64(face.map(corner))).collect()
}

/// Counts of what happened to the particles.
#[derive(Default)]
struct Tally {
    segments: usize,
    absorbed: [usize; 3],
    escaped: usize,
    beside_walls: usize,
    lost: usize,
}

fn direction(state: &mut u64) -> [f64; 3] {
    let (z, angle) = (2.0 * random(state) - 1.0, TAU * random(state));
    let r = (1.0 - z * z).sqrt();
    [r * angle.cos(), r * angle.sin(), z]
}

fn along(ray: &Ray64, t: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| ray.origin[k] + t * ray.dir[k])
}

/// Moves particles to their next collision and returns the rays of the scattered particles.
fn fly(media: &Media<f64>, rays: &[Ray64], state: &mut u64, tally: &mut Tally) -> Vec<Ray64> {
    let paths = media.segments_batch(rays).expect("not enough memory for a batch");
    let (mut scattered, mut points, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    for (ray, path) in rays.iter().zip(paths.iter()) {
        let length = ray.dir.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut left = -(1.0 - random(state)).ln();
        let mut collision = None;
        let mut at = 0.0;
        for segment in path {
            tally.segments += 1;
            tally.lost += usize::from(segment.start != at);
            at = segment.end;
            let Some(medium) = segment.medium else { continue };
            points.push(along(ray, 0.5 * (segment.start + segment.end)));
            expected.push(segment.medium);
            let flown = left / PER_METRE[medium as usize] / length;
            if collision.is_none() && segment.start + flown < segment.end {
                collision = Some((medium, segment.start + flown));
            }
            left -= (segment.end - segment.start) * length * PER_METRE[medium as usize];
        }
        tally.lost +=
            usize::from(at != f64::INFINITY || path.last().is_none_or(|s| s.medium.is_some()));
        match collision {
            None => tally.escaped += 1,
            Some((medium, _)) if random(state) < ABSORBED => tally.absorbed[medium as usize] += 1,
            Some((medium, t)) => {
                let ray = Ray64::new(along(ray, t), direction(state));
                points.push(ray.origin);
                expected.push(Some(medium));
                scattered.push(ray);
            }
        }
    }
    let found = media.medium_at_batch(&points).expect("not enough memory for a batch");
    for i in (0..points.len()).filter(|&i| found[i] != expected[i]) {
        let is_beside = media.bvh().closest_point(points[i], BESIDE).is_some();
        *(if is_beside { &mut tally.beside_walls } else { &mut tally.lost }) += 1;
    }
    scattered
}

fn main() -> Result<(), MediaError<f64>> {
    let count = std::env::args().nth(1).map_or(100_000, |count| {
        count.parse().expect("the argument must be a number of particles")
    });
    // Two blocks that share a wall, a steel sphere that reaches into both, and water inside the
    // sphere.
    let meshes = [
        (CONCRETE, block([0.0, 0.0, 0.0], [2.0, 2.0, 2.0])),
        (CONCRETE, block([2.0, 0.0, 0.0], [4.0, 2.0, 2.0])),
        (STEEL, globe(24, [2.0, 1.0, 1.0], 0.75)),
        (WATER, globe(24, [2.0, 1.0, 1.0], 0.5)),
    ];
    let media = Media::new(&meshes.each_ref().map(|(medium, mesh)| (*medium, &mesh[..])))?;
    let triangles: Vec<Triangle64> = meshes.iter().flat_map(|(_, mesh)| mesh).copied().collect();

    let (began, mut state, mut tally) = (Instant::now(), 57, Tally::default());
    for first in (0..count).step_by(1 << 16) {
        let particle = |i: usize| {
            let origin = [0, 1, 2]
                .map(|k| SITE[k] + on_grid(0.5 * random(&mut state)) + [1.75, 0.75, 0.75][k]);
            let number = (random(&mut state) * triangles.len() as f64) as usize;
            let [a, b, _] = triangles[number].0;
            let target = match i % 3 {
                0 => a,
                1 => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
                _ => return Ray64::new(origin, direction(&mut state)),
            };
            Ray64::new(origin, [0, 1, 2].map(|k| target[k] - origin[k]))
        };
        let mut rays: Vec<Ray64> = (first..count.min(first + (1 << 16))).map(particle).collect();
        while !rays.is_empty() {
            rays = fly(&media, &rays, &mut state, &mut tally);
        }
    }
    let Tally { segments, absorbed, escaped, beside_walls, lost } = tally;
    println!("{count} particles, {segments} segments in {:.1} s", began.elapsed().as_secs_f64());
    println!("absorbed in concrete, steel, water: {absorbed:?}; escaped: {escaped}");
    println!("{beside_walls} points rounded across a wall; {lost} particles lost");
    assert!(lost == 0 && absorbed.iter().sum::<usize>() + escaped == count);
    Ok(())
}
