//! Whether two points see each other: segments, and the surfaces on which their ends lie.
//!
//! ```text
//!            light                  a segment ends on surfaces but for rounding: just before, on or
//!           ╱                       behind them. These do not count, so nothing shades itself
//!     ────●╱────  surface           by accident; all others do, exactly
//! ```
//!
//! Rays are traced without a choice first, so that they can go in bundles. Those that hit something are traced again,
//! with a predicate that leaves out the triangles at their ends. Definition: `docs/numerics/exact.md`, section 9.

use intertri::internal::Bits;
use intertri::internal::exact::{Tier, closest};
use intertri::{RayOf, TriangleOf};

use super::Only;
use super::batch;
use crate::answers::Answers;
use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::select::Select;

/// A triangle this many units of rounding from an end, or nearer, is one on which the end lies.
const UNITS: f64 = 16.0;

/// Segments that are traced together: they are copied.
const PIECE: usize = 1 << 16;

impl<S: Given> Bvh<S> {
    /// Whether no triangle hides two points from each other, other than those on which they lie.
    ///
    /// A point lies on a triangle if it is no farther from it than 16 units of rounding (`2^-23` or `2^-52` of the
    /// largest coordinate of both points and the triangle's corners). So a surface does not shade itself, however its
    /// points were rounded, also across an edge. If your points are less accurate, name their triangles in
    /// [`Select::skip`] and ask [`Only::visible`]. Any other triangle hides them where it meets the ray from `a` in
    /// direction `b - a` at `0 < t < 1`. Points with a NaN or an infinity see nothing.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Triangle64};
    /// let [a, b, c] = [[0.1, 0.2, 0.3], [1.3, 0.1, 0.7], [0.4, 1.1, 0.2]];
    /// let bvh = Bvh::new(&[Triangle64([a, b, c])])?;
    /// let center = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
    /// let light = [3.0, 1.0, 4.0];
    /// assert!(bvh.visible(&Exact::default(), center, light));
    /// assert!(bvh.visible(&Exact::default(), light, a));
    /// assert!(!bvh.visible(&Exact::default(), light, [-1.8, -0.2, -3.2]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn visible<M: ModeFor<S>>(&self, mode: &M, a: [S; 3], b: [S; 3]) -> bool {
        self.only(&Select::ALL).visible(mode, a, b)
    }

    /// [`Bvh::visible`] of the ends of many segments: `visible[i]` becomes the answer of `segments[i]`.
    ///
    /// It is fastest if segments start or end at one point, such as a light, as for [`Bvh::any_batch`].
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn visible_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        segments: &[[[S; 3]; 2]],
        visible: &mut [bool],
    ) {
        self.only(&Select::ALL).visible_batch(mode, segments, visible);
    }
}

impl<S: Given> Only<'_, S> {
    /// [`Bvh::visible`] of the triangles that count. A list of what to skip may name the triangles of both ends.
    pub fn visible<M: ModeFor<S>>(&self, mode: &M, a: [S; 3], b: [S; 3]) -> bool {
        let mut visible = [false];
        self.visible_batch(mode, &[[a, b]], &mut visible);
        visible[0]
    }

    /// [`Bvh::visible_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what segments skip, differ in length.
    pub fn visible_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        segments: &[[[S; 3]; 2]],
        visible: &mut [bool],
    ) {
        self.visible_within(mode, segments, (S::DIGITS - 1) as u32, visible);
    }

    /// The same of points that were rounded to so many bits behind the first.
    #[doc(hidden)]
    pub fn visible_within<M: ModeFor<S>>(
        &self,
        mode: &M,
        segments: &[[[S; 3]; 2]],
        bits: u32,
        visible: &mut [bool],
    ) {
        assert_eq!(segments.len(), visible.len(), "one answer a segment");
        let (skip, reach) = (self.select.skip, UNITS / (1_u64 << bits) as f64);
        let lists = skip.len();
        assert!(lists == 0 || lists == segments.len(), "a list of what to skip a segment, or none");
        for (i, (segments, visible)) in
            segments.chunks(PIECE).zip(visible.chunks_mut(PIECE)).enumerate()
        {
            let skip = if lists == 0 { skip } else { &skip[i * PIECE..][..segments.len()] };
            let select = Select { skip, ..*self.select };
            self.bvh.only(&select).visible_piece(mode, segments, reach, visible);
        }
    }

    /// The same of so few that they can be copied.
    fn visible_piece<M: ModeFor<S>>(
        &self,
        mode: &M,
        segments: &[[[S; 3]; 2]],
        reach: f64,
        visible: &mut [bool],
    ) {
        let rays: Vec<_> = segments.iter().map(ray_of).collect();
        let (all, occluded) = (Select { skip: &[], ..*self.select }, &mut *visible);
        self.bvh.only(&all).any_batch(mode, &rays, occluded);

        // Those that hit something, which may be where they end.
        let hidden: Vec<_> = (0..segments.len()).filter(|&i| visible[i]).collect();
        let rays: Vec<_> = hidden.iter().map(|&i| rays[i]).collect();
        let lists: Vec<_> = match self.select.skip {
            [] => Vec::new(),
            skip => hidden.iter().map(|&i| skip[i]).collect(),
        };
        let select = Select { skip: &lists, ..*self.select };
        let counts = |number: usize, place: u32| {
            let (segment, triangle) = (&segments[hidden[number]], self.bvh.triangle(place));
            !lies_on(segment, &triangle, reach)
        };
        let mut occluded = vec![false; rays.len()];
        self.asked(mode, &rays, Some(select.filtered(&counts)), |many| {
            batch::answer(many, Answers::Any(&mut occluded));
        });

        for (visible, segment) in visible.iter_mut().zip(segments) {
            *visible = segment.as_flattened().iter().all(|x| Bits::is_finite(*x));
        }
        for (&i, occluded) in hidden.iter().zip(occluded) {
            visible[i] &= !occluded;
        }
    }
}

/// The ray from one end of a segment to the other.
fn ray_of<S: Given>([a, b]: &[[S; 3]; 2]) -> RayOf<S> {
    let way = |share: f64| [0, 1, 2].map(|k| S::nearest(share * b[k].into() - share * a[k].into()));
    let dir = way(1.0);
    if dir.iter().all(|x| Bits::is_finite(*x)) {
        return RayOf::new(*a, dir).between(S::ZERO, S::ONE);
    }
    RayOf::new(*a, way(0.5)).between(S::ZERO, S::from(2.0))
}

/// Whether one end of a segment lies on a triangle, but for so large a part of the largest coordinate.
fn lies_on<S: Given>(ends: &[[S; 3]; 2], triangle: &TriangleOf<S>, reach: f64) -> bool {
    let corners = triangle.0.map(|corner| corner.map(Into::<f64>::into));
    let all = corners.as_flattened().iter().copied();
    let ends64 = ends.map(|end| end.map(Into::<f64>::into));
    let most = all.chain(ends64.as_flattened().iter().copied());
    let reach = reach * most.fold(0.0, |most: f64, x| most.max(x.abs()));

    // Few triangles that hide a segment are near its ends: twice the reach has room for rounding.
    let is_near = |end: [f64; 3]| {
        (0..3).all(|k| {
            let [a, b, c] = [0, 1, 2].map(|i| corners[i][k]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            low - end[k] <= 2.0 * reach && end[k] - high <= 2.0 * reach
        })
    };
    ends.iter().zip(ends64).any(|(&end, end64)| {
        is_near(end64) && closest(Tier::Float, end, triangle).distance <= reach
    })
}
