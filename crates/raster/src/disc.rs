//! Decides, in rational arithmetic, what can be visible within a given distance of a pixel's
//! centre.
//!
//! Points are relative to the eye: X to the right, Y up, W ahead. The image is at W = 1, where
//! the pixel is a disc of radius r around its centre c. Everything visible in the disc is in a
//! cone:
//!
//! ```text
//!               ___--- cone     A point is in it if  |(X, Y) - W c| <= r W  and W > 0.
//!   eye o----(c)-----
//!               """---          A plane n · x = n · a has  q = 1/W = n · (x, y, 1) / n · a,
//!            W = 1              which is linear in (x, y).
//! ```

use intertri::{Triangle, TriangleOf};

use crate::exact::{
    Exact, Point, abs, cross, dot, exact, point, sign_with_root, sign_with_roots, size, sub,
};
use crate::view::View;

/// The disc of a pixel: all points of the image within the tolerance of the pixel's centre.
pub(crate) struct Disc {
    eye: Point,
    axes: [Point; 3],
    /// The centre at W = 1.
    centre: Point,
    /// The [`View::tolerance`], as a length at W = 1.
    pub(crate) radius: Exact,
}

/// A triangle relative to the eye.
struct SeenTriangle {
    corners: [Point; 3],
    /// `n · (x, y, 1)`, which is positive where the triangle is in front of the eye.
    height: Linear,
    /// `n · a`, which is non-negative.
    offset: Exact,
    /// A bound on the f64 rounding error of the offset.
    doubt: Exact,
}

/// A linear function of the position in the image.
struct Linear {
    /// The value at the centre.
    value: Exact,
    /// The slopes along x and y.
    slope: [Exact; 2],
    /// A bound on the f64 rounding error of its value.
    doubt: Exact,
}

impl Linear {
    /// Returns the square of the gradient's length.
    fn steepness(&self) -> Exact {
        self.slope[0].sqr() + self.slope[1].sqr()
    }

    /// Returns whether the function is 0 somewhere in a disc of the given radius around the centre.
    fn vanishes(&self, radius: &Exact) -> bool {
        let beyond = &self.doubt - abs(self.value.clone());
        sign_with_root(&beyond, radius, &self.steepness()).is_ge()
    }
}

impl Disc {
    /// Creates the disc of radius [`View::tolerance`] around the centre of a pixel.
    pub(crate) fn new(view: &View, x: u32, y: u32) -> Self {
        let pixel = exact(2.0 * view.half_height()) / Exact::from(view.height());
        // The centre of the image is (0, 0), and y grows downward.
        let from_middle = |place: u32, side: u32| {
            (Exact::from(2 * place + 1) - Exact::from(side)) / Exact::from(2) * &pixel
        };
        let centre = [from_middle(x, view.width()), -from_middle(y, view.height()), Exact::from(1)];
        Self {
            eye: point(view.eye()),
            axes: view.axes().map(point),
            centre,
            radius: exact(view.tolerance()) * pixel,
        }
    }

    /// Returns the direction of the line of sight through the centre, in scene coordinates. Its
    /// component along forward is 1.
    pub(crate) fn pixel_directions(&self) -> Point {
        [0, 1, 2].map(|k| {
            let along = |axis: usize| &self.axes[axis][k] * &self.centre[axis];
            along(0) + along(1) + along(2)
        })
    }

    /// Returns whether the pixel may show either member of the pair. `None` means that no triangle
    /// is visible.
    pub(crate) fn excuses(&self, pair: [Option<&Triangle>; 2]) -> bool {
        // A triangle that is degenerate or not finite is never visible.
        let [one, other] = pair.map(|triangle| triangle.map(|triangle| self.see(triangle)));
        if matches!(one, Some(None)) || matches!(other, Some(None)) {
            return false;
        }
        let (one, other) = (one.flatten(), other.flatten());
        let alone =
            |seen: &SeenTriangle| self.meets_outline(seen) || seen.height.vanishes(&self.radius);
        if [&one, &other].into_iter().flatten().any(alone) {
            return true;
        }
        one.zip(other).is_some_and(|(one, other)| tie(&one, &other).vanishes(&self.radius))
    }

