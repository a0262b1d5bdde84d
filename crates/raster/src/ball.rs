//! Decides, in rational arithmetic, whether the surface of a shadow volume comes close to the point
//! that a pixel shows.
//!
//! The visible point P is where the line of sight through the pixel's centre meets the triangle's
//! plane. Two roundings move P, so P is known only to be in a ball around the exact point:
//!
//! ```text
//!   eye o---___ m                        The line of sight moves by m = r pixels, which is m / q at
//!       ^      ---___                    the view depth 1/q. On the plane, the point moves farther
//!       |            ---(--P--)---       the more edge-on the plane is: at most by the factor
//!      1/q at P         plane            1 + (|d| + m) / (|d| cos - m). Rounding the shadow ray
//!                                        adds 2^-24 of the ray's length.
//! ```
//!
//! Here d is the direction through the pixel's centre, with length 1 along the view direction, and
//! cos is the cosine of the angle between d and the plane's normal.
//!
//! The surface of a shadow volume consists of flat pieces: near caps, with three finite borders,
//! and sides, with one finite border and two infinite ones. A piece meets the ball if one of its
//! borders does, or if the ball meets the piece's plane and the ball's centre projects into the
//! piece.

use crate::disc::Disc;
use crate::exact::{Exact, Point, abs, add, cross, dot, exact, point, rounded, scale, size, sub};
use crate::silhouette::Light;
use crate::vector::Vector;
use crate::view::View;
use crate::volume::Volume;

/// A ball around the point that a pixel shows. Its radius is a bound on the point's error.
pub(crate) struct Ball<'a> {
    volume: &'a Volume<'a>,
    centre: Point,
    radius: Exact,
    /// A cube around the ball, in f64: its centre, half its side, and the largest absolute
    /// coordinate of the centre and the light.
    cube: (Vector, f64, f64),
}

/// One border of a flat piece: its start, its direction, and whether it has an end.
struct Border {
    from: Point,
    way: Point,
    ends: bool,
    /// Whether the piece is to the left of the border when its normal points at the viewer.
    left: bool,
}

impl<'a> Ball<'a> {
    /// Returns the ball for a pixel that shows a face of the mesh, or `None` if the point's error
    /// has no finite bound, for example because the face may be edge-on to the eye.
    pub(crate) fn new(
        view: &View,
        volume: &'a Volume<'a>,
        face: usize,
        x: u32,
        y: u32,
    ) -> Option<Self> {
        let disc = Disc::new(view, x, y);
        let d = disc.pixel_directions();
        let eye = point(view.eye());
        let [c1, c2, c3] = volume.adjacency().corners(face).map(point);
        let [p, q, arm] = [sub(&c2, &c1), sub(&c3, &c1), sub(&c1, &eye)];
        let normal = cross(&p, &q);
        let (height, offset) = (dot(&normal, &d), dot(&normal, &arm));
        if height.is_zero() || offset.is_zero() {
            return None;
        }
        let depth = abs(&offset / &height);
        let centre = add(&eye, &scale(&d, &(&offset / &height)));

        // The rest is computed in f64 and rounded up, so that the radius is an upper bound.
        let over = 1.0 + 2f64.powi(-40);
        let length = |a: &Point| rounded(&dot(a, a)).sqrt() * over;
        let (moved, directions, steep) =
            (rounded(&disc.radius) * over, length(&d), length(&normal));
        let upright = rounded(&abs(height.clone())) / over - steep * moved;
        if upright <= 0.0 {
            return None;
        }
        let slant = 1.0 + (directions + moved) * steep / upright;
        // The f64 rounding error of the depth, bounded as in depth comparisons.
        let products = size(&p) * size(&q);
        let doubt = &products * size(&d) / abs(height) + products * size(&arm) / abs(offset);
        let far = match volume.light() {
            Light::Point { position, .. } => length(&sub(&centre, &point(position))),
            Light::Directional { toward, .. } => length(&centre) + 2.0 * length(&point(toward)),
        };
        let depth = rounded(&depth);
        let rounding = 2f64.powi(-24) * far
            + 2f64.powi(-48) * rounded(&doubt) * depth * directions
            + 2f64.powi(-44) * (length(&eye) + depth * directions);
        let radius = (moved * depth * slant + rounding) * over;

        let middle = [0, 1, 2].map(|k| rounded(&centre[k]));
        let light = match volume.light() {
            Light::Point { position, .. } => position.map(f64::from),
            Light::Directional { .. } => [0.0; 3],
        };
        let most = largest(&[middle, light]);
        radius.is_finite().then(|| Self {
            volume,
            centre,
            radius: exact(radius),
            cube: (middle, radius, most),
        })
    }

