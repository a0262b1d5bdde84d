//! Tests that the error bounds for projected copies hold in the worst case over all roundings, and
//! that they would not hold if any constant were halved.

use super::super::super::bound;
use super::super::super::room::Room;
use super::super::super::worst::{Search, Worst, Worsts};
use super::super::starts::Starts;
use super::point::{Corners, Planes, Sizes};
use super::*;
use crate::Threshold;
use crate::packet::Copy32;

/// The names of the bounds, in the order of [`Case::shares`].
const NAMES: [&str; 5] = ["V", "W", "U", "inverse depth", "sign of T"];

/// A copied ray and triangle, and the axes of a projection.
struct Case {
    frame: Frame,
    dir: [f64; 3],
    block: TriangleBlock<8>,
    /// The largest possible errors of the vectors A, h4, and h5.
    off: [f64; 9],
    /// The vectors A, h4, and h5 of the block's triangle, relative to the origin.
    a: [f64; 3],
    edges: [[f64; 3]; 2],
}

impl Case {
    /// Builds a case from nineteen numbers: an origin, the vector from the origin to a corner, the
    /// two edges from that corner, the point where the ray meets the projection, and the rotation
    /// of the axes. The corner is the farthest point in the scene.
    fn of(numbers: &[f64; 19], change: fn(&mut Frame)) -> Option<Self> {
        let v = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
        let (o, a, h4, h5, [x, y, z]) = (v(0), v(1), v(2), v(3), v(4));
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        let [depth, right, up] = axes(v(5), numbers[18])?;
        let ([x, y], z) = ([x, y].map(|x| x.clamp(-0.49, 0.49)), z.abs().clamp(0.1, 10.0));
        let dir = [0, 1, 2].map(|k| z * (depth[k] + x * right[k] + y * up[k]));
        let origin = narrow(o);
        let c1 = [0, 1, 2].map(|k| f64::from(origin[k]) + a[k]);
        let minus_h4 = h4.map(|x| -x);
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let h6 = [0, 1, 2].map(|k| h5[k] - h4[k]);
        let h = length(h4).max(length(h5)).max(length(h6));
        if !(1e-6..1e6).contains(&h) || !(1e-6..1e6).contains(&length(a)) {
            return None;
        }
        let reach = c1.iter().map(|x| x.abs()).sum::<f64>();
        let room = Room::of_copies((reach as f32).next_up());
        let frame = Frame::new(origin, narrow(depth), narrow(right), narrow(up)).of_copies();
        let mut frame = frame
            .passed_within(room.passed(origin), [x.abs() as f32 + 1e-6, y.abs() as f32 + 1e-6]);
        change(&mut frame);
        let parts = [narrow(c1), narrow(minus_h4), narrow(h5)];
        let copy = Copy32 { parts, longest: (h as f32).next_up() };
        let u = f64::from(bound::U);
        let mut off = [0.0; 9];
        for k in 0..3 {
            off[k] = u * (f64::from(parts[0][k]).abs() + f64::from(origin[k]).abs());
            (off[3 + k], off[6 + k]) = (u * h4[k].abs(), u * h5[k].abs());
        }
        let wide = |v: [f32; 3]| v.map(f64::from);
        let a = [0, 1, 2].map(|k| f64::from(parts[0][k]) - f64::from(origin[k]));
        let edges = [wide(parts[1]).map(|x| -x), wide(parts[2])];
        Some(Self { frame, dir, block: TriangleBlock::of_copies(&[copy]), off, a, edges })
    }

    /// Returns the worst-case errors, each as a fraction of its bound, or `None` if the projection
    /// decides nothing.
    fn shares(&self) -> Option<[f64; 5]> {
        let Self { frame, dir, block, off, .. } = self;
        Worst::begin(off);
        let corners = Corners::<Worst>::new::<Worsts>([block, block], frame);
        let points = frame.points(Worst::copies(*dir));
        let ([u, v, w], unit) = corners.edges(frame);
        let share = |form: Vec3<Worst>| {
            let [one, x, y] = [form.x, form.y, form.z].map(|c| c * Lanes::splat(1.0));
            y.mul_add(points.y, x.mul_add(points.x, one)).most() / unit.value
        };
        let edges = [share(v), share(w), share(u)];

        let (away, zero) = (corners.a.norm1(), [0.0; 9]);
        Worst::begin(&zero);
        let planes = Planes::<Worst>::new::<Worsts>([block, block], frame);
        let sizes = Sizes::of(&planes, away, frame, 0.0);
        if !planes.is_sure(away, sizes.size, frame) {
            return None;
        }
        let (depth, sign) = self.plane();

        Some([edges[0], edges[1], edges[2], depth / sizes.err.value, sign])
    }

