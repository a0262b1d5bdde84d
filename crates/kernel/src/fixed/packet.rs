//! Tests packets of rays, with or without a common origin, against one triangle.

use super::determinants::Determinants;
use super::edges::{Edges, cross_i64, i64s, load, load_f32, product, splat, splat_f32, volume};
use super::filter::{SEEN, maybe, maybe_seen};
use super::prepared::minus;
use super::{Crossing, IntWidth, Prepared, Ratio, Ray, Triangle};
use crate::simd::{Ints, Lanes, Simd};
use crate::simd::{Lane, Width, lanes_of};

/// N rays in lanes. N is 4 or 8. Unused lanes are dead: no result includes them.
///
/// ```
/// use intertri::fixed::{Bits, Grid, Packet, Prepared};
/// use intertri::simd::{Simd, WithSimd, dispatch};
///
/// /// Finds the rays of a packet that cross a triangle, for a custom traversal.
/// struct Leaf<'a>(&'a Packet<8>, &'a Prepared);
/// impl WithSimd for Leaf<'_> {
///     type Output = Vec<usize>;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Vec<usize> {
///         let mut lanes = vec![];
///         self.0.crossings_in::<S, true>(self.1, self.0.live(), |lane, _| lanes.push(lane));
///         lanes
///     }
/// }
///
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = Prepared::new(&grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?);
/// let rays = [1, 9, 2].map(|x| grid.ray_of([x, 1, 0], [0, 0, 1]).unwrap());
/// let packet = Packet::new(&rays);
/// assert_eq!((packet.live(), packet.rays()[1]), (0b111, rays[1]));
/// assert_eq!(dispatch(Leaf(&packet, &wall)), [0, 2]);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Packet<const N: usize> {
    origin: [[f32; N]; 3],
    dir: [[f32; N]; 3],
    /// The longest component of all directions in the packet.
    longest: f32,
    live: u32,
    rays: [Ray; N],
}

impl<const N: usize> Packet<N> {
    /// Creates a packet from the first N rays of a slice, which may contain fewer.
    pub fn new(rays: &[Ray]) -> Self {
        let live = rays.len().min(N);
        let none = Ray::new([0; 3], [0; 3]);
        let mut packet = Self {
            origin: [[0.0; N]; 3],
            dir: [[0.0; N]; 3],
            longest: 0.0,
            live: (1 << live) - 1,
            rays: [none; N],
        };
        packet.rays[..live].copy_from_slice(&rays[..live]);
        for (lane, ray) in packet.rays.iter().enumerate() {
            for axis in 0..3 {
                packet.origin[axis][lane] = ray.to_f32().origin[axis];
                packet.dir[axis][lane] = ray.to_f32().dir[axis];
            }
            packet.longest = Lanes::max(packet.longest, ray.longest());
        }
        packet
    }

    /// Returns a mask in which bit i is set if lane i contains a ray.
    pub fn live(&self) -> u32 {
        self.live
    }

    /// Returns the rays by lane.
    pub fn rays(&self) -> &[Ray; N] {
        &self.rays
    }