    /// Returns whether the near cap of a face meets the ball.
    pub(crate) fn meets_cap(&self, face: [u32; 3]) -> bool {
        self.may_meet(&face, &[]) && {
            let corners = face.map(|corner| self.near(corner));
            let border = |i: usize| {
                let way = sub(&corners[(i + 1) % 3], &corners[i]);
                Border { from: corners[i].clone(), way, ends: true, left: true }
            };
            let borders = [0, 1, 2].map(border);
            self.meets(&cross(&borders[0].way, &borders[1].way), &borders)
        }
    }

    /// Returns whether the side behind an edge meets the ball.
    pub(crate) fn meets_side(&self, edge: [u32; 2]) -> bool {
        self.may_meet(&edge, &edge) && {
            let [a, b] = edge.map(|end| self.near(end));
            let [far_a, far_b] = edge.map(|end| self.far(end));
            let way = sub(&b, &a);
            // If the edge begins at the light itself, its first end is not extruded.
            let mut normal = cross(&way, &far_a);
            if normal.iter().all(Exact::is_zero) {
                normal = cross(&way, &far_b);
            }
            let borders = [
                Border { from: a.clone(), way: far_a, ends: false, left: false },
                Border { from: a, way, ends: true, left: true },
                Border { from: b, way: far_b, ends: false, left: true },
            ];
            self.meets(&normal, &borders)
        }
    }

    /// Returns whether a flat piece with these borders meets the ball.
    fn meets(&self, normal: &Point, borders: &[Border; 3]) -> bool {
        let square = self.radius.sqr();
        let over = |border: &Border| {
            let side = dot(normal, &cross(&border.way, &sub(&self.centre, &border.from)));
            if border.left { side >= Exact::ZERO } else { side <= Exact::ZERO }
        };
        let near_plane = || {
            let height = dot(normal, &sub(&self.centre, &borders[1].from));
            let size = dot(normal, normal);
            !size.is_zero() && height.sqr() <= &square * size
        };
        borders.iter().any(|border| self.meets_border(border, &square))
            || near_plane() && borders.iter().all(over)
    }

    /// Returns whether a border meets the ball, that is, whether the border's point nearest to the
    /// centre is in the ball.
    fn meets_border(&self, Border { from, way, ends, .. }: &Border, square: &Exact) -> bool {
        let arm = sub(&self.centre, from);
        let (along, length) = (dot(&arm, way), dot(way, way));
        if along <= Exact::ZERO {
            return dot(&arm, &arm) <= *square;
        }
        if *ends && along >= length {
            let arm = sub(&arm, way);
            return dot(&arm, &arm) <= *square;
        }
        dot(&arm, &arm) * &length - along.sqr() <= square * &length
    }

    /// Returns the point where the volume begins behind a corner. For a point light, this point is
    /// `1 / reach` times as far from the light as the corner. For a directional light, it is the
    /// corner, shifted away from the light by `1 - reach` times the vector to the light.
    fn near(&self, corner: u32) -> Point {
        let place = point(self.volume.adjacency().points()[corner as usize]);
        match self.volume.light() {
            Light::Point { reach, .. } => {
                let beyond = (Exact::from(1) - exact(reach)) / exact(reach);
                add(&place, &scale(&self.far(corner), &beyond))
            }
            Light::Directional { reach, .. } => {
                add(&place, &scale(&self.far(corner), &(Exact::from(1) - exact(reach))))
            }
        }
    }

    /// Returns the direction in which the volume extends from a corner to infinity.
    fn far(&self, corner: u32) -> Point {
        match self.volume.light() {
            Light::Point { position, .. } => {
                sub(&point(self.volume.adjacency().points()[corner as usize]), &point(position))
            }
            Light::Directional { toward, .. } => point(toward).map(|x| -x),
        }
    }

