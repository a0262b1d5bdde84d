//! Packets: N rays or N triangles in structure-of-arrays order.

use bytemuck::Zeroable;

use crate::simd::Vec3;
use crate::simd::{Lanes, Mask, Simd, lanes_of};
use crate::{Ray, RayOf, Scalar, Triangle};

/// N rays in lanes: `origin[axis][lane]`.
///
/// Unused lanes repeat the last ray and are dead: no result includes them.
///
/// ```
/// use intertri::{Ray, RayPacket};
/// let rays = [0.0, 1.0, 2.0].map(|x| Ray::new([x, 0.0, 0.0], [0.0, 0.0, 1.0]));
/// let packet = RayPacket::<4>::new(&rays);
/// assert_eq!((packet.live(), packet.origin[0]), (0b111, [0.0, 1.0, 2.0, 2.0]));
/// assert_eq!(packet.ray(1), rays[1]);
/// ```
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct RayPacket<const N: usize> {
    /// The origins, by axis.
    pub origin: [[f32; N]; 3],
    /// The directions, by axis.
    pub dir: [[f32; N]; 3],
    /// The near ends of the intervals.
    pub t_min: [f32; N],
    /// The far ends of the intervals.
    pub t_max: [f32; N],
    live: u32,
}

impl<const N: usize> RayPacket<N> {
    /// Creates a packet from the first N rays of a slice, which may contain fewer.
    ///
    /// ```
    /// use intertri::{Ray, RayPacket};
    /// let rays = [Ray::new([0.0; 3], [0.0, 0.0, 1.0]); 5];
    /// assert_eq!(RayPacket::<8>::new(&rays).live(), 0b1_1111);
    /// ```
    #[inline]
    pub fn new(rays: &[Ray]) -> Self {
        let live = rays.len().min(N);
        let mut packet = Self {
            origin: [[0.0; N]; 3],
            dir: [[0.0; N]; 3],
            t_min: [0.0; N],
            t_max: [0.0; N],
            live: mask(live),
        };
        let last = rays[..live].last().copied().unwrap_or(Ray::zeroed());
        for lane in 0..N {
            let ray = rays.get(lane).unwrap_or(&last);
            for axis in 0..3 {
                packet.origin[axis][lane] = ray.origin[axis];
                packet.dir[axis][lane] = ray.dir[axis];
            }
            packet.t_min[lane] = ray.t_min;
            packet.t_max[lane] = ray.t_max;
        }
        packet
    }

    /// Returns the live lanes: bit i is set if lane i contains one of the given rays.
    #[inline(always)]
    pub fn live(&self) -> u32 {
        self.live
    }

    /// Returns the ray in a lane.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: [0, 1, 2].map(|axis| self.origin[axis][lane]),
            t_min: self.t_min[lane],
            dir: [0, 1, 2].map(|axis| self.dir[axis][lane]),
            t_max: self.t_max[lane],
        }
    }
}

impl RayPacket<16> {
    /// Like [`RayPacket::new`], but moves whole registers if there are sixteen rays.
    #[doc(hidden)]
    #[inline(always)]
    pub fn loaded_in<S: Simd>(rays: &[Ray]) -> Self {
        let Some(rays) = rays.first_chunk::<16>() else { return Self::new(rays) };
        // A ray is two rows: its origin with t_min, and its direction with t_max.
        let rows: &[[[f32; 4]; 2]; 16] = bytemuck::cast_ref(rays);
        let mut packet = Self {
            origin: [[0.0; 16]; 3],
            dir: [[0.0; 16]; 3],
            t_min: [0.0; 16],
            t_max: [0.0; 16],
            live: mask(16),
        };
        let [x, y, z, t_min] = S::columns(
            #[inline(always)]
            |i| &rows[i][0],
        );
        let [dx, dy, dz, t_max] = S::columns(
            #[inline(always)]
            |i| &rows[i][1],
        );
        x.store(&mut packet.origin[0]);
        y.store(&mut packet.origin[1]);
        z.store(&mut packet.origin[2]);
        t_min.store(&mut packet.t_min);
        dx.store(&mut packet.dir[0]);
        dy.store(&mut packet.dir[1]);
        dz.store(&mut packet.dir[2]);
        t_max.store(&mut packet.t_max);
        packet
    }
}