    /// Returns the largest error of the inverse depth, and the error of T relative to the quarter
    /// of T that the proof allows.
    fn plane(&self) -> (f64, f64) {
        let Self { frame, dir, off, a, edges: [h4, h5], .. } = self;
        Worst::begin(&[]);
        let off_by = |v: &[f64; 3], from: usize| {
            let [x, y, z] = [0, 1, 2].map(|k| Worst::off_by(v[k], off[from + k]));
            Vec3 { x, y, z }
        };
        // These operations are in f64, whose rounding is negligible here.
        let (a, h4, h5) =
            (Free::of(&off_by(a, 0)), Free::of(&off_by(h4, 3)), Free::of(&off_by(h5, 6)));
        let n = h4.cross(&h5);
        let t = n.dot(&a);
        let n = frame.dual.map(|axis| n.dot(&Free::exact(axis)));
        let [one, x, y] = n.map(|n| n.over(t).rounded());
        let points = frame.points(Worst::copies(*dir));
        let s = y.mul_add(points.y, x.mul_add(points.x, one));
        (s.most(), 4.0 * t.most() / t.value.abs())
    }
}

/// A vector whose operations do not round.
pub(super) struct Free(pub(super) [Worst; 3]);

impl Free {
    fn of(v: &Vec3<Worst>) -> Self {
        Self([v.x, v.y, v.z])
    }

    pub(super) fn exact(v: [f64; 3]) -> Self {
        Self(v.map(|x| Worst::off_by(x, 0.0)))
    }

    pub(super) fn dot(&self, b: &Self) -> Worst {
        let [x, y, z] = [0, 1, 2].map(|k| self.0[k].times(&b.0[k]));
        x.plus(&y).plus(&z)
    }

    fn cross(&self, Self(b): &Self) -> Self {
        let Self(a) = self;
        let minor = |i: usize, k: usize| a[i].times(&b[k]).plus(&-a[k].times(&b[i]));
        Self([minor(1, 2), minor(2, 0), minor(0, 1)])
    }
}

/// Returns orthogonal axes: the depth axis and the two axes perpendicular to it, rotated about the
/// depth axis.
pub(super) fn axes(depth: [f64; 3], roll: f64) -> Option<[[f64; 3]; 3]> {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let unit = |v: [f64; 3]| v.map(|x| x / dot(v, v).sqrt());
    let cross =
        |a: [f64; 3], b: [f64; 3]| [(1, 2), (2, 0), (0, 1)].map(|(i, k)| a[i] * b[k] - a[k] * b[i]);
    if dot(depth, depth) < 1e-6 {
        return None;
    }
    let depth = unit(depth);
    // Start with the coordinate axis along which `depth` is smallest.
    let least = (0..3).min_by(|&i, &k| depth[i].abs().total_cmp(&depth[k].abs()))?;
    let mut right = depth.map(|x| -x * depth[least]);
    right[least] += 1.0;
    let up = cross(depth, unit(right));
    let right = unit([0, 1, 2].map(|k| unit(right)[k] + roll * up[k]));
    Some([depth, right, cross(depth, right)])
}

/// Returns a generator of nineteen random numbers. The ray's origin is near the triangle, so that
/// most of the projection is relevant.
fn start(far: f64, thin: f64) -> impl Fn(&mut Search) -> [f64; 19] {
    move |search| {
        let mut numbers = [0.0; 19].map(|_: f64| search.number());
        numbers[..3].iter_mut().for_each(|x| *x *= far);
        // Make the triangle a sliver if requested: its edges are nearly equal.
        if thin > 0.0 {
            for k in 0..3 {
                numbers[9 + k] = numbers[6 + k] + thin * numbers[9 + k];
            }
        }
        numbers
    }
}

