//! Visibility between two points, either of which may lie on a surface.
//!
//! ```text
//!            light                  Because of rounding, a segment may end just before, on, or
//!           ╱                       behind a surface. Such surfaces are ignored, so that none
//!     ────●╱────  surface           shades itself by accident. Other surfaces are tested exactly.
//! ```
//!
//! Rays are first traced without skip lists, so that they can be traced in bundles. Rays that hit
//! something are then traced again, with a predicate that ignores the triangles at their ends. For
//! the definition, see `docs/numerics/exact.md`, section 9.

use intertri::internal::Bits;
use intertri::internal::exact::{Tier, closest};
use intertri::{LeafSlot, RayOf, TriangleOf};

use super::Query;
use crate::scalar::BvhScalar;
use crate::selection::Selection;

/// An end of a segment counts as lying on a triangle if it is at most this many rounding units
/// away.
const UNITS: f64 = 16.0;

/// The number of segments to copy and trace at once.
const PIECE: usize = 1 << 16;

/// Visibility queries: whether the two ends of a segment see each other.
///
/// # Panics
/// Panics if the numbers of segments and results differ, or if you set lists of triangles to skip
/// but not one per segment.
impl<S: BvhScalar> Query<'_, S> {
    /// Returns whether two points see each other, that is, whether no triangle lies between them,
    /// apart from the triangles that the points lie on.
    ///
    /// A point counts as lying on a triangle if its distance is at most 16 rounding units (`2^-23`
    /// or `2^-52` of the largest coordinate of both points and the triangle's corners). This keeps
    /// a surface from shading itself, however its points were rounded, even across an edge. If your
    /// points are less accurate, pass their triangles to [`Query::skip`]; a list may contain the
    /// triangles of both ends. Any other triangle blocks the view if the ray from `a` in direction
    /// `b - a` hits it at `0 < t < 1`. A point with a NaN or infinite coordinate sees nothing.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::Triangle64;
    /// let [a, b, c] = [[0.1, 0.2, 0.3], [1.3, 0.1, 0.7], [0.4, 1.1, 0.2]];
    /// let bvh = Bvh::new(&[Triangle64::new(a, b, c)])?;
    /// let centre = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
    /// let light = [3.0, 1.0, 4.0];
    /// assert!(bvh.visible(centre, light));
    /// assert!(bvh.visible(light, a));
    /// assert!(!bvh.visible(light, [-1.8, -0.2, -3.2]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn visible(&self, a: [S; 3], b: [S; 3]) -> bool {
        let mut visible = [false];
        self.visible_batch_into(&[[a, b]], &mut visible);
        visible[0]
    }

    /// Like [`Query::visible`], but for many segments.
    ///
    /// As with [`Query::any_batch`], this is fastest if the segments start or end at a common
    /// point, such as a light.
    pub fn visible_batch(&self, segments: &[[[S; 3]; 2]]) -> Vec<bool> {
        let mut visible = vec![false; segments.len()];
        self.visible_batch_into(segments, &mut visible);
        visible
    }

    /// Like [`Query::visible_batch`], but writes the results to a slice.
    pub fn visible_batch_into(&self, segments: &[[[S; 3]; 2]], visible: &mut [bool]) {
        self.visible_within(segments, (S::DIGITS - 1) as u32, visible);
    }

    /// Like [`Query::visible_batch_into`], but for points whose coordinates were rounded to `bits`
    /// bits after the leading bit.
    #[doc(hidden)]
    pub fn visible_within(&self, segments: &[[[S; 3]; 2]], bits: u32, visible: &mut [bool]) {
        assert_eq!(segments.len(), visible.len(), "one result per segment");
        let (skip, reach) = (self.selection.skip, UNITS / (1_u64 << bits) as f64);
        let lists = skip.len();
        let fits = lists == 0 || lists == segments.len();
        assert!(fits, "pass one list of triangles to skip per segment, or none");
        let pieces = segments.chunks(PIECE).zip(visible.chunks_mut(PIECE));
        for (i, (segments, visible)) in pieces.enumerate() {
            let skip = if lists == 0 { skip } else { &skip[i * PIECE..][..segments.len()] };
            self.visible_piece(segments, Selection { skip, ..self.selection }, reach, visible);
        }
    }

    /// Processes at most [`PIECE`] segments.
    fn visible_piece(
        &self,
        segments: &[[[S; 3]; 2]],
        selection: Selection<'_>,
        reach: f64,
        visible: &mut [bool],
    ) {
        // First trace without skip lists, so that rays can be traced in bundles.
        let (bvh, mode) = (self.bvh, self.mode);
        let rays: Vec<_> = segments.iter().map(ray_of).collect();
        let all = Selection { skip: &[], ..selection }.active(&bvh.tree);
        self.with_selection(all, mode, &rays, visible);

        // These segments hit something, possibly only the surfaces at their ends.
        let hidden: Vec<_> = (0..segments.len()).filter(|&i| visible[i]).collect();
        // Nearly all of these segments hit only the triangle on which one of their ends lies.
        let rays: Vec<_> = hidden.iter().map(|&i| rays[i]).collect();
        let lists: Vec<_> = match selection.skip {
            [] => Vec::new(),
            skip => hidden.iter().map(|&i| skip[i]).collect(),
        };
        let selection = Selection { skip: &lists, ..selection };
        let counts = |number: usize, slot: LeafSlot| {
            let (segment, triangle) = (&segments[hidden[number]], bvh.triangle_in(slot));
            !lies_on(segment, &triangle, reach)
        };
        let mut occluded = vec![false; rays.len()];
        let some = Some(selection.filtered(&counts));
        self.with_selection(some, mode, &rays, &mut occluded);

        for (visible, segment) in visible.iter_mut().zip(segments) {
            // A non-finite point sees nothing.
            *visible = segment.as_flattened().iter().all(|x| Bits::is_finite(*x));
        }
        for (&i, occluded) in hidden.iter().zip(occluded) {
            visible[i] &= !occluded;
        }
    }
}