    /// Returns whether a triangle can be visible at the distance `t`, that is, whether `q t = |d|`
    /// for its plane somewhere in the disc, up to a relative error of 2^-22. Here `d` is the
    /// direction through the centre.
    pub(crate) fn may_be_at(&self, triangle: &Triangle, t: f64) -> bool {
        let Some(seen) = self.see(triangle).filter(|_| t.is_finite() && t > 0.0) else {
            return false;
        };
        if seen.offset <= seen.doubt {
            return true;
        }
        let (t, length) = (exact(t), dot(&self.centre, &self.centre));
        let Linear { value, doubt, .. } = &seen.height;
        let (reach, steep) = (&t * &self.radius, seen.height.steepness());
        // Compare (value +- radius sqrt(steep) +- doubt) t with (offset -+ doubt) (1 -+ 2^-22)
        // sqrt(length).
        let factor = |sign: i32| Exact::from(1) + exact(f64::from(sign) * 2f64.powi(-22));
        let least = (&seen.doubt - &seen.offset) * factor(-1);
        let most = (&seen.offset + &seen.doubt) * factor(1);
        sign_with_roots(&((value + doubt) * &t), [&reach, &steep], [&least, &length]).is_ge()
            && sign_with_roots(&((doubt - value) * &t), [&reach, &steep], [&most, &length]).is_ge()
    }

    /// Returns the triangle relative to the eye, with its normal pointing away from the eye, or
    /// `None` if it is degenerate or not finite.
    fn see(&self, TriangleOf(corners): &Triangle) -> Option<SeenTriangle> {
        // Both engines compute the height with about 12 f64 roundings, and the offset with about as
        // many.
        let unit = exact(2f64.powi(-48));
        if !corners.as_flattened().iter().all(|x| x.is_finite()) {
            return None;
        }
        let corners = corners.map(|corner| {
            let arm = sub(&point(corner), &self.eye);
            [0, 1, 2].map(|axis| dot(&self.axes[axis], &arm))
        });
        let [p, q] = [1, 2].map(|i| sub(&corners[i], &corners[0]));
        let mut normal = cross(&p, &q);
        if normal.iter().all(Exact::is_zero) {
            return None;
        }
        let mut offset = dot(&normal, &corners[0]);
        if offset < Exact::ZERO {
            (normal, offset) = (normal.map(|x| -x), -offset);
        }
        let product = size(&p) * size(&q) * unit;
        let doubt = &product * size(&corners[0]);
        let value = dot(&normal, &self.centre);
        let [nx, ny, _] = normal;
        let height = Linear { value, slope: [nx, ny], doubt: product * size(&self.centre) };
        Some(SeenTriangle { corners, height, offset, doubt })
    }

    /// Returns whether an edge of a triangle meets the cone.
    fn meets_outline(&self, SeenTriangle { corners: [a, b, c], .. }: &SeenTriangle) -> bool {
        [(a, b), (b, c), (c, a)].into_iter().any(|(a, b)| self.meets(a, b))
    }

    /// Returns whether the segment from a to b meets the cone. A point is in the cone if `W > 0`
    /// and `f >= 0`, where `f = (r W)^2 - |(X, Y) - W c|^2` is a quadratic function of the position
    /// s along the segment:
    ///
    /// ```text
    ///   a ------(======)------ b     Either an end is in the cone or, because the cone is convex,
    ///           f  >=  0             both zeros of f are on the segment, and so is its maximum.
    /// ```
    fn meets(&self, a: &Point, b: &Point) -> bool {
        let aside = |p: &Point| [0, 1].map(|k| &p[k] - &p[2] * &self.centre[k]);
        let ([ax, ay], [bx, by]) = (aside(a), aside(b));
        let (aw, bw) = (&self.radius * &a[2], &self.radius * &b[2]);
        let inside =
            |x: &Exact, y: &Exact, w: &Exact| *w > Exact::ZERO && w.sqr() >= x.sqr() + y.sqr();
        if inside(&ax, &ay, &aw) || inside(&bx, &by, &bw) {
            return true;
        }

        // f = k2 s^2 + 2 k1 s + k0, with its maximum at s = k1 / -k2
        let (dx, dy, dw) = (bx - &ax, by - &ay, bw - &aw);
        let fall = dx.sqr() + dy.sqr() - dw.sqr();
        let k1 = &aw * &dw - &ax * &dx - &ay * &dy;
        if k1 <= Exact::ZERO || k1 >= fall {
            return false;
        }
        let s = k1 / fall;
        inside(&(ax + dx * &s), &(ay + dy * &s), &(aw + dw * &s))
    }
}

/// Returns the difference of two depths `q = height / offset`, multiplied by both offsets.
fn tie(one: &SeenTriangle, other: &SeenTriangle) -> Linear {
    let across =
        |k: usize| &one.height.slope[k] * &other.offset - &other.height.slope[k] * &one.offset;
    let doubt = |a: &SeenTriangle, b: &SeenTriangle| {
        &a.height.doubt * &b.offset + abs(a.height.value.clone()) * &b.doubt
    };
    Linear {
        value: &one.height.value * &other.offset - &other.height.value * &one.offset,
        slope: [across(0), across(1)],
        doubt: doubt(one, other) + doubt(other, one),
    }
}
