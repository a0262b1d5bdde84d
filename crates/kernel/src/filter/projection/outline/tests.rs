//! The bounds of projected copies against the most that roundings can come to: enough, and half of any would not be.

use super::super::super::room::Room;
use super::super::super::worst::{Search, Worst, Worsts};
use super::*;
use crate::packet::Copy32;

/// What bounds there are, in the order of [`Case::shares`].
const NAMES: [&str; 5] = ["V", "W", "U", "inverse depth", "sign of T"];

/// A copied ray and triangle, and the axes of a projection.
struct Case {
    frame: Frame,
    dir: [f64; 3],
    block: TriangleBlock<8>,
    /// What the numbers of the block may be off by, and the origin with them.
    off: [f64; 9],
    /// The same as vectors: A, h4 and h5.
    a: [f64; 3],
    edges: [[f64; 3]; 2],
}

impl Case {
    /// By eighteen numbers: an origin, the way to a corner from there, the edges from that, where the ray meets the
    /// projection, and by how much the axes are turned. The scene reaches no farther than the corner.
    fn of(numbers: &[f64; 18], change: fn(&mut Frame)) -> Option<Self> {
        let v = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
        let (o, a, h4, h5, [x, y, z], turn) = (v(0), v(1), v(2), v(3), v(4), v(5));
        let narrow = |v: [f64; 3]| v.map(|x| x as f32);
        let [depth, right, up] = axes(turn)?;
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

    /// The shares of the bounds that roundings may use; none where the projection decides nothing.
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

    /// The most that the inverse depth is off by; and T, as a share of the quarter of itself that the proof allows.
    fn plane(&self) -> (f64, f64) {
        let Self { frame, dir, off, a, edges: [h4, h5], .. } = self;
        Worst::begin(&[]);
        let off_by = |v: &[f64; 3], from: usize| {
            let [x, y, z] = [0, 1, 2].map(|k| Worst::off_by(v[k], off[from + k]));
            Vec3 { x, y, z }
        };
        // In f64: its roundings are nothing beside.
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
struct Free([Worst; 3]);

impl Free {
    fn of(v: &Vec3<Worst>) -> Self {
        Self([v.x, v.y, v.z])
    }

    fn exact(v: [f64; 3]) -> Self {
        Self(v.map(|x| Worst::off_by(x, 0.0)))
    }

    fn dot(&self, b: &Self) -> Worst {
        let [x, y, z] = [0, 1, 2].map(|k| self.0[k].times(&b.0[k]));
        x.plus(&y).plus(&z)
    }

    fn cross(&self, Self(b): &Self) -> Self {
        let Self(a) = self;
        let minor = |i: usize, k: usize| a[i].times(&b[k]).plus(&-a[k].times(&b[i]));
        Self([minor(1, 2), minor(2, 0), minor(0, 1)])
    }
}

/// Axes at right angles.
fn axes(turn: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let size = dot(turn, turn).sqrt();
    if size < 1e-3 {
        return None;
    }
    let depth = turn.map(|x| x / size);
    // Not along the smallest.
    let least = (0..3).min_by(|&i, &k| depth[i].abs().total_cmp(&depth[k].abs()))?;
    let mut right = depth.map(|x| -x * depth[least]);
    right[least] += 1.0;
    let size = dot(right, right).sqrt();
    let right = right.map(|x| x / size);
    let [a, b] = [depth, right];
    let up = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    Some([depth, right, up])
}

/// Eighteen numbers: the ray near the triangle, so that little of the projection is used in vain.
fn start(far: f64, thin: f64) -> impl Fn(&mut Search) -> [f64; 18] {
    move |search| {
        let mut numbers = [0.0; 18].map(|_: f64| search.number());
        numbers[..3].iter_mut().for_each(|x| *x *= far);
        // A sliver, if that is asked for: the edges are nearly the same.
        if thin > 0.0 {
            for k in 0..3 {
                numbers[9 + k] = numbers[6 + k] + thin * numbers[9 + k];
            }
        }
        numbers
    }
}

/// The most that a search finds of a bound.
fn most(bound: usize, [far, thin]: [f64; 2], change: fn(&mut Frame)) -> f64 {
    let share = |numbers: &[f64; 18]| {
        let shares = Case::of(numbers, change)?.shares()?;
        Some(shares[bound]).filter(|share| share.is_finite())
    };
    let mut search = Search::new(31 + bound as u64);
    search.most([6, 500], start(far, thin), share)
}

#[test]
fn bounds_of_projected_copies_hold_whatever_roundings_come_to() {
    for (bound, name) in NAMES.iter().enumerate() {
        let kinds = [[0.0, 0.0], [1.0, 0.0], [1e3, 0.0], [0.0, 1e-4], [1e3, 1e-3]];
        let shares = kinds.map(|kind| most(bound, kind, |_| ()));
        std::println!("{name:14} {shares:.2?}");
        assert!(shares.iter().all(|share| *share <= 1.0), "{name}: {shares:?}");
    }
}

#[test]
fn half_of_a_constant_of_projected_copies_would_not_do() {
    type Change = fn(&mut Frame);
    let halves: [(&str, usize, [f64; 2], Change); 2] = [
        ("COPY_EDGES and COPY_SCREEN", 2, [0.0, 1e-4], |frame| {
            frame.shares.edges *= 0.5;
            frame.shares.screen *= 0.5;
        }),
        ("COPY of A in edges", 0, [1e3, 0.0], |frame| frame.off *= 0.5),
    ];
    for (name, bound, kind, change) in halves {
        let share = most(bound, kind, change);
        std::println!("half of {name}: {share:.2}");
        assert!(share > 1.0, "half of {name} would do: {share}");
    }
}