/// Returns a sliver seen from the centre of its scene. Its corner is at `away`; the edges from that
/// corner are nearly parallel to `along` and differ by `thin`. The ray is tilted from the depth
/// axis, which is perpendicular to `right`.
fn sliver(
    [away, along, thin]: [[f64; 3]; 3],
    [depth, right]: [[f64; 3]; 2],
    lean: [f64; 2],
) -> [f64; 19] {
    let mut numbers = [0.0; 19];
    for k in 0..3 {
        (numbers[3 + k], numbers[6 + k]) = (away[k], along[k]);
        (numbers[9 + k], numbers[15 + k]) = (along[k] + thin[k], depth[k]);
    }
    [numbers[12], numbers[13], numbers[14]] = [lean[0], lean[1], 1.0];
    let [_, x, y] = axes(depth, 0.0).unwrap();
    let dot = |a: [f64; 3]| (0..3).map(|k| a[k] * right[k]).sum::<f64>();
    numbers[18] = dot(y) / dot(x);
    numbers
}

/// The third coordinate axis.
const AXIS: [f64; 3] = [0.0, 0.0, 1.0];
/// The diagonal between the other two axes.
const DIAGONAL: [f64; 3] = [1.0, 1.0, 0.0];
/// The other diagonal between the other two axes.
const OTHER: [f64; 3] = [1.0, -1.0, 0.0];

/// Returns the input whose error comes closest to the bound `COPY_DEPTH`: the ray is in the plane
/// and perpendicular to the edges, so all products of D are large and cancel. T is accurate because
/// the corner is directly above.
fn grazing(search: &mut Search) -> [f64; 19] {
    let thin = AXIS.map(|x| 1e-4 * (1.5 + search.number()) * x);
    // The ray is tilted upward from the depth axis. The more it is tilted, the longer it is.
    let slope = 0.49 / 2.0_f64.sqrt();
    sliver([OTHER, DIAGONAL, thin], [[-slope, -slope, 1.0], OTHER], [0.0, 0.49])
}

/// Returns the input whose error comes closest to the bound `COPY_SLANT`: the vector to the corner
/// is nearly in the plane, and the tilted ray meets the plane long before the corner. In this case,
/// T is nearly 0.
fn slanting(search: &mut Search) -> [f64; 19] {
    let [thin, slope] = [1e-3, 0.02].map(|size| size * (1.5 + search.number()));
    let thin = [0, 1, 2].map(|k| thin * (AXIS[k] - slope * OTHER[k]));
    sliver([AXIS, DIAGONAL, thin], [AXIS, OTHER], [0.49, 0.0])
}

/// Returns the input whose error comes closest to the bound `COPY_PLANE`: the edges point between
/// two axes, and the triangle is below the ray's start and as thin as it can be without making the
/// sign of T uncertain.
fn thin(search: &mut Search) -> [f64; 19] {
    let thin = f64::from(bound::U) * (10.0 + 8.0 * search.number());
    sliver([AXIS, DIAGONAL, OTHER.map(|x| thin * x)], [AXIS, OTHER], [0.0; 2])
}

/// Returns the largest fraction of a bound that the error reaches in a search.
fn most(
    bound: usize,
    [climbs, steps]: [usize; 2],
    start: impl Fn(&mut Search) -> [f64; 19],
    change: fn(&mut Frame),
) -> f64 {
    let share = |numbers: &[f64; 19]| {
        let shares = Case::of(numbers, change)?.shares()?;
        Some(shares[bound]).filter(|share| share.is_finite())
    };
    Search::new(31 + bound as u64).most([climbs, steps], start, share)
}

/// The number of climbs, and of steps per climb, in a search that starts from arbitrary inputs.
const ANYWHERE: [usize; 2] = [6, 500];
/// The number of climbs, and of steps per climb, in a search around a case that was designed to be
/// bad.
const AROUND: [usize; 2] = [40, 50];

