//! Measures how closely errors approach the bounds for f32 copies of f64 scenes. It compares the
//! filter's values for the copies with exact values for the originals, for each family and in a
//! search that climbs toward the largest share. A share above 1 would refute
//! `docs/numerics/f64.md`.

use dashu_ratio::RBig;
use intertri::internal::{Evidence, LocalFrame};
use intertri::simd::Level;
use intertri::{Ray64, Triangle64};
use intertri_lab::families::{FAMILIES, Family};
use intertri_lab::rng::Rng;

/// The names of the shares: the errors of V, W, U, D and T relative to their bounds, the largest
/// error of V, W, U and T relative to the sharp bounds, and the distance of t from the middle of
/// its enclosure. If only the sign matters, the rounding of the last sum does not count.
const NAMES: [&str; 7] = ["V", "W", "U", "D", "T", "sharp", "t"];

/// Half an ulp of 1 in f32.
const U: f64 = 1.0 / (1 << 24) as f64;

/// A ray, a triangle, and the frame in which their f32 copies are stored.
#[derive(Clone, Copy, Debug)]
struct Case {
    ray: Ray64,
    triangle: Triangle64,
    frame: LocalFrame,
}

type Vector = [RBig; 3];

fn rational(v: [f64; 3]) -> Vector {
    v.map(|x| RBig::try_from(x).unwrap())
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn dot(a: &Vector, b: &Vector) -> RBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Returns `2^e` as a rational number.
fn power(e: i32) -> RBig {
    RBig::try_from(2.0_f64.powi(e)).unwrap()
}

/// Returns the share of each bound that a case uses at one level, or `None` if a bound is not
/// finite, because the filter then decides nothing.
fn shares(case: &Case, level: Level) -> Option<[f64; 7]> {
    let Case { ray, triangle, frame } = case;
    let (copy, copied) = (frame.triangle(triangle), frame.ray(ray));
    let seen = Evidence::of_copies(&copied, &copy, frame.reach(), level);
    let bounds = [seen.edge, seen.u_edge, seen.den_err, seen.num_err, seen.sharp_num];
    if !bounds.iter().chain(&seen.sharp).all(|x| x.is_finite()) {
        return None;
    }

    // Compute in the units used by the traversal.
    let (_, up) = frame.centre_and_exponent();
    let scaled = |v: Vector, by: i32| v.map(|x| x * power(by));
    let [c1, c2, c3] = triangle.0.map(|corner| scaled(rational(corner), up));
    let (o, d) = (scaled(rational(ray.origin), up), rational(ray.dir));
    let d = scaled(d, up - frame.exponent(ray));
    let (a, h4, h5) = (minus(&c1, &o), minus(&c2, &c1), minus(&c3, &c1));
    let (n, r) = (cross(&h4, &h5), cross(&a, &d));
    let (v, w, den, num) = (dot(&h5, &r), -dot(&h4, &r), dot(&n, &d), dot(&n, &a));
    let u = &den - &v - &w;
    let off = |x: f32, exact: &RBig, last: f64, bound: f32| {
        let off = RBig::try_from(x).unwrap() - exact;
        let off = off.to_f64().value().abs() - last * f64::from(x.abs());
        off.max(0.0) / f64::from(bound)
    };
    let sign = |x: f32, exact: &RBig, bound: f32| off(x, exact, U, bound);
    let all = |x: f32, exact: &RBig, bound: f32| off(x, exact, 0.0, bound);
    let edges = [(seen.v, &v), (seen.w, &w), (seen.u, &u)];
    let sharp = (edges.iter().zip(seen.sharp)).map(|((x, exact), bound)| sign(*x, exact, bound));
    let sharp = sharp.fold(all(seen.num, &num, seen.sharp_num), f64::max);
    let mut t_share = 0.0;
    if seen.sure {
        let t = (&num / &den).to_f64().value();
        for [lo, hi] in [[seen.t_lo, seen.t_hi], seen.sharp_t].map(|ends| ends.map(f64::from)) {
            let half = 0.5 * (hi - lo);
            if half.is_finite() {
                t_share = f64::max(t_share, (t - 0.5 * (lo + hi)).abs() / half);
            }
        }
    }
    Some([
        sign(seen.v, &v, seen.edge),
        sign(seen.w, &w, seen.edge),
        sign(seen.u, &u, seen.u_edge),
        all(seen.den, &den, seen.den_err),
        all(seen.num, &num, seen.num_err),
        sharp,
        t_share,
    ])
}

/// Returns the larger of two shares for each bound.
fn larger(a: [f64; 7], b: [f64; 7]) -> [f64; 7] {
    [0, 1, 2, 3, 4, 5, 6].map(|i| a[i].max(b[i]))
}

/// Generates an f64 case from a family, rotated and moved so that its coordinates use all digits.
/// The scene is at least as large as the case.
fn in_scene(family: &Family, rng: &mut Rng) -> Option<Case> {
    let case = family.case(rng);
    let given = [case.ray.origin, case.ray.dir].into_iter().chain(case.triangle.0);
    if !given.flatten().all(f32::is_finite) || case.ray.dir == [0.0; 3] {
        return None;
    }
    let (axis, third) = (rng.direction(), rng.direction());
    // Mirroring twice is a rotation.
    let mirrored = |v: [f64; 3], n: [f64; 3]| {
        let along = 2.0 * (0..3).map(|k| v[k] * n[k]).sum::<f64>();
        [0, 1, 2].map(|k| v[k] - along * n[k])
    };
    let turned = |v: [f32; 3]| mirrored(mirrored(v.map(f64::from), axis), third);
    let size = case.triangle.0.as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    let moved = f64::from(size) * rng.pick(&[0.0, 1e3, 1e6]);
    let by = rng.direction().map(|x| moved * x);
    let at = |v: [f32; 3]| {
        let v = turned(v);
        [0, 1, 2].map(|k| v[k] + by[k])
    };
    let triangle = Triangle64(case.triangle.0.map(at));
    let larger = f64::from(size) * rng.pick(&[0.0, 1.0, 1e3]);
    let side = |k: usize, least: fn(f64, f64) -> f64| {
        triangle.0.iter().map(|corner| corner[k]).reduce(least).unwrap_or(0.0)
    };
    let lo = [0, 1, 2].map(|k| side(k, f64::min) - larger * rng.unit());
    let hi = [0, 1, 2].map(|k| side(k, f64::max) + larger * rng.unit());
    let ray = Ray64::new(at(case.ray.origin), turned(case.ray.dir));
    Some(Case { ray, triangle, frame: LocalFrame::around([lo, hi], [lo, hi]) })
}

/// How far a search's scene extends from the origin along each axis.
const REACH: f64 = 1.9;

/// Generates a triangle of a given size somewhere in the scene, and a ray that hits or just misses
/// it.
fn case(size: f64, rng: &mut Rng) -> Case {
    let at = rng.cube().map(|x| (REACH - 0.1) * x);
    let mut corner = || {
        let v = rng.cube();
        [0, 1, 2].map(|k| (at[k] + size * v[k]).clamp(-REACH, REACH))
    };
    let triangle = Triangle64([corner(), corner(), corner()]);
    let origin = rng.cube().map(|x| x * rng.pick(&[0.1, 1.0, 3.0]));
    let target = triangle.0[rng.below(3)];
    let dir = [0, 1, 2].map(|k| target[k] - origin[k] + size * rng.signed());
    let frame = LocalFrame::around([[-REACH; 3], [REACH; 3]], [[-REACH; 3], [REACH; 3]]);
    Case { ray: Ray64::new(origin, dir), triangle, frame }
}

/// Returns a copy of the case in which a few of the low-order bits of one number are changed.
fn changed(case: &Case, rng: &mut Rng) -> Case {
    let mut next = *case;
    let number: &mut f64 = match rng.below(5) {
        0 => &mut next.ray.origin[rng.below(3)],
        1 => &mut next.ray.dir[rng.below(3)],
        _ => &mut next.triangle.0[rng.below(3)][rng.below(3)],
    };
    let digits = 20 + rng.below(32);
    *number = f64::from_bits(number.to_bits() ^ rng.bits() >> (64 - digits as u32).min(63));
    if !number.is_finite() || number.abs() > REACH {
        return *case;
    }
    next
}

/// Returns a level with separate multiplications and additions, and one with fused operations if
/// the CPU has them.
fn levels() -> impl Iterator<Item = Level> {
    [Some(Level::PORTABLE), Level::avx2()].into_iter().flatten()
}

#[test]
fn no_family_uses_more_than_the_bound() {
    let of = |family: &Family| {
        let (mut rng, mut most) = (Rng::new(12), [0.0; 7]);
        for _ in 0..3000 {
            let Some(case) = in_scene(family, &mut rng) else { continue };
            for used in levels().filter_map(|level| shares(&case, level)) {
                assert!(used.iter().all(|&x| x <= 1.0), "{used:?}\n{case:?}");
                most = larger(most, used);
            }
        }
        (family.name, most)
    };
    let halves = [0, 1].map(|k| FAMILIES.iter().skip(k).step_by(2));
    let mut rows = std::thread::scope(|scope| {
        let workers = halves.map(|half| scope.spawn(move || half.map(of).collect::<Vec<_>>()));
        workers.map(|w| w.join().expect("no worker panics")).concat()
    });
    rows.sort_by_key(|(name, _)| FAMILIES.iter().position(|family| family.name == *name));
    println!("| share of | {} |", NAMES.join(" | "));
    for (name, most) in rows {
        println!("| {name} | {} |", most.map(|x| format!("{x:.2}")).join(" | "));
    }
}

#[test]
fn the_room_for_copies_is_enough() {
    let (mut rng, level) = (Rng::new(41), Level::best());
    let mut most = [0.0_f64; 7];
    let mut used = |case: &Case| {
        let used = shares(case, level).expect("the bounds are finite");
        most = larger(most, used);
        used
    };
    // Search for each of the five terms.
    for i in 0..5 {
        for size in [1.0, 1e-2, 1e-5] {
            for _ in 0..6 {
                let mut best = case(size, &mut rng);
                let mut share = used(&best)[i];
                for _ in 0..500 {
                    let next = changed(&best, &mut rng);
                    let now = used(&next)[i];
                    if now >= share {
                        (best, share) = (next, now);
                    }
                }
            }
        }
    }
    println!("| search | {} |", most.map(|x| format!("{x:.2}")).join(" | "));
    assert!(most.iter().all(|&share| share < 1.0), "{most:?}");
    // The search must find large shares, to show that much smaller bounds would not suffice.
    assert!(most[..2].iter().chain(&most[3..5]).all(|&share| share > 0.12), "{most:?}");
}