/// N triangles in lanes.
///
/// Unused lanes repeat the last triangle and are dead: no result includes them.
///
/// ```
/// use intertri::{Triangle, TriangleBlock};
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let block = TriangleBlock::<8>::new(&[at(5.0), at(7.0)]);
/// assert_eq!((block.live(), block.triangle(1)), (0b11, at(7.0)));
/// // The z coordinates of the first corners.
/// assert_eq!(block.corners()[0][2][..3], [5.0, 7.0, 7.0]);
/// ```
// A row of eight values takes 32 bytes, so a block together with eight indices takes six cache
// lines.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Zeroable)]
pub struct TriangleBlock<const N: usize> {
    corners: [[[f32; N]; 3]; 3],
    longest_edges: [f32; N],
    live: u32,
}

impl<const N: usize> TriangleBlock<N> {
    /// Creates a block from the first N triangles of a slice, which may contain fewer.
    ///
    /// ```
    /// use intertri::{Triangle, TriangleBlock};
    /// let triangle = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// let block = TriangleBlock::<4>::new(&[triangle; 3]);
    /// assert_eq!((block.live(), block.triangle(3)), (0b111, triangle));
    /// ```
    #[inline]
    pub fn new(triangles: &[Triangle]) -> Self {
        let mut block = Self::of_corners(triangles);
        for lane in 0..N {
            let corners = block.triangle(lane).0.map(|c| Vec3::<f64>::splat(c.map(f64::from)));
            longest_edges(&corners, &mut block.longest_edges[lane..=lane]);
        }
        block
    }

    /// Creates a block from up to N f32 copies of f64 triangles. Unused lanes repeat the last copy.
    #[doc(hidden)]
    pub fn of_copies(copies: &[Copy32]) -> Self {
        let live = copies.len().min(N);
        let mut block =
            Self { corners: [[[0.0; N]; 3]; 3], longest_edges: [0.0; N], live: mask(live) };
        for lane in 0..N {
            let Some(copy) = copies.get(lane).or(copies[..live].last()) else { break };
            for (to, from) in block.corners.iter_mut().zip(&copy.parts) {
                for axis in 0..3 {
                    to[axis][lane] = from[axis];
                }
            }
            block.longest_edges[lane] = copy.longest;
        }
        block
    }

    /// Creates a block without setting the longest edges.
    #[inline(always)]
    fn of_corners(triangles: &[Triangle]) -> Self {
        let live = triangles.len().min(N);
        let mut block =
            Self { corners: [[[0.0; N]; 3]; 3], longest_edges: [0.0; N], live: mask(live) };
        // Dead lanes repeat the last triangle, so that they contain ordinary numbers.
        let last = triangles[..live].last().copied().unwrap_or(Triangle::zeroed());
        for lane in 0..N {
            let triangle = triangles.get(lane).unwrap_or(&last);
            for (to, from) in block.corners.iter_mut().zip(&triangle.0) {
                for axis in 0..3 {
                    to[axis][lane] = from[axis];
                }
            }
        }
        block
    }

    /// Returns the corners: `corners()[k][axis][lane]` belongs to corner k+1.
    #[inline(always)]
    pub fn corners(&self) -> &[[[f32; N]; 3]; 3] {
        &self.corners
    }

    /// Returns an upper bound on the longest edge in each lane, at least [`SHORTEST`].
    #[inline(always)]
    pub(crate) fn longest_edges(&self) -> &[f32; N] {
        &self.longest_edges
    }

    /// Returns the live lanes: bit i is set if lane i contains one of the given triangles.
    #[inline(always)]
    pub fn live(&self) -> u32 {
        self.live
    }

