//! Where two shadow masks of the same picture may differ, decided pixel by pixel.
//!
//! The point that a pixel shows is known up to a small ball: its line of sight up to
//! [`View::tolerance`] in the picture (which is the longer a way on the surface, the more edge-on it
//! is seen), and the direction of its shadow ray up to rounding to f32. A difference is excused where
//! the surface of a shadow volume, a side or a near cap, comes into that ball:
//!
//! ```text
//!        * light
//!         \
//!    ------\            the side behind the edge of a blocker: the silhouette's shadow;
//!           \ .--.      a near cap: a blocker that touches, or the own surface edge-on to the light
//!            (\ P )
//!      -------`--'----- surface
//! ```

use intertri::Hit;

use crate::differences::Verdict;
use crate::silhouette::Light;
use crate::stencil::depths;
use crate::threads;
use crate::vector::{Vector, add, cross, dot, double, length, scale, sub};
use crate::view::View;
use crate::volume::Volume;

/// Compares two shadow masks of what one view shows, row by row.
///
/// Where the masks differ, the shown point is taken with its ball of uncertainty: in radius, the way
/// on the triangle's plane that [`View::tolerance`] pixels are, and 2^-24 of the distance to the
/// light (of the distance to the origin, for a directional one). The difference is excused if a near
/// cap or a side of a volume comes into the ball, or the plane of a triangle which is edge-on to the
/// light, or if the shown triangle's plane is edge-on to the eye within the tolerance. Where the
/// reach of the light is 1, the shown triangle's own cap does not count.
///
/// # Panics
/// If a slice is not as long as the view has pixels.
pub fn shadow_differences(
    view: &View,
    hits: &[Hit],
    volume: &Volume<'_>,
    one: &[bool],
    other: &[bool],
) -> Vec<Verdict> {
    let width = view.width() as usize;
    let pixels = width * view.height() as usize;
    assert!([hits.len(), one.len(), other.len()] == [pixels; 3], "one entry a pixel");
    let seen = depths(view, &view.sight(), hits, volume);
    let mut verdicts = vec![Verdict::Same; pixels];
    threads::parts(&mut verdicts, width, |y, row, (): &mut ()| {
        for (x, verdict) in row.iter_mut().enumerate() {
            let i = y * width + x;
            if one[i] != other[i] {
                let ball = Ball::of(view, &hits[i], volume, seen[i], [x, y]);
                let excused = ball.is_none_or(|ball| ball.meets(volume, hits[i].triangle));
                *verdict = if excused { Verdict::Excused } else { Verdict::Unexcused };
            }
        }
    });
    verdicts
}

/// Where the visible point may be.
struct Ball {
    centre: Vector,
    radius: f64,
}

impl Ball {
    /// The ball of a pixel, or `None` where the surface is edge-on to the eye and the ball unbounded.
    fn of(view: &View, hit: &Hit, volume: &Volume<'_>, q: f64, [x, y]: [usize; 2]) -> Option<Self> {
        let sight = view.sight();
        let d = view.direction(x as f64 + 0.5, y as f64 + 0.5);
        let arm = scale(d, 1.0 / q);
        let centre = add(view.eye(), arm);

        // The line of sight may move by so much per unit of view depth, and the point on the plane
        // by that much more as the plane is seen edge-on.
        let moved = view.tolerance() * length(sight.dx).max(length(sight.dy));
        let face =
            usize::try_from(hit.triangle).ok().filter(|&f| f < volume.adjacency().faces().len());
        let slant = match face {
            None => 1.0,
            Some(face) => {
                let [c1, c2, c3] = volume.adjacency().corners(face).map(double);
                let normal = cross(sub(c2, c1), sub(c3, c1));
                let upright = dot(normal, d).abs() - length(normal) * moved;
                if upright <= 0.0 {
                    return None;
                }
                1.0 + length(d) * length(normal) / upright
            }
        };
        let far = match volume.light() {
            Light::Point { position, .. } => length(sub(centre, double(position))),
            Light::Directional { .. } => length(centre),
        };
        let rounding = 2f64.powi(-24) * far + 2f64.powi(-44) * (length(view.eye()) + length(arm));
        let radius = moved / q * slant + rounding;
        (radius.is_finite() && centre.iter().all(|x| x.is_finite()))
            .then_some(Self { centre, radius })
    }

    /// Whether the surface of a volume comes into the ball.
    fn meets(&self, volume: &Volume<'_>, own: u64) -> bool {
        let own_cap = !matches!(volume.light(), Light::Point { reach, .. } if reach < 1.0);
        let mut faces = 0..volume.adjacency().faces().len();
        faces.any(|face| match volume.cap(face) {
            Some(cap) => !(own_cap && face as u64 == own) && self.meets_cap(volume, cap),
            None => self.meets_plane(volume, face),
        }) || volume.silhouette().iter().any(|side| self.meets_side(volume, side.ends))
    }

    /// A near cap: the plane, and inside of all three edges, each up to the radius.
    fn meets_cap(&self, volume: &Volume<'_>, cap: [u32; 3]) -> bool {
        let [a, b, c] = cap.map(|point| sub(volume.near(point), self.centre));
        let normal = cross(sub(b, a), sub(c, a));
        let size = length(normal);
        let inside = |from: Vector, to: Vector| {
            // The distance from the edge's line within the plane, positive inside.
            dot(normal, cross(sub(to, from), scale(from, -1.0))) / size
                >= -self.radius * length(sub(to, from))
        };
        dot(normal, a).abs() <= self.radius * size && inside(a, b) && inside(b, c) && inside(c, a)
    }

    /// The plane of a triangle that is edge-on to the light. It throws no shadow, but of a shadow ray
    /// along it rounding alone says whether, and where, it is hit.
    fn meets_plane(&self, volume: &Volume<'_>, face: usize) -> bool {
        let [a, b, c] = volume.adjacency().corners(face).map(|c| sub(double(c), self.centre));
        let normal = cross(sub(b, a), sub(c, a));
        let size = length(normal);
        size > 0.0 && dot(normal, a).abs() <= self.radius * size
    }

    /// A side: its plane, and inside of its edge and of its two lines to infinity.
    fn meets_side(&self, volume: &Volume<'_>, [a, b]: [u32; 2]) -> bool {
        let [from, to] = [a, b].map(|point| sub(volume.near(point), self.centre));
        let [far_from, far_to] = [a, b].map(|point| volume.far(point));
        let edge = sub(to, from);
        let normal = cross(edge, far_from);
        let size = length(normal);
        let inside = |through: Vector, along: Vector, sign: f64| {
            sign * dot(normal, cross(along, scale(through, -1.0))) / size
                >= -self.radius * length(along)
        };
        dot(normal, from).abs() <= self.radius * size
            && inside(from, edge, 1.0)
            && inside(from, far_from, -1.0)
            && inside(to, far_to, 1.0)
    }
}
