//! Rays in packets against one triangle, with any origins or with one that they share.

use super::block::Determinants;
use super::edges::{Edges, dot, load, load_f32, splat, splat_f32, volume};
use super::filter::{SEEN, maybe, maybe_seen};
use super::{Crossing, IntWidth, Ray, Triangle};
use crate::lanes::{Ints, Lanes, Simd};
use crate::mode::{Lane, Width, lanes_of};

/// N rays side by side, 4 or 8. Lanes beyond the given rays are dead: no answer speaks of them.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Packet<const N: usize> {
    origin: [[f32; N]; 3],
    dir: [[f32; N]; 3],
    /// The longest component of all directions.
    longest: f32,
    live: u32,
    rays: [Ray; N],
}

impl<const N: usize> Packet<N> {
    /// A packet of the first N rays of a slice; of fewer where it is shorter, of none where it is
    /// empty.
    pub fn new(rays: &[Ray]) -> Self {
        let live = rays.len().min(N);
        let none =
            Ray { origin: [0; 3], dir: [0; 3], exponent: 0, t_min: 0.0, t_max: f32::INFINITY };
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
                packet.origin[axis][lane] = ray.origin[axis] as f32;
                packet.dir[axis][lane] = ray.dir[axis] as f32;
            }
            packet.longest = Lanes::max(packet.longest, ray.longest() as f32);
        }
        packet
    }

    /// Bit i is set where lane i is a ray that was given.
    pub fn live(&self) -> u32 {
        self.live
    }

    /// The rays by lane.
    pub fn rays(&self) -> &[Ray; N] {
        &self.rays
    }

    /// The crossings of the `live` rays with a triangle, each with its lane. Within a loop at some
    /// level. With `FILTER`, f32 lanes look first; the answers are the same.
    #[inline(always)]
    pub fn crossings_in<S: Simd, const FILTER: bool>(
        &self,
        triangle: &Triangle,
        live: u32,
        mut each: impl FnMut(usize, Crossing),
    ) where
        Lane<N>: IntWidth,
    {
        let Triangle([c1, c2, c3]) = *triangle;
        let (h4, h5) = ([0, 1, 2].map(|i| c2[i] - c1[i]), [0, 1, 2].map(|i| c3[i] - c1[i]));

        let mut lanes = live;
        if FILTER {
            let longest = h4.iter().chain(&h5).fold(0, |far, x| x.abs().max(far));
            lanes &= maybe::<F<S, N>>(
                load_f32(&self.origin),
                load_f32(&self.dir),
                Lanes::splat(self.longest),
                [splat_f32(c1), splat_f32(h4), splat_f32(h5)],
                Lanes::splat(longest as f32),
            );
            if lanes == 0 {
                return;
            }
        }

        let (origin, dir) = (load(&self.origin), load(&self.dir));
        let edges = Edges::<I<S, N>>::new(origin, dir, splat(c1), splat(h4), splat(h5));
        let (with, against) = edges.sides(lanes);
        if with | against == 0 {
            return;
        }
        let at = Determinants::new(edges.u, edges.v, edges.w);
        for lane in lanes_of(with | against) {
            let ray = &self.rays[lane];
            let a = [0, 1, 2].map(|i| i64::from(c1[i] - ray.origin[i]));
            let num = volume(a, h4.map(i64::from), h5.map(i64::from));
            if let Some(crossing) = at.crossing(lane, num, with >> lane & 1 != 0, ray) {
                each(lane, crossing);
            }
        }
    }
}

/// A triangle as seen from one origin: what rays that share it need, computed once.
///
/// Document D's idea: of a test, only the products with the direction are left.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// B x C, C x A and A x B.
    normals: [[i64; 3]; 3],
    normals_f32: [[f32; 3]; 3],
    /// The sign that each determinant has where it is 0: 1 or -1.
    ties: [i64; 3],
    /// The largest `|x| + |y| + |z|` of the normals, times the filter's factor.
    bound: f32,
    num: i128,
}

impl Seen {
    /// The triangle from an origin. `None` where the origin lies in its plane, or the triangle has
    /// no area: then no ray from there crosses it.
    #[inline(always)]
    pub fn new(triangle: &Triangle, origin: [i32; 3]) -> Option<Self> {
        let [a, b, c] = triangle.0.map(|p| [0, 1, 2].map(|i| i64::from(p[i] - origin[i])));
        let cross = |a: [i64; 3], b: [i64; 3]| {
            let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            [minor(1, 2), minor(2, 0), minor(0, 1)]
        };
        let normals = [cross(b, c), cross(c, a), cross(a, b)];
        let num: i128 = (0..3).map(|i| i128::from(a[i]) * i128::from(normals[0][i])).sum();
        if num == 0 {
            return None;
        }
        // Where num is not 0, no normal is.
        let ties = normals.map(|n| if n < [0; 3] { -1 } else { 1 });
        let normals_f32 = normals.map(|n| n.map(|x| x as f32));
        let norm = |n: &[f32; 3]| n[0].abs() + n[1].abs() + n[2].abs();
        let bound = SEEN * normals_f32.iter().map(norm).fold(0.0, Lanes::max);
        Some(Self { normals, normals_f32, ties, bound, num })
    }

    /// The crossings of the `live` rays with the triangle, each with its lane. All of them must
    /// start at the origin from which it is seen. Within a loop at some level. With `FILTER`, f32
    /// lanes look first; the answers are the same.
    #[inline(always)]
    pub fn crossings_in<S: Simd, const FILTER: bool, const N: usize>(
        &self,
        packet: &Packet<N>,
        live: u32,
        mut each: impl FnMut(usize, Crossing),
    ) where
        Lane<N>: IntWidth,
    {
        let mut lanes = live;
        if FILTER {
            let bound = <F<S, N>>::splat(self.bound * packet.longest);
            lanes &= maybe_seen(load_f32(&packet.dir), &self.normals_f32, bound);
            if lanes == 0 {
                return;
            }
        }

        // Twice the determinant and the tie's sign: never 0, and with the right sign.
        let d = load::<I<S, N>, N>(&packet.dir);
        let determinants = self.normals.map(|n| dot(d, n.map(Ints::splat)));
        let [nu, nv, nw] = [0, 1, 2].map(|k| {
            let determinant = determinants[k];
            (determinant + determinant + Ints::splat(self.ties[k])).negative()
        });
        let leaves = self.num > 0;
        let lanes = lanes & if leaves { !(nu | nv | nw) } else { nu & nv & nw };
        if lanes == 0 {
            return;
        }
        let [u, v, w] = determinants;
        let at = Determinants::new(u, v, w);
        for lane in lanes_of(lanes) {
            if let Some(crossing) = at.crossing(lane, self.num, leaves, &packet.rays[lane]) {
                each(lane, crossing);
            }
        }
    }
}

type F<S, const N: usize> = <Lane<N> as Width>::F<S>;
type I<S, const N: usize> = <Lane<N> as IntWidth>::I<S>;
