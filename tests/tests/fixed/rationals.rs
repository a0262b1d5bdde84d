//! Compares the scalar reference of the `fixed` mode with rational arithmetic in which the ray's
//! direction is actually moved, and checks the t that the reference computes.

use dashu_ratio::RBig;
use intertri::fixed::{Bits, Fixed, Grid, Ray, Triangle, blocks};

use intertri_tests::grid_reference::crossing;

use super::{Numbers, add, sub};

fn whole(x: impl Into<i128>) -> RBig {
    RBig::from(x.into())
}

type V = [RBig; 3];

fn dot(a: &V, b: &V) -> RBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &V, b: &V) -> V {
    let minor = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn minus(a: &V, b: &V) -> V {
    [0, 1, 2].map(|i| &a[i] - &b[i])
}

/// Moves a ray's direction d to `d + (e, e^2, e^3)` with `e = 2^-100`. Returns `Some(true)` if the
/// ray then leaves through the triangle, `Some(false)` if it enters, and `None` if it misses.
///
/// First computes the point where the ray meets the plane, then determines on which side of each
/// edge that point lies. This e is small enough to affect only ties, because nonzero integers are
/// at least 1 in magnitude, and the integers that e multiplies are below `2^64`.
fn moved(ray: &Ray, triangle: &Triangle) -> Option<bool> {
    let e = RBig::from_parts(1.into(), 2u8.into());
    let e = (0..99).fold(e.clone(), |x, _| x * &e);
    let origin = ray.origin().map(whole);
    let d = ray.dir().map(whole);
    let d = [&d[0] + &e, &d[1] + &e * &e, &d[2] + &e * &e * &e];
    let corners = triangle.corners().map(|c| c.map(whole));

    let normal = cross(&minus(&corners[1], &corners[0]), &minus(&corners[2], &corners[0]));
    let slope = dot(&normal, &d);
    if slope == RBig::ZERO {
        return None;
    }
    let t = dot(&normal, &minus(&corners[0], &origin)) / &slope;
    if t <= RBig::ZERO {
        return None;
    }
    let point = [0, 1, 2].map(|i| &origin[i] + &t * &d[i]);
    let inside = (0..3).all(|k| {
        let (from, to) = (&corners[k], &corners[(k + 1) % 3]);
        let side = dot(&normal, &cross(&minus(to, from), &minus(&point, from)));
        assert!(side != RBig::ZERO || t == RBig::ZERO, "a moved ray meets no edge");
        side > RBig::ZERO
    });
    inside.then(|| slope > RBig::ZERO)
}

#[test]
fn the_scalar_reference_answers_as_a_ray_that_is_really_moved() {
    let mut n = Numbers(7);
    let (mut hits, mut ties) = (0, 0);
    for round in 0..12_000 {
        let bits = n.one_of(&[Bits::FINE, Bits::COARSE, Bits::new(2, 2).unwrap()]);
        let grid = Grid::at(bits, 0, [0; 3]).unwrap();
        let reach = n.one_of(&[1, 2, 3, 1 << (bits.b() - 1)]);
        let corners = [n.vector(reach), n.vector(reach), n.vector(reach)];
        let mut origin = n.vector(reach);
        let mut dir = n.vector(reach.min(1 << bits.q()));
        // A quarter of the rays pass exactly through a corner, and another quarter through the
        // midpoint of an edge.
        match round % 4 {
            0 => origin = sub(corners[0], dir),
            1 => dir = add(sub(corners[1], origin), sub(corners[2], origin)),
            _ => {}
        }
        let Ok(ray) = grid.ray_of(origin, dir) else { continue };
        let triangle = grid.triangle_of(corners).unwrap();
        let answer = crossing(&ray, &triangle);
        assert_eq!(answer.map(|c| c.leaves), moved(&ray, &triangle), "{ray:?} {triangle:?}");
        hits += usize::from(answer.is_some());
        ties += answer.map_or(0, |c| usize::from(c.v == 0 || c.w == 0 || c.v + c.w == c.t.den));
    }
    println!("{hits} crossings, {ties} of them on an edge");
    assert!(hits > 500 && ties > 100, "{hits} {ties}");
}

#[test]
fn t_is_rounded_once_and_compared_exactly() {
    let mut n = Numbers(8);
    let mut hits = 0;
    for _ in 0..40_000 {
        let scale = n.within(140);
        let grid = Grid::at(Bits::FINE, scale, [0; 3]).unwrap();
        let reach = n.one_of(&[1000, 1 << 18, 1 << 20]);
        let corners = [n.vector(reach), n.vector(reach), n.vector(reach)];
        let triangle = grid.triangle_of(corners).unwrap();
        // Snap an f32 ray, so that the exponent varies.
        let inner = add(
            add(corners[0].map(|x| x / 3), corners[1].map(|x| x / 3)),
            corners[2].map(|x| x / 3),
        );
        let origin = n.vector(reach);
        let size = 2.0_f32.powi(n.within(120));
        let dir = sub(inner, origin).map(|x| (x >> 3) as f32 * size);
        let at = origin.map(|x| (f64::from(x) * 0.5_f64.powi(scale)) as f32);
        let Ok(ray) = grid.ray(&intertri::Ray::new(at, dir)) else { continue };
        let Some(found) = crossing(&ray, &triangle) else { continue };
        hits += 1;

        let exponent = ray.exponent();
        let mut exact = whole(found.t.num as i128) / whole(i128::from(found.t.den));
        let two = whole(2);
        for _ in 0..exponent.unsigned_abs() {
            exact = if exponent > 0 { exact * &two } else { exact / &two };
        }

        // No other f64 may be nearer to the exact t.
        let ratio = whole(found.t.num as i128) / whole(i128::from(found.t.den));
        let t = found.t.to_f64(exponent);
        let rational = |x: f64| RBig::try_from(x).unwrap();
        let distance = |x: f64| {
            let d = rational(x) - &exact;
            if d < RBig::ZERO { -d } else { d }
        };
        for other in [t.next_up(), t.next_down()] {
            let (near, far) = (distance(t), distance(other));
            assert!(near < far || (near == far && t.to_bits() & 1 == 0), "{t} {other}");
        }
        let all = blocks(&[triangle]);
        let fixed = |ray: &Ray| Fixed::default().closest(&all, ray);
        assert_eq!(fixed(&ray), Some(found.to_hit(&ray, 0)));
        assert_eq!(found.to_hit(&ray, 0).t, t);

        // Compare t with f32 values close to it and far from it.
        let near = t as f32;
        for x in [near, near.next_up(), near.next_down(), 0.0, -1.0, f32::MAX, 1e-45, 1e-38, 1.0] {
            if x.is_finite() {
                let x_exact = RBig::try_from(x).unwrap();
                assert_eq!(found.t.cmp_f32(x), Some(ratio.cmp(&x_exact)), "{t} {x}");

                // The interval is in multiples of the direction before snapping.
                let [from, until] = [ray.between(x, f32::INFINITY), ray.between(0.0, x)];
                let hits = |ray: &Ray| (crossing(ray, &triangle).is_some(), fixed(ray).is_some());
                assert_eq!(hits(&from), (exact >= x_exact, exact >= x_exact), "{t} {x}");
                assert_eq!(hits(&until), (exact < x_exact, exact < x_exact), "{t} {x}");
            }
        }
        assert_eq!(found.t.cmp_f32(f32::NAN), None);
        assert!(found.t.cmp_f32(f32::INFINITY).unwrap().is_lt());
        assert!(found.t.cmp_f32(f32::NEG_INFINITY).unwrap().is_gt());

        // Intervals are half-open: t is inside an interval that begins at t, and outside one that
        // ends at t.
        if f64::from(near) == t && rational(t) == exact {
            let within = |lo, hi| crossing(&ray.between(lo, hi), &triangle).is_some();
            assert!(within(near, near.next_up()) && !within(near.next_down(), near));
        }
    }
    println!("{hits} values of t checked");
    assert!(hits > 2_000, "{hits}");
}