    /// A fast, conservative f64 test of the piece with these corners. The piece extends to infinity
    /// from the corners in `endless`. Returns false only if the piece is outside the ball or one of
    /// its corners is not finite.
    fn may_meet(&self, corners: &[u32], endless: &[u32]) -> bool {
        let (middle, half, most) = self.cube;
        let volume = self.volume;
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut largest = most;
        for &corner in corners {
            let place = volume.near(corner);
            if !place.iter().all(|x| x.is_finite()) {
                return false;
            }
            for k in 0..3 {
                (lo[k], hi[k]) = (lo[k].min(place[k]), hi[k].max(place[k]));
                largest = largest.max(place[k].abs());
            }
        }
        for &corner in endless {
            for (k, way) in volume.far(corner).into_iter().enumerate() {
                if way < 0.0 {
                    lo[k] = f64::NEG_INFINITY;
                } else if way > 0.0 {
                    hi[k] = f64::INFINITY;
                }
            }
        }
        let room = half + 2f64.powi(-40) * largest;
        (0..3).all(|k| lo[k] <= middle[k] + room && middle[k] - room <= hi[k])
    }
}

fn largest(points: &[Vector]) -> f64 {
    points.as_flattened().iter().fold(0.0, |most, x| x.abs().max(most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjacency::Adjacency;
    use intertri::Triangle;

    /// Returns a ball with an arbitrary centre and radius.
    fn ball<'a>(volume: &'a Volume<'a>, centre: Vector, radius: f64) -> Ball<'a> {
        let cube = (centre, radius, largest(&[centre]));
        Ball { volume, centre: point(centre), radius: exact(radius), cube }
    }

    fn volume(adjacency: &Adjacency) -> Volume<'_> {
        let light = Light::Point { position: [0.0, 0.0, 4.0], reach: 1.0 };
        Volume::new(adjacency, light).unwrap()
    }

    #[test]
    fn a_ball_that_touches_meets_and_no_other() {
        // The triangle is in the plane z = 1 and has a right angle at the corner directly below the
        // light.
        let adjacency =
            Adjacency::new(&[Triangle([[0.0, 0.0, 1.0], [8.0, 0.0, 1.0], [0.0, 8.0, 1.0]])]);
        let volume = volume(&adjacency);
        let cap = |centre, radius| ball(&volume, centre, radius).meets_cap([0, 1, 2]);
        let side = |centre, radius| ball(&volume, centre, radius).meets_side([0, 1]);

        // The cap's point nearest to these centres is inside the cap, on an edge, or at a corner.
        for (centre, distance) in [
            ([1.0, 2.0, 4.0], 3.0),
            ([2.0, -3.0, 5.0], 5.0),
            ([-2.0, -3.0, 7.0], 7.0),
            ([11.0, -4.0, 1.0], 5.0),
            ([7.0, 7.0, 1.0], 18f64.sqrt().next_up()),
        ] {
            assert!(cap(centre, distance), "{centre:?}");
            assert!(!cap(centre, distance * (1.0 - 2f64.powi(-50))), "{centre:?}");
        }
        // The side is in the plane y = 0, below the cap, from x = 0 to the line from the light
        // through (8, 0, 1), which descends 3 for every 8 to the right.
        for (centre, distance) in [
            ([1.0, 2.0, 0.0], 2.0),
            ([5.0, -7.0, -1e6], 7.0),
            ([-3.0, 4.0, -9.0], 5.0),
            ([4.0, 3.0, 5.0], 5.0),
            ([8.0 + 800.0 + 3.0, 0.0, 1.0 - 300.0 + 8.0], 73f64.sqrt().next_up()),
        ] {
            assert!(side(centre, distance), "{centre:?}");
            assert!(!side(centre, distance * (1.0 - 2f64.powi(-50))), "{centre:?}");
        }
    }

    #[test]
    fn a_side_that_begins_in_the_light_or_points_at_it() {
        let adjacency = Adjacency::new(&[
            Triangle([[0.0, 0.0, 4.0], [3.0, 0.0, 4.0], [0.0, 1.0, 4.0]]),
            Triangle([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 5.0, 1.0]]),
        ]);
        let volume = volume(&adjacency);
        // The edge starts at the light and runs to the right, so everything behind its end is on
        // the same line.
        let meets = |edge, centre, radius| ball(&volume, centre, radius).meets_side(edge);
        assert!(meets([0, 1], [90.0, 3.0, 8.0], 5.0));
        assert!(!meets([0, 1], [90.0, 3.0, 8.0], 4.99));
        assert!(!meets([0, 1], [-3.0, 0.0, 4.0], 2.99));
        // An edge directly below the light.
        assert!(meets([3, 4], [3.0, 4.0, -70.0], 5.0));
        assert!(!meets([3, 4], [3.0, 4.0, -70.0], 4.99));
        assert!(!meets([3, 4], [0.0, 0.0, 3.0], 0.99));
    }
}