/// Returns the ray from one end of a segment to the other.
fn ray_of<S: BvhScalar>([a, b]: &[[S; 3]; 2]) -> RayOf<S> {
    // Scale before subtracting, because the difference may overflow even for finite ends.
    let way = |share: f64| [0, 1, 2].map(|k| S::nearest(share * b[k].into() - share * a[k].into()));
    let dir = way(1.0);
    if dir.iter().all(|x| Bits::is_finite(*x)) {
        return RayOf::new(*a, dir).between(S::ZERO, S::ONE);
    }
    // Halving the direction and doubling the interval describes the same segment.
    RayOf::new(*a, way(0.5)).between(S::ZERO, S::from(2.0))
}

/// Returns whether either end of a segment lies on a triangle, to within `reach` times the largest
/// coordinate.
fn lies_on<S: BvhScalar>(ends: &[[S; 3]; 2], triangle: &TriangleOf<S>, reach: f64) -> bool {
    let corners = triangle.0.map(|corner| corner.map(Into::<f64>::into));
    let all = corners.as_flattened().iter().copied();
    let ends64 = ends.map(|end| end.map(Into::<f64>::into));
    let most = all.chain(ends64.as_flattened().iter().copied());
    let reach = reach * most.fold(0.0, |most: f64, x| most.max(x.abs()));

    // Most triangles that block a segment are far from its ends. Doubling the reach leaves a margin
    // for rounding.
    let is_near = |end: [f64; 3]| {
        (0..3).all(|k| {
            let [a, b, c] = [0, 1, 2].map(|i| corners[i][k]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            low - end[k] <= 2.0 * reach && end[k] - high <= 2.0 * reach
        })
    };
    ends.iter().zip(ends64).any(|(&end, end64)| {
        // The exact distance decides, but the bounding boxes first rule out nearly all triangles.
        is_near(end64) && closest(Tier::Float, end, triangle).distance <= reach
    })
}
