//! Computes the closest point on a triangle in rational arithmetic, without using any of the
//! kernel's code. Cramer's rule in the triangle's plane determines whether the closest point is
//! inside the face. Otherwise it is the nearest among the corners and the closest points on the
//! edges, each of which is found by clamping a parameter. A triangle with zero area has no face.

use dashu_ratio::RBig;
use intertri::{Scalar, TriangleOf};

type V = [RBig; 3];

fn rational<S: Scalar>(p: [S; 3]) -> V {
    p.map(|x| RBig::try_from(Into::<f64>::into(x)).unwrap())
}

fn minus(a: &V, b: &V) -> V {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn dot(a: &V, b: &V) -> RBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Returns the exact squared distance, and the weights of the second and third corners. If the
/// closest point is not inside the face, the weights are those of the first corner that is the
/// closest point or, if no corner is, of the first of the edges ab, ca and bc that contains it.
pub(crate) fn truth<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> (RBig, [RBig; 2]) {
    let [a, b, c] = triangle.0.map(rational);
    let p = rational(point);
    let (ab, ac, ap) = (minus(&b, &a), minus(&c, &a), minus(&p, &a));
    let [x, y, z] = [dot(&ab, &ab), dot(&ab, &ac), dot(&ac, &ac)];
    let det = &x * &z - &y * &y;
    // Project the point onto the plane by the normal equations.
    let (r, s) = (dot(&ab, &ap), dot(&ac, &ap));
    let square_at = |u: &RBig, v: &RBig| {
        let at = |k: usize| &ap[k] - &ab[k] * u - &ac[k] * v;
        let d = [at(0), at(1), at(2)];
        dot(&d, &d)
    };
    if det != RBig::ZERO {
        let u = (&r * &z - &s * &y) / &det;
        let v = (&s * &x - &r * &y) / &det;
        if u >= RBig::ZERO && v >= RBig::ZERO && &u + &v <= RBig::ONE {
            return (square_at(&u, &v), [u, v]);
        }
    }

    // Otherwise use the nearest corner or edge. If several are equally near, corners come first.
    // The projection onto an edge of length 0 is the edge's end.
    let along = |product: RBig, square: RBig| {
        let share = if square == RBig::ZERO { RBig::ZERO } else { product / square };
        share.clamp(RBig::ZERO, RBig::ONE)
    };
    let (bc, bp) = (minus(&c, &b), minus(&p, &b));
    let along_bc = along(dot(&bc, &bp), dot(&bc, &bc));
    let (zero, one) = (|| RBig::ZERO, || RBig::ONE);
    let all = [
        [zero(), zero()],
        [one(), zero()],
        [zero(), one()],
        [along(r, x), zero()],
        [zero(), along(s, z)],
        [RBig::ONE - &along_bc, along_bc],
    ];
    let all = all.map(|[u, v]| (square_at(&u, &v), [u, v]));
    all.into_iter().min_by(|a, b| a.0.cmp(&b.0)).expect("the array is not empty")
}

/// Returns whether a float is the correctly rounded value of an exact number, that is, whether no
/// other float is nearer.
pub(crate) fn is_rounded(x: f64, exact: &RBig) -> bool {
    let off = |x: f64| {
        let d = RBig::try_from(x).unwrap() - exact;
        if d < RBig::ZERO { -d } else { d }
    };
    let here = off(x);
    here <= off(x.next_up()) && here <= off(x.next_down())
}

/// Returns whether a distance is within one ulp of the square root of `square`.
pub(crate) fn is_within_one_ulp(distance: f64, square: &RBig) -> bool {
    let squared = |x: f64| {
        let x = RBig::try_from(x).unwrap();
        &x * &x
    };
    if distance.is_infinite() {
        return *square > squared(f64::MAX);
    }
    if *square == RBig::ZERO || distance == 0.0 {
        return *square == RBig::ZERO && distance == 0.0;
    }
    let above = distance.next_up();
    squared(distance.next_down()) < *square && (above.is_infinite() || *square < squared(above))
}
