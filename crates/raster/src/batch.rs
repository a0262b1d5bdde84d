//! Prepares outlines for drawing: clips them, snaps them, and sorts them into bands of rows.
//!
//! The image is divided into bands of several full rows each. The first pass processes the facets
//! in batches on all threads: it prepares their outlines and records which outlines reach into each
//! band. The second pass draws each band's outlines in order, with one band per task. The result
//! does not depend on the number of threads.

use crate::clip::{NO_FAR_WALL, Point4, Scratch, clip_facet};
use crate::plane::FacetPlane;
use crate::spans::{BAND, first_centre};
use crate::threads;
use crate::view::View;

/// The number of facets per batch.
const BATCH: usize = 2048;

/// One outline in the image.
pub(crate) struct Piece {
    /// The depth of the outline.
    pub(crate) plane: FacetPlane,
    /// The caller's id for the outline.
    pub(crate) tag: i32,
    /// The first row that the outline reaches, and the row after the last.
    rows: (u32, u32),
    /// The range of its corners in [`Batch::corners`].
    corners: (u32, u32),
}

/// The outlines of several facets, and for each band the indices of the outlines to draw, in order.
pub(crate) struct Batch {
    corners: Vec<[i32; 2]>,
    pieces: Vec<Piece>,
    bands: Vec<Vec<u32>>,
    scratch: Scratch,
}

impl Batch {
    fn new(view: &View) -> Self {
        let bands = view.height().div_ceil(BAND) as usize;
        Self {
            corners: Vec::new(),
            pieces: Vec::new(),
            bands: vec![Vec::new(); bands],
            scratch: Scratch::default(),
        }
    }

    /// Clips and snaps an outline and adds it to the bands that it reaches. If its bounds contain
    /// no pixel centre, it is skipped before its plane is computed.
    pub(crate) fn push(
        &mut self,
        view: &View,
        outline: impl IntoIterator<Item = Point4>,
        tag: i32,
        plane: impl FnOnce() -> Option<FacetPlane>,
    ) {
        let start = self.corners.len();
        let clipped = clip_facet(outline, NO_FAR_WALL, &mut self.scratch);
        self.corners.extend(clipped.iter().map(|&corner| view.snap(corner)));

        // Find the rows and columns whose centres are within the outline's bounds.
        let reach = |axis: usize| {
            let corners = self.corners[start..].iter().map(|corner| corner[axis]);
            let (lo, hi) = corners.fold((i32::MAX, 0), |(lo, hi), x| (lo.min(x), hi.max(x)));
            (first_centre(lo), first_centre(hi))
        };
        let fits = clipped.len() >= 3;
        let (columns, rows) = if fits { (reach(0), reach(1)) } else { ((0, 0), (0, 0)) };
        if columns.0 >= columns.1 || rows.0 >= rows.1 {
            self.corners.truncate(start);
            return;
        }
        let Some(plane) = plane() else {
            self.corners.truncate(start);
            return;
        };

        let index = self.pieces.len() as u32;
        let corners = (start as u32, self.corners.len() as u32);
        self.pieces.push(Piece { plane, tag, rows, corners });
        for band in rows.0 / BAND..=(rows.1 - 1) / BAND {
            self.bands[band as usize].push(index);
        }
    }

    /// Iterates over the outlines that reach into a band, each with its corners and its rows within
    /// the band.
    pub(crate) fn of_band(
        &self,
        band: usize,
    ) -> impl Iterator<Item = (&Piece, &[[i32; 2]], (u32, u32))> {
        let (top, bottom) = (band as u32 * BAND, (band as u32 + 1) * BAND);
        self.bands[band].iter().map(move |&index| {
            let piece = &self.pieces[index as usize];
            let corners = &self.corners[piece.corners.0 as usize..piece.corners.1 as usize];
            (piece, corners, (piece.rows.0.max(top), piece.rows.1.min(bottom)))
        })
    }
}

/// Prepares `count` facets in batches, and returns the batches in order. `prepare(batch, i)` must
/// push the i-th facet to the batch.
pub(crate) fn batches(
    view: &View,
    count: usize,
    prepare: impl Fn(&mut Batch, usize) + Sync + Send,
) -> Vec<Batch> {
    threads::map(count.div_ceil(BATCH), |number| {
        let mut batch = Batch::new(view);
        for i in number * BATCH..((number + 1) * BATCH).min(count) {
            prepare(&mut batch, i);
        }
        batch
    })
}
