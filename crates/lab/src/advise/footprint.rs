//! A triangle's footprint: the part of an image in which the triangle may affect the answer.

#![expect(clippy::neg_cmp_op_on_partial_ord, reason = "NaN counts as doubtful")]

use std::ops::Range;

use intertri::Triangle;

use super::arithmetic::{Arithmetic, moves};
use super::camera::PinholeCamera;
use super::facet::Facet;
use super::vector::Vec3d;

/// The inputs of a scan, shared by all bands.
pub(super) struct ScanInput<'a> {
    pub(super) triangles: &'a [Triangle],
    pub(super) camera: &'a PinholeCamera<'a>,
    pub(super) arithmetics: &'a [Arithmetic],
    pub(super) forward: Vec3d,
}

/// The pixels where a triangle may affect the answer.
pub(super) struct Footprint {
    pub(super) columns: Range<u32>,
    pub(super) rows: Range<u32>,
    /// Whether the triangle is seen so nearly edge-on that f32 may report hits outside it.
    pub(super) strip: bool,
}

impl ScanInput<'_> {
    pub(super) fn facet(&self, index: usize) -> Facet {
        Facet::new(&self.triangles[index], self.camera.eye, self.forward)
    }

    /// Returns a triangle's bounding box in the image, widened by the largest error of any
    /// arithmetic.
    pub(super) fn footprint(&self, facet: &Facet) -> Footprint {
        let (width, height) = self.camera.size;
        let nothing = Footprint { columns: 0..0, rows: 0..0, strip: false };
        if !facet.is_finite() {
            return nothing;
        }
        let reach = facet.reach();
        let moves = |&a: &Arithmetic| moves(a, reach);
        let mut moves = self.arithmetics.iter().map(moves).fold(0.0, f64::max);
        if facet.depth.1 + moves < 0.0 {
            return nothing;
        }
        let spill = facet.spill();
        let strip = !(spill < 0.5);
        if !strip {
            moves += 2.0 * spill * facet.side;
        }

        // The projection of a triangle too close to the eye has no useful bounds, so its footprint
        // is the whole image.
        let nearest = facet.depth.0;
        if !(moves < nearest / 4.0) {
            return Footprint { columns: 0..width, rows: 0..height, strip };
        }
        let [right, up, _] = self.camera.axes.map(Vec3d::splat);
        let pixel = self.camera.pixel();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in facet.corners {
            let depth = corner.dot(self.forward);
            let at = [corner.dot(right) / depth, -corner.dot(up) / depth];
            for axis in 0..2 {
                let off = moves * (1.0 + at[axis].abs()) / (nearest - moves);
                low[axis] = low[axis].min(at[axis] - off);
                high[axis] = high[axis].max(at[axis] + off);
            }
        }
        let range = |axis: usize, size: u32| {
            let place = |x: f64| x / pixel + 0.5 * f64::from(size) - 0.5;
            let first = (place(low[axis]).floor() - 1.0).clamp(0.0, f64::from(size)) as u32;
            let end = (place(high[axis]).ceil() + 2.0).clamp(0.0, f64::from(size)) as u32;
            first..end.max(first)
        };
        Footprint { columns: range(0, width), rows: range(1, height), strip }
    }
}