    /// Calls `each` for every crossing of a `live` ray with a triangle, passing the ray's lane.
    /// Call this function in a loop that is compiled for an instruction level. With `FILTER`, an
    /// f32 test runs first to reject most misses. It does not change the result.
    #[inline(always)]
    pub fn crossings_in<S: Simd, const FILTER: bool>(
        &self,
        triangle: &Prepared,
        live: u32,
        mut each: impl FnMut(usize, Crossing),
    ) where
        Lane<N>: IntWidth,
    {
        let Prepared { c1, h4, h5, n, longest } = *triangle;
        let mut lanes = live;
        if FILTER {
            lanes &= maybe::<F<S, N>>(
                load_f32(&self.origin),
                load_f32(&self.dir),
                Lanes::splat(self.longest),
                [splat_f32(c1), splat_f32(h4), splat_f32(h5), splat_f32(n)],
                Lanes::splat(longest),
            );
            if lanes == 0 {
                return;
            }
        }

        let (c1, h4, h5) = (whole(c1), whole(h4), whole(h5));
        let (origin, dir) = (load(&self.origin), load(&self.dir));
        let triangle = [splat(c1), splat(h4), splat(h5), splat(cross_i64(h4, h5))];
        let edges = Edges::<I<S, N>>::new(origin, dir, triangle);
        // At a crossing, all three determinants have the same sign, which determines the side.
        let (with, against) = edges.sides(lanes);
        if with | against == 0 {
            return;
        }
        let at = Determinants::new(edges.u, edges.v, edges.w);
        for lane in lanes_of(with | against) {
            let ray = &self.rays[lane];
            let o = i64s(ray.origin());
            // The numerator of t needs i128; it is the only value that does not fit in i64.
            let num = volume([c1[0] - o[0], c1[1] - o[1], c1[2] - o[2]], h4, h5);
            if let Some(crossing) = at.crossing(lane, num, with >> lane & 1 != 0, ray) {
                each(lane, crossing);
            }
        }
    }
}

/// A triangle relative to an origin, with the values that rays from that origin share.
///
/// As in document D, each test then needs only the products with the direction.
///
/// ```
/// use intertri::fixed::{Bits, Grid, Packet, SeenTriangle};
/// use intertri::simd::{Simd, WithSimd, dispatch};
///
/// /// Finds the rays of a packet, all from one origin, that cross a triangle.
/// struct Leaf<'a>(&'a Packet<8>, &'a SeenTriangle);
/// impl WithSimd for Leaf<'_> {
///     type Output = Vec<usize>;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Vec<usize> {
///         let mut lanes = vec![];
///         self.1.crossings_in::<S, true, 8>(self.0, self.0.live(), |lane, _| lanes.push(lane));
///         lanes
///     }
/// }
///
/// let (grid, eye) = (Grid::at(Bits::FINE, 0, [0; 3])?, [0, 0, 0]);
/// let wall = grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?;
/// let seen = SeenTriangle::new(&wall, eye).unwrap();
/// let rays = [1, 9, 2].map(|x| grid.ray_of(eye, [x, 1, 5]).unwrap());
/// assert_eq!(dispatch(Leaf(&Packet::new(&rays), &seen)), [0, 2]);
/// assert!(SeenTriangle::new(&wall, [7, 7, 5]).is_none());
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SeenTriangle {
    origin: [i32; 3],
    sides: Sides,
    normals_f32: [[f32; 3]; 3],
    /// The sign, 1 or -1, that each determinant takes if it is 0.
    ties: [i64; 3],
    /// The largest 1-norm of the three normals, times the filter's factor.
    bound: f32,
}

/// The cross products of a triangle's corners relative to an origin, and the numerator of t. They
/// determine where a ray from that origin crosses the triangle, provided that the ray is known to
/// cross it.
///
/// ```
/// use intertri::fixed::{Bits, Grid, Sides};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?;
/// let sides = Sides::new(&wall, [1, 1, 0]);
/// let ray = grid.ray_of([1, 1, 0], [0, 0, 2])?;
/// assert_eq!(sides.crossing(&ray).to_hit(&ray, 0).t, 2.5);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    /// B x C, C x A, and A x B.
    normals: [[i64; 3]; 3],
    num: i128,
}

impl Sides {
    /// Computes the cross products and the numerator of t for a triangle and an origin.
    #[inline(always)]
    pub fn new(&Triangle([c1, c2, c3]): &Triangle, origin: [i32; 3]) -> Self {
        let a = i64s(minus(c1, origin));
        let b = i64s(minus(c2, origin));
        let c = i64s(minus(c3, origin));
        let normals = [cross_i64(b, c), cross_i64(c, a), cross_i64(a, b)];
        Self { normals, num: product(a, normals[0]) }
    }

