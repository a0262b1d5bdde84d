//! The `fixed` mode's queries over slices of any length.

use alloc::vec::Vec;
use core::array::from_fn;

use super::{
    Best, Block, Crossing, Grid, GridError, Packet, Prepared, Ray, RayLanes, SeenTriangle, Triangle,
};
use crate::simd::{Level, Simd, WithSimd};
use crate::{Crossings, Hit};

/// The `fixed` mode at a given instruction level. All levels return the same results.
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// // An integer tetrahedron with corners counter-clockwise as seen from outside.
/// let [o, x, y, z] = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
/// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|f| grid.triangle_of(f));
/// let solid: Vec<_> = blocks(&faces.into_iter().collect::<Result<Vec<_>, _>>()?).collect();
///
/// // From inside, the ray leaves through the opposite face.
/// let fixed = Fixed::default();
/// let ray = grid.ray_of([1, 1, 1], [1, 1, 1])?;
/// let count = fixed.crossings(&solid, &ray);
/// assert_eq!((count.signed, count.unsigned), (1, 1));
/// assert!(fixed.any(&solid, &ray) && fixed.contains(&solid, &grid, [1.0, 1.0, 1.0])?);
/// let hits = fixed.all(&solid, &ray);
/// assert_eq!((hits.len(), hits[0].triangle, hits[0].t), (1, 3, 1.0 / 3.0));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// use intertri::{Hit, simd::Level};
/// // The closest hits of many rays at the portable level, which returns the same results.
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let plain = Fixed::at(Level::PORTABLE);
/// assert_eq!(plain.level(), Level::PORTABLE);
/// let walls = [5, 3].map(|z| grid.triangle_of([[0, 0, z], [4, 0, z], [0, 4, z]]).unwrap());
/// let rays = [1, 9].map(|x| grid.ray_of([x, 1, 0], [0, 0, 1]).unwrap());
/// let mut hits = [Hit::MISS; 2];
/// plain.closest_batch(&walls, &rays, &mut hits);
/// assert_eq!(hits.map(|hit| hit.triangle), [1, Hit::NO_TRIANGLE]);
/// // An open sheet does not enclose any point. See the example above for a closed mesh.
/// assert_eq!(plain.winding(&blocks(&walls).collect::<Vec<_>>(), &grid, [1.0, 1.0, 9.0])?, 0);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed {
    level: Level,
}

impl Default for Fixed {
    fn default() -> Self {
        Self { level: Level::best() }
    }
}

/// Splits snapped triangles into blocks of eight for the queries. A triangle's index is its
/// position in the slice.
///
/// ```
/// use intertri::fixed::{Bits, Fixed, Grid, blocks};
/// use intertri::{Ray, Triangle};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]);
///
/// let points = triangle.0.into_iter().chain([ray.origin]);
/// let grid = Grid::around(points, Bits::FINE)?;
/// let blocks: Vec<_> = blocks(&[grid.triangle(&triangle)?]).collect();
/// let hit = Fixed::default().closest(&blocks, &grid.ray(&ray)?).unwrap();
/// assert_eq!((hit.triangle, hit.t, hit.u, hit.v), (0, 2.5, 0.25, 0.25));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
pub fn blocks(triangles: &[Triangle]) -> impl Iterator<Item = Block<8>> {
    triangles
        .chunks(8)
        .zip((0_u32..).step_by(8))
        .map(|(chunk, first)| Block::new(chunk.iter().copied().zip(first..)))
}

impl Fixed {
    /// Creates the mode at a given instruction level.
    pub fn at(level: Level) -> Self {
        Self { level }
    }

    /// Returns the instruction level at which queries run.
    pub fn level(&self) -> Level {
        self.level
    }

    /// Returns the closest hit. If several hits have the same t, compared as exact ratios, the
    /// lowest index wins.
    pub fn closest(&self, blocks: &[Block<8>], ray: &Ray) -> Option<Hit> {
        let mut best = Best::default();
        self.each(blocks, ray, |crossing, index| {
            best.offer(crossing, index);
            true
        });
        best.to_hit(ray)
    }

    /// Returns whether the ray hits anything.
    pub fn any(&self, blocks: &[Block<8>], ray: &Ray) -> bool {
        let mut any = false;
        self.each(blocks, ray, |_, _| {
            any = true;
            false
        });
        any
    }

    /// Returns every hit, sorted by exact t and, for equal t, by index.
    pub fn all(&self, blocks: &[Block<8>], ray: &Ray) -> Vec<Hit> {
        let mut crossings = Vec::new();
        self.each(blocks, ray, |crossing, index| {
            crossings.push((crossing, index));
            true
        });
        crossings.sort_unstable_by_key(|(crossing, index)| (crossing.t, *index));
        crossings.iter().map(|(crossing, index)| crossing.to_hit(ray, *index)).collect()
    }

