//! Computes winding numbers as sums of solid angles over all triangles. Each number is a pair of
//! f64 values with about 30 digits in total. This module shares no code with the tested
//! implementation.

use intertri::{Scalar, TriangleOf};

/// A number represented as the sum of two f64 values, the second of which is at most half an ulp of
/// the first.
#[derive(Clone, Copy)]
struct Wide(f64, f64);

impl Wide {
    const ZERO: Self = Self(0.0, 0.0);

    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let t = s - a;
        Self(s, (a - (s - t)) + (b - t))
    }

    fn plus(self, b: Self) -> Self {
        let (Self(s, e), Self(t, f)) = (Self::sum(self.0, b.0), Self::sum(self.1, b.1));
        let Self(s, e) = Self::sum(s, e + t);
        Self::sum(s, e + f)
    }

    fn minus(self, b: Self) -> Self {
        self.plus(Self(-b.0, -b.1))
    }

    fn times(self, b: Self) -> Self {
        let p = self.0 * b.0;
        let e = self.0.mul_add(b.0, -p) + (self.0 * b.1 + self.1 * b.0);
        Self::sum(p, e)
    }

    fn over(self, b: Self) -> Self {
        let q = self.0 / b.0;
        let rest = self.minus(b.times(Self(q, 0.0)));
        let r = rest.0 / b.0;
        let last = rest.minus(b.times(Self(r, 0.0)));
        Self::sum(q, r).plus(Self(last.0 / b.0, 0.0))
    }

    fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self::ZERO;
        }
        let s = self.0.sqrt();
        let rest = self.minus(Self(s, 0.0).times(Self(s, 0.0)));
        Self::sum(s, rest.0 / (2.0 * s))
    }

    /// Returns the sine and the cosine, computed by Taylor series.
    fn sin_cos(self) -> [Self; 2] {
        let (mut term, mut sums) = (Self(1.0, 0.0), [Self::ZERO, Self::ZERO]);
        for k in 0..48 {
            let sum = &mut sums[(k + 1) % 2];
            *sum = if k / 2 % 2 == 0 { sum.plus(term) } else { sum.minus(term) };
            term = term.times(self).over(Self(f64::from(k as u32 + 1), 0.0));
        }
        sums
    }

    /// Returns the angle of a point, computed by one Newton step from the f64 angle.
    fn angle(y: Self, x: Self) -> Self {
        if y.0 == 0.0 && x.0 == 0.0 {
            return Self::ZERO;
        }
        let size = x.times(x).plus(y.times(y)).sqrt();
        let angle = Self(y.0.atan2(x.0), 0.0);
        let [sin, cos] = angle.sin_cos();
        let rest = y.times(cos).minus(x.times(sin)).over(size);
        angle.plus(rest)
    }
}

fn dot(a: [Wide; 3], b: [Wide; 3]) -> Wide {
    a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
}

/// Returns the winding number of triangles around a point that lies on none of them, by the formula
/// of van Oosterom and Strackee.
pub(super) fn winding_number<S: Scalar>(triangles: &[TriangleOf<S>], point: [S; 3]) -> f64 {
    let mut sum = Wide::ZERO;
    for TriangleOf(corners) in triangles {
        let seen =
            |c: &[S; 3]| [0, 1, 2].map(|k| Wide::sum(c[k].into(), -Into::<f64>::into(point[k])));
        let [a, b, c] = [&corners[0], &corners[1], &corners[2]].map(seen);
        let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
        let cross = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            b[i].times(c[j]).minus(b[j].times(c[i]))
        });
        let num = dot(a, cross);
        let den = la.times(lb).times(lc).plus(dot(a, b).times(lc));
        let den = den.plus(dot(b, c).times(la)).plus(dot(c, a).times(lb));
        sum = sum.plus(Wide::angle(num, den));
    }
    let turn = Wide(std::f64::consts::TAU, 2.449_293_598_294_706_4e-16);
    sum.over(turn).0
}

#[test]
fn it_has_thirty_digits() {
    // If the tangent of an angle is 1/3, its cosine is three times its sine. The triangle below
    // covers an eighth of all directions.
    let Wide(high, low) = Wide::angle(Wide(1.0, 0.0), Wide(3.0, 0.0));
    let [sin, cos] = Wide(high, low).sin_cos();
    let three = cos.over(sin).minus(Wide(3.0, 0.0));
    assert!(three.0.abs() < 1e-29, "{three:?}", three = three.0);
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(winding_number(&[TriangleOf([x, y, z])], [0.0_f64; 3]), 0.125);
}
