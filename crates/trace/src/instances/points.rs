//! Point queries on a committed scene: closest points and winding numbers.

use intertri::internal::exact::{Side, facing, is_on};
use intertri::{Ray64, Rule, TriangleId};

use super::collect::{Candidate, Collect};
use super::hit::{InstanceId, SceneClosestPoint};
use super::nearest::Search;
use super::snapshot::{PIECE, SceneSnapshot};
use crate::containment::Containment;
use crate::nearest::ClosestPoint;
use crate::solid::WINDING_DIR;
use crate::util::threads;

/// Point queries. As in [`Bvh::closest_point`](crate::Bvh::closest_point) and
/// [`Solid`](crate::Solid), geometry masks have no effect, but instance masks do.
impl SceneSnapshot {
    /// Returns the point on the instances that is closest to a given point, if it is within a
    /// radius. The result is what [`Bvh::closest_point`](crate::Bvh::closest_point) would find
    /// among the world-space triangles. If several triangles are equally close, the lower instance
    /// number wins, then the lower geometry number, then the lower triangle index.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use intertri_trace::{Bvh, Scene};
    /// use intertri_trace::intertri::Triangle;
    /// let floor = Arc::new(Bvh::new(&[Triangle::new([-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0])])?);
    /// let at = |y| [1.0, 0.0, 0.0, 0.0, /**/ 0.0, 1.0, 0.0, y, /**/ 0.0, 0.0, 1.0, 0.0];
    /// let mut scene = Scene::new();
    /// scene.add(floor.clone(), at(0.0))?;
    /// let upper = scene.add(floor, at(4.0))?;
    /// let found = scene.commit()?.closest_point([0.0, 3.0, 0.0], f64::INFINITY).unwrap();
    /// assert_eq!((found.instance, found.closest.distance), (upper, 1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn closest_point(&self, point: [f64; 3], radius: f64) -> Option<SceneClosestPoint> {
        if !(radius >= 0.0 && point.iter().all(|x| x.is_finite())) {
            return None;
        }
        let mut search = Search::new(self, point, radius);
        let Candidate { instance, position, triangle } = search.run()?;
        let mut closest = ClosestPoint::on(point, &triangle);
        if closest.distance > radius {
            return None;
        }
        let mesh = &self.committed.mesh(instance as usize)?.mesh;
        let name = mesh.tree().geometries.name(TriangleId(position));
        (closest.geometry, closest.triangle) = (name.geometry, name.triangle);
        Some(SceneClosestPoint { closest, instance: InstanceId(instance) })
    }

    /// Calls [`SceneSnapshot::closest_point`] for many points, using all threads. A point without a
    /// closest point yields [`SceneClosestPoint::NONE`].
    pub fn closest_point_batch(&self, points: &[[f64; 3]], radius: f64) -> Vec<SceneClosestPoint> {
        let mut closest = vec![SceneClosestPoint::NONE; points.len()];
        threads::write(&mut closest, PIECE, |i| {
            self.closest_point(points[i], radius).unwrap_or(SceneClosestPoint::NONE)
        });
        closest
    }

    /// Classifies a point as on a triangle of an instance, inside, or outside. For a point inside,
    /// the result includes the number of times that all instances together wind around it, counted
    /// as in [`Solid::classify`](crate::Solid::classify). A mirrored instance of a closed mesh
    /// contributes −1.
    ///
    /// If a mesh is not closed, the result depends on the direction in which crossings are counted.
    pub fn classify(&self, point: [f64; 3]) -> Containment {
        if !point.iter().all(|x| x.is_finite()) {
            return Containment::Outside;
        }
        // A point on the surface is neither inside nor outside, and counting crossings from it
        // would depend on the direction. `is_on` is false for triangles with zero area.
        let mut search = Search::new(self, point, 0.0);
        if search.any(|triangle| is_on(triangle, point)) {
            return Containment::Surface;
        }
        let ray = Ray64::new(point, WINDING_DIR.map(f64::from));
        let mut winding = Winding { ray: &ray, containment: Containment::Outside };
        self.trace(&ray, Rule::Once, &mut winding);
        winding.containment
    }

    /// Calls [`SceneSnapshot::classify`] for many points, using all threads.
    pub fn classify_batch(&self, points: &[[f64; 3]]) -> Vec<Containment> {
        let mut all = vec![Containment::Outside; points.len()];
        threads::write(&mut all, PIECE, |i| self.classify(points[i]));
        all
    }
}

/// Sums crossings with their signs.
struct Winding<'a> {
    ray: &'a Ray64,
    containment: Containment,
}

impl Collect for Winding<'_> {
    fn all_geometries(&self) -> bool {
        true
    }

    fn take(&mut self, hit: Candidate, _: [f64; 2]) -> bool {
        // Crossings are found under `Rule::Once`, so `facing` always returns a side.
        let leaves = facing(self.ray, &hit.triangle) == Some(Side::Leaves);
        self.containment = self.containment.crossed(leaves);
        true
    }

    fn far(&self) -> f64 {
        f64::INFINITY
    }
}
