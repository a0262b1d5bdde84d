//! Tests that the bounds for parallel rays hold in the worst case over all roundings, and that they
//! would not hold if a constant were halved.

use super::super::super::super::worst::{Search, Worst, Worsts};
use super::super::tests::{Free, axes};
use super::*;
use crate::Triangle;
use crate::packet::Copy32;

/// The names of the bounds, in the order of [`Case::shares`].
const NAMES: [&str; 5] = ["V", "W", "U", "place", "room"];

/// A ray, a triangle, and a projection along the ray.
struct Case {
    frame: Frame,
    block: TriangleBlock<8>,
    /// The largest errors of the numbers that are loaded, for copies.
    off: Vec<f64>,
    origin: [f64; 3],
    dir: [f64; 3],
    corners: [[f64; 3]; 3],
    is_copy: bool,
}

impl Case {
    /// Builds a case from twenty numbers: the frame's origin, the vector from there to a corner, the
    /// two edges from that corner, the point of the ray and its depth, the direction, the rotation
    /// of the axes, and the scale.
    fn of(numbers: &[f64; 20], is_copy: bool) -> Option<Self> {
        let v = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
        let (middle, a, h4, h5, [x, y, z], dir) = (v(0), v(1), v(2), v(3), v(4), v(5));
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        let wide = |v: [f32; 3]| v.map(f64::from);
        let [depth, right, up] = axes(dir, numbers[18])?;
        let ([x, y], scale) =
            ([x, y].map(|x| x.clamp(-0.49, 0.49)), numbers[19].clamp(-8.0, 8.0).exp2());
        let (middle, dir) = (narrow(middle), narrow(dir));
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let at = |k: usize| (x * right[k] + y * up[k]) / scale + z * depth[k];
        let origin = narrow([0, 1, 2].map(|k| f64::from(middle[k]) + at(k)));
        let c1 = narrow([0, 1, 2].map(|k| f64::from(middle[k]) + a[k]));
        let add = |b: [f64; 3]| [0, 1, 2].map(|k| f64::from(c1[k]) + b[k]);
        let (mut corners, mut off, block);
        if is_copy {
            let parts = [c1, narrow(h4.map(|x| -x)), narrow(h5)];
            corners = [wide(c1), add(wide(parts[1]).map(|x| -x)), add(wide(parts[2]))];
            let u = f64::from(bound::U);
            off = parts.iter().flatten().map(|&x| u * f64::from(x).abs()).collect();
            let longest = longest(&corners, length);
            block =
                TriangleBlock::of_copies(&[Copy32 { parts, longest: (longest as f32).next_up() }]);
        } else {
            let triangle = Triangle([c1, narrow(add(h4)), narrow(add(h5))]);
            corners = triangle.0.map(wide);
            off = Vec::new();
            block = TriangleBlock::new(&[triangle]);
        }
        let h = longest(&corners, length);
        let (size, away) = (length(wide(dir)), length(a));
        let deep = (z.abs() / size) as f32 * 1.001 + 1e-6;
        let mut frame = Frame::parallel(middle, (dir, 1.0), narrow(right), scale as f32, deep);
        if is_copy {
            frame = frame.of_copies();
        }
        let is_sane = (1e-6..1e6).contains(&h) && (1e-3..1e3).contains(&size) && away < 1e6;
        let (origin, dir) = (wide(origin), wide(dir));
        corners[0] = wide(c1);
        off.truncate(9);
        is_sane.then_some(Self { frame, block, off, origin, dir, corners, is_copy })
    }

    /// Returns the worst-case errors, each as a fraction of its bound.
    fn shares(&self, [edges, room]: [f32; 2]) -> Option<[f64; 5]> {
        let Self { frame, block, off, origin, .. } = self;
        let mut frame = *frame;
        frame.shares.along.edges *= edges;
        frame.shares.along.room *= room;
        let limits = frame.parallel?;
        Worst::begin(off);
        let forms = Forms::<Worst>::along::<Worsts>([block, block], &frame, &limits);
        let [x, y, z] =
            origin.map(|x| if self.is_copy { Worst::copy(x) } else { Worst::off_by(x, 0.0) });
        let points = frame.origins(Vec3 { x, y, z });
        let unit = forms.unit.value;
        let share = |form: Vec3<Worst>, number: usize| {
            let [one, x, y] = [form.x, form.y, form.z].map(|c| c * Lanes::splat(1.0));
            let rounding = y.mul_add(points.y, x.mul_add(points.x, one)).most();
            (rounding + self.of_axes(number) + self.of_dir(number)) / unit
        };
        let [u, v, w] = forms.edges;
        let edges = [share(v, 1), share(w, 2), share(u, 0)];

        // The point and the corner move together with the axes, so the corner's error is counted
        // relative to the point.
        let axis = frame.right.map(f64::from);
        let by_axis = |p: [f64; 3], q: [f64; 3]| -> f64 {
            let u = f64::from(bound::U);
            (0..3).map(|k| u * (axis[k] * (p[k] - q[k])).abs()).sum()
        };
        let middle = frame.origin.map(f64::from);
        let scale = f64::from(limits.scale);
        let allowed = f64::from(bound::PLACE) * scale * f64::from(limits.away);
        let of_ray = if self.is_copy { 0.0 } else { points.x.most() };
        let place = (of_ray + by_axis(*origin, middle)) / allowed;
        let (lo, hi) = forms.rectangle[0];
        let [a, b, c] = self.corners;
        let room = [lo, hi].map(|end| {
            // The corner that determines the end.
            let of = |p: [f64; 3]| (0..3).map(|k| axis[k] * (p[k] - middle[k])).sum::<f64>();
            let corner = [a, b, c].into_iter().min_by(|p, q| {
                let off = |p: &[f64; 3]| (of(*p) - end.value).abs();
                off(p).total_cmp(&off(q))
            });
            let corner = corner.unwrap_or(a);
            let most =
                (end - points.x).most() + by_axis(corner, *origin) + self.drift(scale, corner);
            most / (of(corner) - end.value).abs()
        });
        Some([edges[0], edges[1], edges[2], place, room[0].max(room[1])])
    }