    /// Computes where a ray from this origin crosses the triangle. The ray must be known to cross
    /// it.
    #[inline(always)]
    pub fn crossing(&self, ray: &Ray) -> Crossing {
        let [x, y, z] = i64s(ray.dir());
        let weight = |n: &[i64; 3]| (x * n[0] + y * n[1] + z * n[2]).unsigned_abs();
        let [u, v, w] = self.normals.each_ref().map(weight);
        let t = Ratio { num: self.num.unsigned_abs(), den: u + v + w };
        Crossing { t, v, w, leaves: self.num > 0 }
    }
}

impl SeenTriangle {
    /// Computes the values of a triangle relative to an origin. Returns `None` if the origin is in
    /// the triangle's plane or if the triangle is degenerate, because no ray from the origin
    /// crosses such a triangle.
    #[inline(always)]
    pub fn new(triangle: &Triangle, origin: [i32; 3]) -> Option<Self> {
        let sides = Sides::new(triangle, origin);
        let Sides { normals, num } = sides;
        if num == 0 {
            return None;
        }
        // If num is not 0, no normal is 0. Arrays compare by the first component that differs, so
        // the comparison yields the sign that results from moving the direction by (e, e², e³).
        let ties = normals.map(|n| if n < [0; 3] { -1 } else { 1 });
        let normals_f32 = normals.map(|n| n.map(|x| x as f32));
        let norm = |n: &[f32; 3]| n[0].abs() + n[1].abs() + n[2].abs();
        let bound = SEEN * normals_f32.iter().map(norm).fold(0.0, Lanes::max);
        Some(Self { origin, sides, normals_f32, ties, bound })
    }

    /// Calls `each` for every crossing of a `live` ray with the triangle, passing the ray's lane.
    /// All live rays must start at the origin passed to [`SeenTriangle::new`]. Call this function
    /// in a loop that is compiled for an instruction level. With `FILTER`, an f32 test runs first
    /// to reject most misses. It does not change the result.
    #[inline(always)]
    pub fn crossings_in<S: Simd, const FILTER: bool, const N: usize>(
        &self,
        packet: &Packet<N>,
        live: u32,
        mut each: impl FnMut(usize, Crossing),
    ) where
        Lane<N>: IntWidth,
    {
        debug_assert!(lanes_of(live).all(|lane| packet.rays[lane].origin() == self.origin));
        let mut lanes = live;
        if FILTER {
            // The triangle's part of the bound is precomputed. The packet's part is the longest
            // component of its directions.
            let bound = <F<S, N>>::splat(self.bound * packet.longest);
            lanes &= maybe_seen(load_f32(&packet.dir), &self.normals_f32, bound);
            if lanes == 0 {
                return;
            }
        }

        // Twice the determinant plus the tie's sign is never 0 and has the correct sign.
        let Sides { normals, num } = &self.sides;
        let d = load::<I<S, N>, N>(&packet.dir);
        let u = Ints::dot(d, splat(normals[0]));
        let v = Ints::dot(d, splat(normals[1]));
        let w = Ints::dot(d, splat(normals[2]));
        let nu = (u + u + Ints::splat(self.ties[0])).negative();
        let nv = (v + v + Ints::splat(self.ties[1])).negative();
        let nw = (w + w + Ints::splat(self.ties[2])).negative();
        let leaves = *num > 0;
        let lanes = lanes & if leaves { !(nu | nv | nw) } else { nu & nv & nw };
        if lanes == 0 {
            return;
        }
        let at = Determinants::new(u, v, w);
        for lane in lanes_of(lanes) {
            if let Some(crossing) = at.crossing(lane, *num, leaves, &packet.rays[lane]) {
                each(lane, crossing);
            }
        }
    }
}

/// Converts f32 components that are exact integers to i64.
#[inline(always)]
fn whole([x, y, z]: [f32; 3]) -> [i64; 3] {
    [x as i64, y as i64, z as i64]
}

type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
type I<S, const N: usize> = <Lane<N> as IntWidth>::I<S>;