    /// Returns the triangle in a lane.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> Triangle {
        // Avoid `map`, which is not always inlined.
        let mut triangle = Triangle([[0.0; 3]; 3]);
        for (to, from) in triangle.0.iter_mut().zip(&self.corners) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = from[lane];
            }
        }
        triangle
    }
}

impl TriangleBlock<8> {
    /// Like [`TriangleBlock::new`], but for loops that are compiled for an instruction level.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{Triangle, TriangleBlock};
    ///
    /// struct Packs<'a>(&'a [Triangle]);
    /// impl WithSimd for Packs<'_> {
    ///     type Output = Vec<TriangleBlock<8>>;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         let mut blocks = vec![];
    ///         for eight in self.0.chunks(8) {
    ///             blocks.push(TriangleBlock::new_in::<S>(eight));
    ///         }
    ///         blocks
    ///     }
    /// }
    /// let triangle = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// assert_eq!(dispatch(Packs(&[triangle; 11]))[1].live(), 0b111);
    /// ```
    #[inline(always)]
    pub fn new_in<S: Simd>(triangles: &[Triangle]) -> Self {
        let mut block = Self::of_corners(triangles);
        let [c1, c2, c3] = &block.corners;
        let corners = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        longest_edges(&corners, &mut block.longest_edges);
        block
    }

    /// Creates a block from triangles that are already in lanes: `corners[k][axis][lane]` belongs
    /// to corner k+1. Lanes whose bit in `live` is 0 are dead.
    ///
    /// ```
    /// use intertri::simd::{Simd, WithSimd, dispatch};
    /// use intertri::{Mode, Ray, Triangle, TriangleBlock};
    ///
    /// struct Without<'a>(&'a TriangleBlock<8>, u32);
    /// impl WithSimd for Without<'_> {
    ///     type Output = TriangleBlock<8>;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         TriangleBlock::of_lanes_in::<S>(*self.0.corners(), self.0.live() & !self.1)
    ///     }
    /// }
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let block = dispatch(Without(&TriangleBlock::new(&[at(5.0), at(3.0)]), 0b10));
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// assert!(Mode::exact().block(&ray, &block).iter().eq([(0, 5.0)]));
    /// ```
    #[inline(always)]
    pub fn of_lanes_in<S: Simd>(corners: [[[f32; 8]; 3]; 3], live: u32) -> Self {
        let mut block = Self { corners, longest_edges: [0.0; 8], live: live & mask(8) };
        let [c1, c2, c3] = &block.corners;
        let lanes = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        longest_edges(&lanes, &mut block.longest_edges);
        block
    }

    /// Creates a block of copies from their parts in lanes: a corner, the edges -h4 and h5, and the
    /// third edge.
    #[inline(always)]
    pub(crate) fn of_copied_lanes<D: Lanes<Scalar = f64>>(
        parts: [Vec3<D>; 3],
        h6: Vec3<D>,
        live: u32,
    ) -> Self {
        let mut block =
            Self { corners: [[[0.0; 8]; 3]; 3], longest_edges: [0.0; 8], live: live & mask(8) };
        for (to, part) in block.corners.iter_mut().zip(parts) {
            part.x.store_f32(&mut to[0]);
            part.y.store_f32(&mut to[1]);
            part.z.store_f32(&mut to[2]);
        }
        longest_of([parts[1], parts[2], h6], largest(parts), &mut block.longest_edges);
        block
    }

    /// Returns the edges -h4 and h5 of a block of copies.
    #[inline(always)]
    pub(crate) fn edges_of_copies(&mut self) -> &mut [[[f32; 8]; 3]] {
        &mut self.corners[1..]
    }
}

/// The f32 copy of a triangle given in f64.
#[derive(Clone, Copy, Debug)]
pub struct Copy32 {
    /// The first corner, the edge from the second corner to the first, and the edge from the first
    /// corner to the third.
    pub parts: [[f32; 3]; 3],
    /// An upper bound on the longest edge; NaN if f32 must not decide.
    pub longest: f32,
}