    /// Counts the crossings of a ray. A crossing at a shared edge or corner counts once.
    pub fn crossings(&self, blocks: &[Block<8>], ray: &Ray) -> Crossings {
        let mut count = Crossings::default();
        self.each(blocks, ray, |crossing, _| {
            count.add(crossing.leaves);
            true
        });
        count
    }

    /// Computes the winding number of a closed mesh around a point from the signed crossings of a
    /// ray. If the triangles are counter-clockwise as seen from outside, the winding number is 1
    /// inside and 0 outside; if the mesh is inside out, it is -1 inside. A point on the surface has
    /// the winding number of a neighbouring point.
    ///
    /// # Errors
    /// Returns an error if the point is not on the grid.
    pub fn winding(
        &self,
        blocks: &[Block<8>],
        grid: &Grid,
        point: [f32; 3],
    ) -> Result<i64, GridError> {
        let ray = grid.ray(&crate::Ray::new(point, [1.0, 0.0, 0.0]))?;
        Ok(self.crossings(blocks, &ray).signed)
    }

    /// Returns whether a closed mesh contains a point, that is, whether the winding number is
    /// nonzero.
    ///
    /// # Errors
    /// Returns an error if the point is not on the grid.
    pub fn contains(
        &self,
        blocks: &[Block<8>],
        grid: &Grid,
        point: [f32; 3],
    ) -> Result<bool, GridError> {
        Ok(self.winding(blocks, grid, point)? != 0)
    }

    /// Like [`Fixed::closest`], but for many rays, eight at a time: `hits[i]` becomes the hit of
    /// `rays[i]`. Consecutive rays with the same origin share the work that depends on it.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn closest_batch(&self, triangles: &[Triangle], rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "`rays` and `hits` must have the same length");
        self.level.run(ClosestBatch { triangles, rays, hits });
    }

    /// Calls `go_on` for every crossing until it returns false.
    fn each(self, blocks: &[Block<8>], ray: &Ray, go_on: impl FnMut(Crossing, u32) -> bool) {
        self.level.run(ForEachCrossing { blocks, ray, go_on });
    }
}

struct ForEachCrossing<'a, E> {
    blocks: &'a [Block<8>],
    ray: &'a Ray,
    go_on: E,
}

impl<E: FnMut(Crossing, u32) -> bool> WithSimd for ForEachCrossing<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let ray = RayLanes::<S, 8>::new(self.ray);
        let mut more = true;
        for block in self.blocks {
            block.crossings_in::<S, true>(&ray, |crossing, index| {
                // A block reports all of its crossings. Ignore the crossings after the crossing
                // that ended the query.
                more = more && (self.go_on)(crossing, index);
            });
            if !more {
                return;
            }
        }
    }
}

/// The number of packets of eight rays that share the values computed from a triangle.
const PACKETS: usize = 8;

struct ClosestBatch<'a> {
    triangles: &'a [Triangle],
    rays: &'a [Ray],
    hits: &'a mut [Hit],
}

impl WithSimd for ClosestBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let rays = self.rays.chunks(8 * PACKETS);
        for (rays, hits) in rays.zip(self.hits.chunks_mut(8 * PACKETS)) {
            let packets: [Packet<8>; PACKETS] =
                from_fn(|p| Packet::new(rays.get(8 * p..).unwrap_or(&[])));
            let packets = &packets[..rays.len().div_ceil(8)];
            let mut bests = [[Best::default(); 8]; PACKETS];

            // If all rays have the same origin, compute the values that depend on it once for all
            // eight packets. Each ray then needs only the products with its direction.
            let origin = rays[0].origin();
            let shared = rays.iter().all(|ray| ray.origin() == origin);
            for (index, triangle) in (0..).zip(self.triangles) {
                if shared {
                    let Some(seen) = SeenTriangle::new(triangle, origin) else { continue };
                    for (packet, bests) in packets.iter().zip(&mut bests) {
                        seen.crossings_in::<S, true, 8>(packet, packet.live(), |lane, crossing| {
                            bests[lane].offer(crossing, index);
                        });
                    }
                } else {
                    let triangle = Prepared::new(triangle);
                    for (packet, bests) in packets.iter().zip(&mut bests) {
                        packet.crossings_in::<S, true>(
                            &triangle,
                            packet.live(),
                            |lane, crossing| {
                                bests[lane].offer(crossing, index);
                            },
                        );
                    }
                }
            }
            for ((ray, best), hit) in rays.iter().zip(bests.as_flattened()).zip(hits) {
                *hit = best.to_hit(ray).unwrap_or(Hit::MISS);
            }
        }
    }
}
