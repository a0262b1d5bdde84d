//! Tests that the error bounds for f32 copies of f64 scenes hold in the worst case over all
//! roundings, and that they would not hold if any constant were halved.

use super::super::worst::{Search, Worst};
use super::*;

/// The names of the bounds, in the order of [`Case::shares`].
const NAMES: [&str; 9] = ["V", "W", "U", "D", "grazing", "T", "sharp V", "sharp U", "sharp T"];

/// A ray and a triangle that are copies of f64 originals.
struct Case {
    triangle: Triangles<Worst>,
    rays: Rays<Worst>,
    room: Room,
}

impl Case {
    /// Builds a case from fifteen numbers: an origin, the vector from the origin to a corner, the
    /// two edges from that corner, and a direction. The corner is the farthest point in the scene.
    #[expect(clippy::large_stack_arrays, reason = "each number carries all of its shares")]
    fn of(numbers: &[f64; 15], change: fn(&mut Room)) -> Option<Self> {
        Worst::begin(&[]);
        let v = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
        let (o, a, h4, h5, d) = (v(0), v(1), v(2), v(3), v(4));
        let c1 = [0, 1, 2].map(|k| o[k] + a[k]);
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let h6 = [0, 1, 2].map(|k| h5[k] - h4[k]);
        let h = length(h4).max(length(h5)).max(length(h6));
        let sane = |x: f64| (1e-6..1e6).contains(&x);
        if !sane(h) || !sane(length(d)) || !sane(length(a)) {
            return None;
        }
        let reach = c1.iter().map(|x| x.abs()).sum::<f64>();
        let mut room = Room::of_copies((reach as f32).next_up());
        change(&mut room);
        let zero = Lanes::splat(0.0);
        let org = Worst::copies(o);
        let lanes = RayLanes { org, dir: Worst::copies(d), t_min: zero, t_max: zero };
        let edges = [Worst::copies(c1), Worst::copies(h4.map(|x| -x)), Worst::copies(h5)];
        Some(Self {
            triangle: Triangles::of_edges(edges, Lanes::splat((h as f32).next_up())),
            rays: Rays::new(lanes, Threshold::ZERO, &room),
            room,
        })
    }

    /// Returns the worst-case errors, each as a fraction of its bound.
    fn shares(&self) -> [f64; 9] {
        let Self { triangle, rays, room } = self;
        let edges = Edges::new(triangle, rays);
        let plane = PlaneHit::new(triangle, rays, &edges, room);
        let bound = edges.bound(triangle, rays).value;
        let [sharp_v, _, sharp_u] = edges.sharp_bounds(triangle, rays, room).map(|x| x.value);
        let sharp_num = PlaneHit::sharp_num_err(triangle, rays, &edges, room).value;
        let slack = f64::from(bound::SLACK);
        // The last rounding of a sum cannot change its sign, so it does not count.
        let sign = |x: &Worst| x.most() - f64::from(bound::U) * x.value.abs();
        [
            sign(&edges.v) / bound,
            sign(&edges.w) / bound,
            sign(&edges.u) / (2.0 * bound),
            slack * edges.den.most() / plane.den_err.value,
            // The error of D, relative to the smallest D for which anything is decided.
            2.84 * edges.den.most() / edges.least.value,
            slack * plane.num.most() / plane.num_err.value,
            sign(&edges.v) / sharp_v,
            sign(&edges.u) / sharp_u,
            plane.num.most() / sharp_num,
        ]
    }
}

/// Returns a generator of fifteen random numbers. The factor `far` moves the origin away from the
/// centre of the scene; far away, the errors of the copies outweigh all other errors.
fn start(far: f64) -> impl Fn(&mut Search) -> [f64; 15] {
    move |search| {
        let mut numbers = [0.0; 15].map(|_: f64| search.number());
        numbers[..3].iter_mut().for_each(|x| *x *= far);
        numbers
    }
}

/// Returns the largest fraction of a bound that the error reaches in a search.
fn most(bound: usize, far: f64, change: fn(&mut Room)) -> f64 {
    let share = |numbers: &[f64; 15]| {
        let shares = Case::of(numbers, change)?.shares();
        Some(shares[bound]).filter(|share| share.is_finite())
    };
    let mut search = Search::new(7 + bound as u64);
    search.most([6, 600], start(far), share)
}

#[test]
fn bounds_over_copies_hold_whatever_roundings_come_to() {
    for (bound, name) in NAMES.iter().enumerate() {
        let shares = [0.0, 1.0, 1e3].map(|far| most(bound, far, |_| ()));
        std::println!("{name:8} {shares:.2?}");
        assert!(shares.iter().all(|share| *share <= 1.0), "{name}: {shares:?}");
    }
}

#[test]
fn half_of_a_constant_over_copies_would_not_do() {
    type Change = fn(&mut Room);
    let halves: [(&str, usize, f64, Change); 10] = [
        ("COPY_EDGE", 0, 0.0, |room| room.edge *= 0.5),
        ("COPY_EDGE of U", 2, 0.0, |room| room.edge *= 0.5),
        ("COPY of A in edges", 0, 1e3, |room| room.copied = room.copied.map(|x| 0.5 * x)),
        ("COPY_DEN", 3, 0.0, |room| room.den *= 0.5),
        ("COPY_GRAZING", 4, 0.0, |room| room.grazing *= 0.5),
        ("COPY_NUM", 5, 0.0, |room| room.num[0] *= 0.5),
        ("COPY of A in T", 5, 1e3, |room| room.copied = room.copied.map(|x| 0.5 * x)),
        ("COPY_SHARP", 6, 0.0, |room| room.sharp[0] *= 0.5),
        ("COPY_SHARP_U", 7, 0.0, |room| room.sharp[1] *= 0.5),
        ("COPY of A in sharp T", 8, 1e3, |room| room.copied = room.copied.map(|x| 0.5 * x)),
    ];
    for (name, bound, far, change) in halves {
        let share = most(bound, far, change);
        std::println!("half of {name}: {share:.2}");
        assert!(share > 1.0, "half of {name} would be enough: {share}");
    }
}