/// The hits of a packet of rays on one triangle, or of one ray on a block of triangles.
///
/// ```
/// use intertri::{Mode, PacketHits, Ray, Triangle, TriangleBlock};
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let block = TriangleBlock::<4>::new(&[at(5.0), at(-1.0), at(3.0)]);
/// let hits: PacketHits<4> = Mode::certified().block(&Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]), &block);
/// let nearest = hits.iter().min_by(|a, b| a.1.total_cmp(&b.1));
/// assert_eq!(nearest, Some((2, 3.0)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacketHits<const N: usize> {
    /// Bit i is set if lane i is a hit.
    pub bits: u32,
    /// The `t` of each lane, valid if the lane's bit is set.
    pub t: [f64; N],
}

impl<const N: usize> PacketHits<N> {
    /// Iterates over the lanes that are hits, in ascending order, with their `t`.
    ///
    /// ```
    /// let hits = intertri::PacketHits { bits: 0b1010, t: [0.0, 5.0, 0.0, 3.0] };
    /// assert!(hits.iter().eq([(1, 5.0), (3, 3.0)]));
    /// ```
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> + use<N> {
        let t = self.t;
        lanes_of(self.bits).map(move |lane| (lane, t[lane]))
    }
}

/// The minimum length of an edge, 2^-48. Shorter edges are treated as if they had this length, so
/// that the effect of underflow on the product of two edges stays below the effect of one rounding.
pub(crate) const SHORTEST: f32 = f32::from_bits((127 - 48) << 23);

/// The largest coordinate for which f32 may decide, 2^40. The limit keeps products from
/// overflowing.
pub(crate) const LARGEST: f32 = (1_u64 << 40) as f32;

/// Computes the lengths of the longest edges, rounded up and at least [`SHORTEST`]. A length is NaN
/// if a corner is too far out for f32 to decide.
#[inline(always)]
fn longest_edges<D: Lanes<Scalar = f64>>([c1, c2, c3]: &[Vec3<D>; 3], edges: &mut [f32]) {
    longest_of([*c1 - *c2, *c2 - *c3, *c3 - *c1], largest([*c1, *c2, *c3]), edges);
}

/// Returns the largest magnitude of any coordinate of three vectors.
#[inline(always)]
fn largest<D: Lanes>([a, b, c]: [Vec3<D>; 3]) -> D {
    let (a, b, c) = (a.abs(), b.abs(), c.abs());
    a.x.max(a.y).max(a.z).max(b.x.max(b.y).max(b.z)).max(c.x.max(c.y).max(c.z))
}

/// Like [`longest_edges`], but for given edges and the largest coordinate of the corners.
#[inline(always)]
fn longest_of<D: Lanes<Scalar = f64>>([a, b, c]: [Vec3<D>; 3], largest: D, edges: &mut [f32]) {
    let (a, b, c) = (a.dot(a), b.dot(b), c.dot(c));
    // The conversion may round down; the two steps up below make the result an upper bound again.
    a.max(b).max(c).sqrt().store_f32(edges);
    // A NaN in any edge makes the sum NaN, and the comparison is then false.
    let known = (a + b + c).lt(D::splat(f64::INFINITY));
    let sane = (known & largest.le(D::splat(f64::from(LARGEST)))).bits();
    for (lane, edge) in edges.iter_mut().enumerate() {
        // Two steps up cover all rounding errors of the length. For NaN, the bits do not matter.
        let above = f32::from_bits((*edge + SHORTEST).to_bits().wrapping_add(2));
        *edge = if sane >> lane & 1 != 0 { above } else { f32::NAN };
    }
}

/// Returns a mask of the lowest `n` bits.
fn mask(n: usize) -> u32 {
    ((1_u64 << n) - 1) as u32
}

/// Rays in lanes, with the values that a test needs. All lanes may contain the same ray.
#[derive(Clone, Copy)]
pub struct RayLanes<L> {
    pub(crate) org: Vec3<L>,
    pub(crate) dir: Vec3<L>,
    pub(crate) t_min: L,
    pub(crate) t_max: L,
}