    /// Returns how far a form at the point changes if the axes are rounded.
    fn of_axes(&self, number: usize) -> f64 {
        let Self { frame, origin, corners, .. } = self;
        Worst::begin(&[]);
        let [right, up] = [frame.right, frame.up].map(|axis| {
            let [x, y, z] = axis.map(|x| Worst::copy(f64::from(x)));
            Free([x, y, z])
        });
        let from = corners[[1, 2, 0][number]];
        let to = corners[[2, 0, 1][number]];
        let sub = |a: [f64; 3], b: [f64; 3]| Free::exact([0, 1, 2].map(|k| a[k] - b[k]));
        let (edge, beside) = (sub(to, from), sub(*origin, from));
        let [a, b, c, d] = [edge.dot(&right), edge.dot(&up), beside.dot(&right), beside.dot(&up)];
        a.times(&d).plus(&-b.times(&c)).most()
    }

    /// Returns how far a form at the point changes if the direction of the ray is a copy.
    fn of_dir(&self, number: usize) -> f64 {
        let Self { frame, origin, corners, dir, is_copy, .. } = self;
        let (from, to) = (corners[[1, 2, 0][number]], corners[[2, 0, 1][number]]);
        let sub = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
        let (edge, beside, u) = (sub(to, from), sub(*origin, from), f64::from(bound::U));
        let minor = |i: usize, k: usize| edge[i] * beside[k] - edge[k] * beside[i];
        let product = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let sum: f64 = (0..3).map(|k| (product[k] * u * dir[k]).abs()).sum();
        let Some(Parallel { length, scale, .. }) = frame.parallel else { return 0.0 };
        let times = f64::from(scale) * f64::from(scale) / f64::from(length);
        if *is_copy { times * sum } else { 0.0 }
    }

    /// Returns how far a copied ray may be from its point when it meets the plane of a corner.
    fn drift(&self, scale: f64, corner: [f64; 3]) -> f64 {
        let Self { origin, is_copy, .. } = self;
        let square: f64 = (0..3).map(|k| (corner[k] - origin[k]).powi(2)).sum();
        if *is_copy { f64::from(bound::U) * scale * square.sqrt() } else { 0.0 }
    }
}

fn longest(corners: &[[f64; 3]; 3], length: impl Fn([f64; 3]) -> f64) -> f64 {
    let edge = |a: usize, b: usize| length([0, 1, 2].map(|k| corners[a][k] - corners[b][k]));
    edge(0, 1).max(edge(1, 2)).max(edge(2, 0))
}

/// Returns the largest fraction of a bound that the error reaches in a search, if the constants for
/// edges and rectangles are multiplied by some factors.
fn most(bound: usize, is_copy: bool, [far, deep, thin]: [f64; 3], factors: [f32; 2]) -> f64 {
    let start = |search: &mut Search| {
        let mut numbers = [0.0; 20].map(|_: f64| search.number());
        numbers[..3].iter_mut().for_each(|x| *x *= far);
        numbers[14] *= deep;
        // Make the triangle a sliver if requested: its edges are nearly equal.
        if thin > 0.0 {
            for k in 0..3 {
                numbers[9 + k] = numbers[6 + k] + thin * numbers[9 + k];
            }
        }
        numbers
    };
    let share = |numbers: &[f64; 20]| {
        let shares = Case::of(numbers, is_copy)?.shares(factors)?;
        Some(shares[bound]).filter(|share| share.is_finite())
    };
    Search::new(71 + bound as u64).most([6, 600], start, share)
}

#[test]
fn bounds_along_parallel_rays_hold_whatever_roundings_come_to() {
    for (bound, name) in NAMES.iter().enumerate() {
        for is_copy in [false, true] {
            let kinds = [[0.0; 3], [1.0, 1.0, 0.0], [100.0, 0.0, 0.0], [0.0, 30.0, 0.3]];
            let shares = kinds.map(|kind| most(bound, is_copy, kind, [1.0; 2]));
            std::println!("{name:6} {is_copy:5} {shares:.2?}");
            assert!(shares.iter().all(|share| *share <= 1.0), "{name}, {is_copy}: {shares:?}");
        }
    }
}

/// For the edges, half of the constants might do: their search reaches 0.45 of the bounds.
#[test]
fn half_of_a_constant_along_parallel_rays_would_not_do() {
    let place = most(3, false, [0.0; 3], [1.0; 2]);
    let rooms = [false, true].map(|is_copy| most(4, is_copy, [0.0; 3], [1.0, 0.5]));
    std::println!("place {place:.2}, half of ROOM_ALONG: {rooms:.2?}");
    assert!(place > 0.5 && rooms.iter().all(|share| *share > 1.0), "{place} {rooms:?}");
}