#[test]
fn bounds_of_projected_copies_hold_whatever_roundings_come_to() {
    for (bound, name) in NAMES.iter().enumerate() {
        let kinds = [[0.0, 0.0], [1.0, 0.0], [1e3, 0.0], [0.0, 1e-4], [1e3, 1e-3]];
        let shares = kinds.map(|[far, thin]| most(bound, ANYWHERE, start(far, thin), |_| ()));
        let made = [most(bound, AROUND, grazing, |_| ()), most(bound, AROUND, slanting, |_| ())];
        let thin = most(bound, AROUND, thin, |_| ());
        std::println!("{name:14} {shares:.2?} {made:.2?} {thin:.2}");
        let all = || shares.iter().chain(&made).chain([&thin]);
        assert!(all().all(|share| *share <= 1.0), "{name}: {:?}", all().collect::<Vec<_>>());
    }
}

#[test]
fn half_of_a_constant_of_projected_copies_would_not_do() {
    let halves = [
        (
            "COPY_EDGES and COPY_SCREEN",
            most(2, ANYWHERE, start(0.0, 1e-4), |frame| {
                frame.shares.edges *= 0.5;
                frame.shares.screen *= 0.5;
            }),
        ),
        ("COPY of A in edges", most(0, ANYWHERE, start(1e3, 0.0), |frame| frame.off *= 0.5)),
        ("COPY_DEPTH", most(3, AROUND, grazing, |frame| frame.shares.depth *= 0.5)),
        ("COPY_SLANT", most(3, AROUND, slanting, |frame| frame.shares.slant *= 0.5)),
        ("COPY_PLANE", most(4, AROUND, thin, |frame| frame.shares.plane *= 0.5)),
    ];
    for (name, share) in halves {
        std::println!("half of {name}: {share:.2}");
        assert!(share > 1.0, "half of {name} would be enough: {share}");
    }
}

/// Returns the errors of the inverse depths at the far and near ends of an interval, relative to
/// their margin. `numbers` holds a direction, the depth axis, and the t of the end, whose copy is
/// rounded up or down.
fn ends(numbers: &[f64; 7]) -> Option<[f64; 2]> {
    let [a, b, c, p, q, r, t] = *numbers;
    let [depth, right, up] = axes([p, q, r], 0.0)?.map(|axis| axis.map(|x| x as f32));
    let frame = Frame::new([0.0; 3], depth, right, up).of_copies();
    Worst::begin(&[]);
    let points = frame.points(Worst::copies([a, b, c]));
    let t = t.abs();
    if !frame.on_screen(&points) || !(1e-3..1e3).contains(&t) {
        return None;
    }
    let t = Worst::off_by(t, 2.0 * f64::from(bound::U) * t);
    let share = |end: Worst| end.most() / (f64::from(bound::INVERSE) * end.value);
    let (lo, hi) = frame.apex().inverse(points.z, t);
    let starts = Starts::none(frame.apex());
    let starts = starts.with(&points, [t, t], true, Threshold::ZERO).ranges();
    Some([share(lo).max(share(hi)), share(starts.near_lo).max(share(starts.near_hi))])
}

#[test]
fn the_ends_of_intervals_of_copies_are_widened_by_enough_and_not_by_twice_that() {
    for (which, name) in ["far", "near"].into_iter().enumerate() {
        // Start with a ray toward a corner of the projection.
        let start = |search: &mut Search| {
            let turn = [(); 3].map(|()| search.number());
            let [x, y] = [(); 2].map(|()| 0.48 * search.number().signum());
            let [d, r, u] = axes(turn, 0.0).unwrap_or([[1.0; 3]; 3]);
            let dir = [0, 1, 2].map(|k| d[k] + x * r[k] + y * u[k]);
            [dir[0], dir[1], dir[2], turn[0], turn[1], turn[2], 1.0]
        };
        let share = Search::new(57).most([40, 300], start, |numbers| Some(ends(numbers)?[which]));
        std::println!("INVERSE of {name} ends: {share:.2}");
        assert!((0.5..=1.0).contains(&share), "{name} ends use {share} of INVERSE");
    }
}
