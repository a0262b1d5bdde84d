//! Indexed triangles, in the order of their file.

use glam::DVec3;
use intertri::Triangle;

/// A run of triangles that look alike: from `first` to the next part's `first`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The first triangle of the part.
    pub first: u32,
    /// Its albedo: the linear share of red, green and blue light that it reflects, in `0..=1`.
    pub tint: [f32; 3],
    /// Whether its albedo is multiplied by the scene's texture.
    pub textured: bool,
}

/// An indexed triangle mesh.
///
/// Triangles keep the order of the file, and a polygon becomes the triangle fan of its first corner
/// in its own order: `(0, 1, 2), (0, 2, 3), ...`. Positions keep their order and the exact f32 of the
/// file: none is welded, moved or dropped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The positions of the vertices; all finite where [`crate::load`] made the mesh.
    pub positions: Vec<[f32; 3]>,
    /// Three indices into `positions` per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of the three corners of each triangle, or `None` for a mesh without. Where
    /// only some triangles have them, the others have zeros.
    pub corner_uvs: Option<Vec<[[f32; 2]; 3]>>,
    /// The materials by run of triangles, ascending in `first`; empty for a mesh of one material.
    pub parts: Vec<Part>,
}

impl Mesh {
    /// The albedo of clay: that of triangles without a part.
    pub const CLAY: [f32; 3] = [0.62, 0.58, 0.52];

    /// The triangle soup that the kernel intersects. Index `i` here is triangle `i` of the mesh.
    ///
    /// # Panics
    /// If an index lies outside of `positions`; [`crate::load`] never makes such a mesh.
    pub fn to_triangles(&self) -> Vec<Triangle> {
        (0..self.triangles.len()).map(|i| Triangle(self.corners(i))).collect()
    }

    /// The three corners of triangle `index`.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn corners(&self, index: usize) -> [[f32; 3]; 3] {
        self.triangles[index].map(|corner| self.positions[corner as usize])
    }

    /// The part that triangle `index` belongs to; `None` in a mesh that has no parts.
    pub fn part(&self, index: usize) -> Option<&Part> {
        let after = self.parts.partition_point(|part| part.first as usize <= index);
        after.checked_sub(1).map(|part| &self.parts[part])
    }

    /// The corners of all triangles. Positions that no triangle uses are not among them.
    pub fn points(&self) -> impl Iterator<Item = [f32; 3]> {
        self.triangles.as_flattened().iter().map(|&corner| self.positions[corner as usize])
    }

    /// The bounding box of all triangles, or `None` where there is no triangle.
    pub fn bounds(&self) -> Option<Bounds> {
        let first = self.points().next()?;
        let mut bounds = Bounds { min: first, max: first };
        for p in self.points() {
            for (axis, x) in p.into_iter().enumerate() {
                bounds.min[axis] = bounds.min[axis].min(x);
                bounds.max[axis] = bounds.max[axis].max(x);
            }
        }
        Some(bounds)
    }

    /// The bounding box of all triangles, or the origin for a mesh that has none.
    pub(crate) fn bounds_or_point(&self) -> Bounds {
        self.bounds().unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] })
    }
}

/// An axis-aligned bounding box; its border is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest x, y and z.
    pub min: [f32; 3],
    /// The largest x, y and z.
    pub max: [f32; 3],
}

impl Bounds {
    /// The center, in f64 so that the largest f32 do not overflow.
    pub(crate) fn center(&self) -> DVec3 {
        (double(self.min) + double(self.max)) * 0.5
    }

    /// Half of the diagonal, or 1 for a box that is a single point: a scale is never 0.
    pub(crate) fn radius(&self) -> f64 {
        let radius = (double(self.max) - double(self.min)).length() * 0.5;
        if radius > 0.0 { radius } else { 1.0 }
    }

    /// Whether a point is in the box or on its border.
    pub(crate) fn contains(&self, p: [f32; 3]) -> bool {
        (0..3).all(|axis| self.min[axis] <= p[axis] && p[axis] <= self.max[axis])
    }
}

/// A point of a mesh, widened.
pub(crate) fn double(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// A point rounded to f32.
pub(crate) fn single(p: DVec3) -> [f32; 3] {
    p.to_array().map(|x| x as f32)
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
        assert_eq!(Mesh::default().bounds(), None);
    }

    #[test]
    fn parts_run_to_the_next() {
        assert_eq!(strip().part(0), None);
        assert_eq!(strip().part(1), Some(&strip().parts[0]));
    }
}
