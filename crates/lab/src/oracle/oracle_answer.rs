//! The oracle's answer: where the line of a ray meets a triangle, and on which side of its origin.

use std::cmp::Ordering;

/// The place where the *line* of a ray meets a triangle. If several variants apply, the first of
/// them in this list is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinePosition {
    /// Undefined, because an input is NaN or infinite.
    NotFinite,
    /// Nowhere, because the triangle is degenerate.
    Degenerate,
    /// The line lies in the plane of the triangle, or the direction is 0 and the origin lies in
    /// that plane.
    Coplanar,
    /// The line is parallel to the plane, or the direction is 0.
    Parallel,
    /// Outside the triangle.
    Outside,
    /// At the corner with this index: 0, 1, or 2.
    Vertex(u8),
    /// On the side opposite the corner with this index, between its ends.
    Edge(u8),
    /// Inside all three sides.
    Inside,
}

/// The exact answer for a ray and a triangle, regardless of the ray's interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OracleAnswer {
    /// The place where the line meets the triangle.
    pub place: LinePosition,
    /// How `t` compares with 0: `Less` if the line meets the plane behind the origin, `Equal` at
    /// the origin, and `Greater` in front of it. It is also `Equal` if there is no `t`.
    pub t: Ordering,
}

impl OracleAnswer {
    /// Returns whether the open half-line `t > 0` meets the closed triangle.
    ///
    /// A ray in the triangle's plane is not a hit, as document A's parallel test intends.
    pub fn is_hit(self) -> bool {
        self.t == Ordering::Greater
            && matches!(
                self.place,
                LinePosition::Inside | LinePosition::Edge(_) | LinePosition::Vertex(_)
            )
    }

    /// Derives the answer from the signs of the three edge values, `U` first, for a line that meets
    /// the plane at one point.
    pub(super) fn classify(signs: [Ordering; 3], t: Ordering) -> Self {
        let count = |sign| signs.iter().filter(|&&s| s == sign).count();
        let position = |zero: bool| signs.iter().position(|s| (s.is_eq()) == zero);
        let place = if count(Ordering::Less) > 0 && count(Ordering::Greater) > 0 {
            LinePosition::Outside
        } else {
            match count(Ordering::Equal) {
                0 => LinePosition::Inside,
                // One value is 0, so the point is on that side.
                1 => LinePosition::Edge(position(true).unwrap_or(0) as u8),
                // Only one value is not 0, so the point is at that corner.
                _ => LinePosition::Vertex(position(false).unwrap_or(0) as u8),
            }
        };
        Self { place, t }
    }

    /// Creates an answer without a `t`.
    pub(super) fn without_t(place: LinePosition) -> Self {
        Self { place, t: Ordering::Equal }
    }
}
