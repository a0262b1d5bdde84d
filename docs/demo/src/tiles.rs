//! Divides an image into square tiles and lists the triangles that may be visible in each tile. To
//! find them, every triangle of the model is projected onto the image and enlarged by a margin.
//!
//! The published methods have no hierarchy. With these lists, they find the same hits as a loop
//! over all triangles.

use intertri::Triangle;

use crate::input::double;

/// The number of pixels along the side of a tile. A packet holds the rays of one row of a tile.
pub(crate) const SIDE: usize = 8;

/// A camera view. The direction through a pixel is `forward + x right + y up`, where [`View::at`]
/// returns x and y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) size: [usize; 2],
    pub(crate) eye: [f32; 3],
    pub(crate) axes: [[f64; 3]; 3],
    pub(crate) pixel: f64,
    pub(crate) shift: [f64; 2],
}

impl View {
    /// Returns the x and y of a pixel's centre.
    pub(crate) fn at(&self, column: usize, row: usize) -> [f64; 2] {
        let [width, height] = self.size.map(|n| n as f64);
        [
            self.shift[0] + (column as f64 + 0.5 - 0.5 * width) * self.pixel,
            self.shift[1] + (0.5 * height - 0.5 - row as f64) * self.pixel,
        ]
    }

    /// Projects a point to pixel coordinates. Returns `None` if it is not in front of the eye.
    fn project(&self, point: [f32; 3]) -> Option<[f64; 2]> {
        let [right, up, forward] = self.axes;
        let seen = [0, 1, 2].map(|k| f64::from(point[k]) - f64::from(self.eye[k]));
        let dot = |axis: [f64; 3]| axis[0] * seen[0] + axis[1] * seen[1] + axis[2] * seen[2];
        let depth = dot(forward);
        let [width, height] = self.size.map(|n| n as f64);
        (depth > 0.0).then(|| {
            let x = (dot(right) / depth - self.shift[0]) / self.pixel + 0.5 * width - 0.5;
            let y = 0.5 * height - 0.5 - (dot(up) / depth - self.shift[1]) / self.pixel;
            [x, y]
        })
    }

    /// Returns an upper bound on the distance, in pixels, by which rounding to f32 and the errors
    /// of a method can move a triangle.
    fn margin(&self) -> f64 {
        let longest = self.axes.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        2.0 + longest * f64::from(f32::EPSILON) * 16.0 / self.pixel
    }
}

/// Returns the indices of each tile's triangles in ascending order. The tiles are in row-major
/// order.
pub(crate) fn by_tile(view: &View, triangles: &[Triangle]) -> Vec<Vec<u32>> {
    let [columns, rows] = view.size.map(|n| n.div_ceil(SIDE));
    let mut tiles = vec![vec![]; columns * rows];
    let margin = view.margin();
    for (index, triangle) in triangles.iter().enumerate() {
        let seen = triangle.0.map(|corner| view.project(corner));
        // A triangle that is partly behind the eye can appear anywhere in the image.
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in seen {
            let corner = corner.map_or([[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]], |p| [p, p]);
            for k in 0..2 {
                low[k] = low[k].min(corner[0][k]);
                high[k] = high[k].max(corner[1][k]);
            }
        }
        if seen.iter().all(Option::is_none) {
            continue;
        }
        // Casts saturate, so an out-of-range value becomes the nearest integer in range.
        let first = |k: usize| ((low[k] - margin).max(0.0) / SIDE as f64) as usize;
        let end = |k: usize, n: usize| {
            let last = (high[k] + margin) / SIDE as f64;
            if last < 0.0 { 0 } else { (last as usize).saturating_add(1).min(n) }
        };
        for row in first(1)..end(1, rows) {
            for column in first(0)..end(0, columns) {
                tiles[row * columns + column].push(index as u32);
            }
        }
    }
    tiles
}

/// Returns the centre and radius of a sphere that contains all corners.
pub(crate) fn ball(triangles: &[Triangle]) -> ([f64; 3], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in triangles.iter().flat_map(|triangle| triangle.0) {
        let corner = double(corner);
        for k in 0..3 {
            low[k] = low[k].min(corner[k]);
            high[k] = high[k].max(corner[k]);
        }
    }
    let half = [0, 1, 2].map(|k| 0.5 * (high[k] - low[k]));
    let radius = (half[0] * half[0] + half[1] * half[1] + half[2] * half[2]).sqrt();
    ([0, 1, 2].map(|k| low[k] + half[k]), if radius > 0.0 { radius } else { 1.0 })
}
