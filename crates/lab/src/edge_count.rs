//! Checks the kernel's guarantees on a very large number of rays toward shared edges and vertices.

use intertri::fixed::{self, Bits, Fixed, Grid};
use intertri::{Mode, TriangleBlock};
use intertri_reference as reference;
use rayon::prelude::*;
use serde::Serialize;

use crate::rng::Rng;
use crate::test_batch::TestBatch;
use crate::workloads::closed_mesh;

/// The result of a check: the numbers of errors found, and the numbers of rays and pairs checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EdgeCount {
    /// The number of rays for each mode. Half of the rays pass exactly through a vertex or a point
    /// on an edge of a closed mesh; the other half pass within a rounding error of one.
    pub rays: u64,
    /// The number of ray/triangle pairs that `certified` tested.
    pub pairs: u64,
    /// The number of tested pairs for which `certified` differs from the reference implementation,
    /// either in whether there is a hit or in any bit of `t`.
    pub not_reference: u64,
    /// The number of rays for which `fixed` finds no crossing.
    pub leaks: u64,
    /// The number of rays for which `fixed` finds more than one crossing.
    pub doubles: u64,
}

const PIECE: u64 = 4096;

/// Checks at least `rays` rays. Calls `step` with the number of rays just completed. The counts
/// depend only on the seed and the number of rays.
pub fn edge_count(seed: u64, rays: u64, step: &(impl Fn(u64) + Sync)) -> EdgeCount {
    let piece = |piece: u64| {
        let mut rng = Rng::new(seed ^ piece << 16);
        let near = piece % 2 == 1;
        let mut count = EdgeCount::default();
        certified(&batch(&mut rng, 18, near), &mut count);
        fixed(&batch(&mut rng, 15, near), &mut count);
        step(PIECE);
        count
    };
    let sum = |a: EdgeCount, b: EdgeCount| EdgeCount {
        rays: a.rays + b.rays,
        pairs: a.pairs + b.pairs,
        not_reference: a.not_reference + b.not_reference,
        leaks: a.leaks + b.leaks,
        doubles: a.doubles + b.doubles,
    };
    (0..rays.div_ceil(PIECE)).into_par_iter().map(piece).reduce(EdgeCount::default, sum)
}

/// Generates rays exactly at edges and vertices. If `near`, scales all coordinates, which rounds
/// them, so that the rays only pass close to the edges and vertices.
fn batch(rng: &mut Rng, bits: u32, near: bool) -> TestBatch {
    let mut batch = closed_mesh(rng, bits, PIECE as usize);
    if near {
        let scale = (0.5 + rng.unit()) as f32;
        for x in batch.triangles.iter_mut().flat_map(|t| t.0.as_flattened_mut()) {
            *x *= scale;
        }
        for ray in &mut batch.rays {
            ray.origin = ray.origin.map(|x| x * scale);
            ray.dir = ray.dir.map(|x| x * scale);
        }
    }
    batch
}

/// Compares `certified` with the reference, bit for bit.
fn certified(batch: &TestBatch, count: &mut EdgeCount) {
    let mode = Mode::certified();
    let scene = reference::Scene::from_triangles(batch.triangles.iter().map(|t| t.0));
    let blocks: Vec<TriangleBlock<8>> = batch.triangles.chunks(8).map(TriangleBlock::new).collect();
    for ray in &batch.rays {
        let line = reference::Ray::new(ray.origin, ray.dir);
        for (k, block) in blocks.iter().enumerate() {
            let hits = mode.block(ray, block);
            for lane in 0..8.min(batch.triangles.len() - 8 * k) {
                let expected = scene.hit(8 * k + lane, &line, 0.0, f64::INFINITY);
                let got = (hits.bits >> lane & 1 == 1).then_some(hits.t[lane]);
                let same = expected.map(f64::to_bits) == got.map(f64::to_bits);
                count.not_reference += u64::from(!same);
                count.pairs += 1;
            }
        }
        count.rays += 1;
    }
}

/// Counts the rays for which `fixed` does not find exactly one crossing, although each ray leaves a
/// closed convex mesh once.
fn fixed(batch: &TestBatch, count: &mut EdgeCount) {
    let origins = batch.rays.iter().map(|ray| ray.origin);
    let points = batch.triangles.iter().flat_map(|t| t.0).chain(origins);
    let crossings = || {
        let grid = Grid::around(points, Bits::FINE)?;
        let triangles: Result<Vec<_>, _> =
            batch.triangles.iter().map(|t| grid.triangle(t)).collect();
        let blocks = fixed::blocks(&triangles?);
        let mode = Fixed::default();
        let count = |ray| Ok(mode.crossings(&blocks, &grid.ray(ray)?).unsigned);
        batch.rays.iter().map(count).collect::<Result<Vec<_>, fixed::GridError>>()
    };
    // If the grid cannot represent the input, count every ray as a leak.
    let crossings = crossings().unwrap_or_else(|_| vec![0; batch.rays.len()]);
    count.leaks += crossings.iter().filter(|&&n| n == 0).count() as u64;
    count.doubles += crossings.iter().filter(|&&n| n > 1).count() as u64;
}

#[cfg(test)]
mod tests {
    use super::{EdgeCount, batch, edge_count};
    use crate::oracle::{self, LinePosition};
    use crate::rng::Rng;

    fn kept(count: &EdgeCount) {
        assert_eq!((count.not_reference, count.leaks, count.doubles), (0, 0, 0), "{count:?}");
    }

    #[test]
    fn the_promises_hold_on_a_hundred_thousand_rays() {
        let count = edge_count(3, 100_000, &|_| ());
        kept(&count);
        assert!(count.rays >= 100_000 && count.pairs >= 48 * count.rays);
        assert_eq!(count, edge_count(3, 100_000, &|_| ()));
    }

    #[test]
    #[ignore = "minutes: a hundred million rays"]
    fn the_promises_hold_on_a_hundred_million_rays() {
        let count = edge_count(5, 100_000_000, &|_| ());
        println!("{count:?}");
        kept(&count);
    }

    #[test]
    fn the_rays_are_where_they_are_said_to_be() {
        // Check with the oracle that each ray meets exactly the triangles around one edge or
        // vertex.
        for bits in [15, 18] {
            let batch = batch(&mut Rng::new(9), bits, false);
            for ray in &batch.rays {
                let places = batch.triangles.iter().map(|t| oracle::answer(t, ray));
                let met: Vec<LinePosition> =
                    places.filter(|t| t.is_hit()).map(|t| t.place).collect();
                let at_side =
                    |p: &LinePosition| matches!(p, LinePosition::Edge(_) | LinePosition::Vertex(_));
                assert!(met.len() >= 2 && met.iter().all(at_side), "{met:?}");
            }
        }
    }
}
