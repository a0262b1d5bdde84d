//! Looks up the triangle of a hit and spawns secondary rays.
//!
//! Leaves store the indices of their triangles. The inverse mapping is a table of 4 bytes per
//! triangle, created on first use.

use intertri::{Hit, LeafSlot, RayOf, TriangleId, TriangleOf};

use super::Bvh;
use crate::scalar::BvhScalar;
use crate::tree::MeshTriangle;
use crate::util::lane_ops::lanes_of;

/// The slot of a triangle that is not stored because one of its corners is not finite.
const NOWHERE: LeafSlot = LeafSlot(u32::MAX);

/// Looks up a hit's triangle and normal, and spawns secondary rays.
///
/// The first call to any of these methods creates a table of 4 bytes per triangle, so it is slower
/// than later calls.
impl<S: BvhScalar> Bvh<S> {
    /// Returns the triangle of a hit, or `None` for a miss or an unknown triangle.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::{Hit, Ray, Triangle}};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::from_meshes(&[&[at(5.0)], &[at(7.0), at(3.0)]])?;
    /// let hit = bvh.closest(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0])).unwrap();
    /// assert_eq!((bvh.triangle(&hit), bvh.triangle(&Hit::MISS)), (Some(at(3.0)), None));
    /// assert_eq!(bvh.normal(&hit), Some([0.0, 0.0, 1.0]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn triangle(&self, hit: &Hit) -> Option<TriangleOf<S>> {
        let name = MeshTriangle { triangle: hit.triangle, geometry: hit.geometry };
        let TriangleId(position) = self.tree.geometries.position(name, self.tree.triangles)?;
        let slot = self.slots()[position as usize];
        (slot != NOWHERE).then(|| self.triangle_in(slot))
    }

    /// Returns the unnormalized normal of a hit's triangle; see [`TriangleOf::normal`].
    pub fn normal(&self, hit: &Hit) -> Option<[f64; 3]> {
        self.triangle(hit).map(|triangle| triangle.normal())
    }

    /// Creates a ray that starts at a hit and never hits the triangle it starts from; see
    /// [`spawn_ray`](intertri::spawn_ray). For a miss, the returned ray hits nothing, whatever its
    /// interval.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::{Ray, Triangle}};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.1, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::new(&[at(3.1), at(5.0)])?;
    /// let hit = bvh.closest(&Ray::new([0.2, 0.2, 0.0], [0.01, 0.0, 0.3])).unwrap();
    /// let refracted = bvh.spawn_ray(&hit, [0.02, 0.0, 1.0]);
    /// assert_eq!(bvh.closest(&refracted).unwrap().triangle, 1);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn spawn_ray(&self, hit: &Hit, dir: [S; 3]) -> RayOf<S> {
        match self.triangle(hit) {
            Some(triangle) => intertri::spawn_ray(hit, &triangle, dir),
            None => RayOf::new([S::nearest(f64::NAN); 3], dir),
        }
    }

    /// Creates a ray from a hit to a point, such as a light, at `t = 1`; see
    /// [`spawn_ray_to`](intertri::spawn_ray_to).
    pub fn spawn_ray_to(&self, hit: &Hit, point: [S; 3]) -> RayOf<S> {
        match self.triangle(hit) {
            Some(triangle) => intertri::spawn_ray_to(hit, &triangle, point),
            None => RayOf::new([S::nearest(f64::NAN); 3], point).between(S::ZERO, S::ONE),
        }
    }

    /// Returns the thickness of a solid at a hit: the distance to the next triangle in the
    /// direction opposite to the normal. Corners must run counter-clockwise as seen from outside.
    /// The hit's own triangle does not count. Returns `None` for a miss, if nothing is behind the
    /// hit, or if the triangle is degenerate. As with [`Bvh::spawn_ray`], the ray starts at the
    /// rounded hit point.
    ///
    /// ```
    /// use intertri_trace::{Bvh, intertri::{Ray, Triangle}};
    /// // The two sides of a plate, with normals that point outward.
    /// let top = Triangle::new([0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]);
    /// let bottom = Triangle::new([0.0, 0.0, 4.5], [0.0, 4.0, 4.5], [4.0, 0.0, 4.5]);
    /// let bvh = Bvh::new(&[top, bottom])?;
    /// let hit = bvh.closest(&Ray::new([1.0, 1.0, 9.0], [0.1, 0.0, -1.0])).unwrap();
    /// assert_eq!((hit.triangle, bvh.thickness(&hit)), (0, Some(0.5)));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn thickness(&self, hit: &Hit) -> Option<f64> {
        let normal = self.normal(hit)?;
        // Scale first, so that squaring cannot overflow or underflow.
        let most = normal.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let normal = normal.map(|x| x / most);
        let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let inward = normal.map(|x| S::nearest(-x / size));
        let length = inward.map(|x| Into::<f64>::into(x).powi(2)).iter().sum::<f64>().sqrt();
        Some(self.closest(&self.spawn_ray(hit, inward))?.t * length)
    }

    /// Returns the leaf slot of each triangle, indexed by the triangle's position among the
    /// triangles of all meshes.
    fn slots(&self) -> &[LeafSlot] {
        self.slots.get_or_init(|| {
            let mut slots = vec![NOWHERE; self.tree.triangles];
            for (i, leaf) in self.tree.leaves.iter().enumerate() {
                // After a refit, a triangle may occur in two leaves, with a dead lane in one of
                // them. Only the leaf in which the triangle is present counts.
                for lane in lanes_of(self.tree.present(i)) {
                    slots[leaf.indices[lane] as usize] = LeafSlot((8 * i + lane) as u32);
                }
            }
            slots.into_boxed_slice()
        })
    }
}
