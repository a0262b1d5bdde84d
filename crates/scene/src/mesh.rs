//! Indexed triangle meshes, their parts, and bounding boxes.

use glam::DVec3;
use intertri::{Scalar, TriangleOf};

use crate::coordinate::Coordinate;

/// A run of triangles with the same material, from `first` up to, but not including, the next
/// part's `first`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The first triangle of the part.
    pub first: u32,
    /// The albedo: the linear fraction of red, green, and blue light that the part reflects, in
    /// `0..=1`.
    pub tint: [f32; 3],
    /// Whether the albedo is multiplied by the scene's texture.
    pub textured: bool,
}

/// An indexed triangle mesh.
///
/// Triangles keep the order of the file. A polygon becomes the fan of triangles around its first
/// corner, in order: `(0, 1, 2), (0, 2, 3), ...`. If that fan would reach outside a concave
/// polygon, ear clipping cuts it into the same number of triangles. Positions keep their order and
/// their values in the file, rounded once to f32 or, for a `Mesh<f64>`, to f64. They are not
/// welded, moved, or dropped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh<S = f32> {
    /// The positions of the vertices. In a mesh made by [`crate::load`], all positions that
    /// triangles use are finite.
    pub positions: Vec<[S; 3]>,
    /// Three indices into `positions` per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The texture coordinates of the three corners of each triangle, or `None` if no triangle has
    /// texture coordinates. If only some triangles have texture coordinates, the others have zeros.
    pub corner_uvs: Option<Vec<[[f32; 2]; 3]>>,
    /// The parts, in ascending order of `first`; empty for a mesh with only one material.
    pub parts: Vec<Part>,
}

impl Mesh {
    /// The albedo of triangles without a part: the colour of clay.
    pub const CLAY: [f32; 3] = [0.62, 0.58, 0.52];
}

impl<S: Coordinate> Mesh<S> {
    /// Returns the triangles for the kernel to intersect, in the order of the mesh.
    ///
    /// # Panics
    /// Panics if an index is outside `positions`; [`crate::load`] never makes such a mesh.
    pub fn to_triangles(&self) -> Vec<TriangleOf<S>> {
        (0..self.triangles.len()).map(|i| TriangleOf(self.corners(i))).collect()
    }

    /// Returns the three corners of triangle `index`.
    ///
    /// # Panics
    /// Panics if the index is out of bounds.
    pub fn corners(&self, index: usize) -> [[S; 3]; 3] {
        self.triangles[index].map(|corner| self.positions[corner as usize])
    }

    /// Returns the part that triangle `index` belongs to, or `None` if it belongs to no part.
    pub fn part(&self, index: usize) -> Option<&Part> {
        let after = self.parts.partition_point(|part| part.first as usize <= index);
        after.checked_sub(1).map(|part| &self.parts[part])
    }

    /// Iterates over the corners of all triangles. Positions that no triangle uses are skipped.
    pub fn points(&self) -> impl Iterator<Item = [S; 3]> {
        self.triangles.as_flattened().iter().map(|&corner| self.positions[corner as usize])
    }

    /// Returns the bounding box of all triangles, or `None` if there are no triangles.
    pub fn bounds(&self) -> Option<Bounds<S>> {
        Bounds::around(self.points())
    }
}

/// An axis-aligned bounding box, including its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<S = f32> {
    /// The smallest x, y, and z.
    pub min: [S; 3],
    /// The largest x, y, and z.
    pub max: [S; 3],
}

impl<S: Scalar> Bounds<S> {
    /// Returns the bounding box of points, or `None` if there are no points.
    pub(crate) fn around(mut points: impl Iterator<Item = [S; 3]>) -> Option<Self> {
        let first = points.next()?;
        let mut bounds = Self { min: first, max: first };
        for p in points {
            for (axis, x) in p.into_iter().enumerate() {
                let x: f64 = x.into();
                bounds.min[axis] = S::nearest(x.min(bounds.min[axis].into()));
                bounds.max[axis] = S::nearest(x.max(bounds.max[axis].into()));
            }
        }
        Some(bounds)
    }

    /// Returns a box that contains only the origin.
    pub(crate) fn point() -> Self {
        Self { min: [S::ZERO; 3], max: [S::ZERO; 3] }
    }

    /// Returns the eight corners of the box.
    pub(crate) fn corners(&self) -> [[S; 3]; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|i| [ends[i & 1][0], ends[i >> 1 & 1][1], ends[i >> 2][2]])
    }

    /// Returns the centre of the box.
    pub(crate) fn centre(&self) -> DVec3 {
        // Halve first, so that the sum of the largest values does not overflow.
        double(self.min) * 0.5 + double(self.max) * 0.5
    }

    /// Returns half the diagonal, or 1 if the box is a single point, so that a length derived from
    /// it is never 0.
    pub(crate) fn radius(&self) -> f64 {
        let radius = (double(self.max) * 0.5 - double(self.min) * 0.5).length();
        if radius > 0.0 { radius } else { 1.0 }
    }

    /// Returns whether a point is in the box or on its boundary.
    pub(crate) fn contains(&self, p: [S; 3]) -> bool {
        (0..3).all(|axis| self.min[axis] <= p[axis] && p[axis] <= self.max[axis])
    }
}

/// Converts a point to f64.
pub(crate) fn double<S: Scalar>(p: [S; 3]) -> DVec3 {
    DVec3::from(p.map(Into::<f64>::into))
}

/// Rounds a point to the scalar `S`.
pub(crate) fn rounded<S: Scalar>(p: DVec3) -> [S; 3] {
    p.to_array().map(S::nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip() -> Mesh {
        Mesh {
            positions: vec![[9.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -3.0]],
            triangles: vec![[1, 2, 3], [3, 2, 4]],
            corner_uvs: None,
            parts: vec![Part { first: 1, tint: [0.5; 3], textured: false }],
        }
    }

    #[test]
    fn triangles_keep_order_and_bits() {
        let triangles = strip().to_triangles();
        assert_eq!(triangles[0].0, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        assert_eq!(triangles[1].0, [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -3.0]]);
    }

    #[test]
    fn bounds_hold_only_what_is_used() {
        let bounds = strip().bounds().unwrap();
        assert_eq!((bounds.min, bounds.max), ([0.0, 0.0, -3.0], [1.0, 2.0, 0.0]));
        assert_eq!(Mesh::<f32>::default().bounds(), None);
    }

    #[test]
    fn parts_run_to_the_next() {
        assert_eq!(strip().part(0), None);
        assert_eq!(strip().part(1), Some(&strip().parts[0]));
    }
}