impl<L: Lanes> RayLanes<L> {
    /// Loads N different rays.
    #[inline(always)]
    pub(crate) fn of_packet<const N: usize>(packet: &RayPacket<N>) -> Self {
        Self {
            org: Vec3::load_f32(&packet.origin),
            dir: Vec3::load_f32(&packet.dir),
            t_min: L::load_f32(&packet.t_min),
            t_max: L::load_f32(&packet.t_max),
        }
    }
}

impl<L: Lanes> RayLanes<L> {
    /// Copies one ray to all lanes.
    #[inline(always)]
    pub(crate) fn splat(one: &RayLanes<L::Scalar>) -> Self {
        let vec3 = |v: Vec3<L::Scalar>| Vec3::splat([v.x, v.y, v.z]);
        Self {
            org: vec3(one.org),
            dir: vec3(one.dir),
            t_min: L::splat(one.t_min),
            t_max: L::splat(one.t_max),
        }
    }
}

impl<L: Lanes> RayLanes<L> {
    /// Converts one ray and copies it to all lanes.
    #[inline(always)]
    pub fn of_ray<S: Scalar + Into<L::Scalar>>(ray: &RayOf<S>) -> Self {
        Self {
            org: Vec3::splat(ray.origin.map(Into::into)),
            dir: Vec3::splat(ray.dir.map(Into::into)),
            t_min: L::splat(ray.t_min.into()),
            t_max: L::splat(ray.t_max.into()),
        }
    }

    /// Replaces the far ends of the rays.
    #[inline(always)]
    pub fn until(self, t_max: L) -> Self {
        Self { t_max, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::LARGEST;
    use crate::simd::{Level, Simd, WithSimd};
    use crate::{Triangle, TriangleBlock};

    struct In<'a>(&'a [Triangle]);
    impl WithSimd for In<'_> {
        type Output = TriangleBlock<8>;
        #[inline(always)]
        fn run<S: Simd>(self) -> TriangleBlock<8> {
            TriangleBlock::new_in::<S>(self.0)
        }
    }

    /// Tests coordinates of all kinds in all corners: the blocks must be the same at every level,
    /// and every bound on a longest edge must be valid or NaN.
    #[test]
    fn longest_edges_are_the_same_at_every_level() {
        let numbers = [0.0, -0.0, 1e-45, 1.0, -3.7, 1e9, LARGEST, -LARGEST, 2.0 * LARGEST];
        let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX];
        let all: Vec<f32> = numbers.into_iter().chain(wild).collect();
        for i in 0..9 * all.len() * all.len() {
            let mut triangle = Triangle([[0.0, 0.1, 0.2], [1.0, 0.3, 0.1], [0.4, 2.0, 0.7]]);
            triangle.0.as_flattened_mut()[i % 9] = all[i / 9 % all.len()];
            triangle.0.as_flattened_mut()[(i + 4) % 9] = all[i / 9 / all.len()];
            let plain = TriangleBlock::<8>::new(&[triangle; 3]);
            for level in Level::all() {
                let block = level.run(In(&[triangle; 3]));
                let bits = |block: &TriangleBlock<8>| block.longest_edges.map(f32::to_bits);
                assert_eq!(bits(&block), bits(&plain), "{triangle:?}, {}", level.name());
                assert_eq!(block.live, plain.live);
            }

            // Compare with f64, which can represent the square of any edge for which f32 may
            // decide.
            let sane = triangle.0.as_flattened().iter().all(|x| x.abs() <= LARGEST);
            assert_eq!(plain.longest_edges[0].is_nan(), !sane, "{triangle:?}");
            for k in 0..3 {
                let (a, b) = (triangle.0[k], triangle.0[(k + 1) % 3]);
                let d = [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]));
                let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                assert!(!sane || f64::from(plain.longest_edges[0]) > length, "{triangle:?}");
            }
        }
    }
}
