//! Point queries of a committed scene: the closest point of its instances, and how often they wind around a
//! point.

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

/// Point queries. The masks of geometries do not affect them, as in
/// [`Bvh::closest_point`](crate::Bvh::closest_point) and [`Solid`](crate::Solid); those of instances do.
impl SceneSnapshot {
    /// The point of all instances that is closest to a given one, within a radius: as
    /// [`Bvh::closest_point`](crate::Bvh::closest_point) finds it among the triangles in the world. If
    /// several triangles are equally close, the lower instance wins, then the lower geometry, then the lower
    /// triangle.
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

    /// [`SceneSnapshot::closest_point`] of many points, on all threads; [`SceneClosestPoint::NONE`] for a point that has
    /// none.
    pub fn closest_point_batch(&self, points: &[[f64; 3]], radius: f64) -> Vec<SceneClosestPoint> {
        let mut closest = vec![SceneClosestPoint::NONE; points.len()];
        threads::write(&mut closest, PIECE, |i| {
            self.closest_point(points[i], radius).unwrap_or(SceneClosestPoint::NONE)
        });
        closest
    }

    /// Where a point lies: on a triangle of an instance, or inside as often as all instances together wind around it, as
    /// [`Solid::classify`](crate::Solid::classify) counts it. A mirrored instance of a closed mesh counts as −1.
    ///
    /// Instances of meshes that are not closed give an answer that depends on the direction in which crossings are
    /// counted.
    pub fn classify(&self, point: [f64; 3]) -> Containment {
        if !point.iter().all(|x| x.is_finite()) {
            return Containment::Outside;
        }
        // No point is on a triangle without area.
        // A point on the surface has no side: crossings counted from there would depend on the direction.
        let mut search = Search::new(self, point, 0.0);
        if search.any(|triangle| is_on(triangle, point)) {
            return Containment::Surface;
        }
        let ray = Ray64::new(point, WINDING_DIR.map(f64::from));
        let mut winding = Winding { ray: &ray, containment: Containment::Outside };
        self.trace(&ray, Rule::Once, &mut winding);
        winding.containment
    }

    /// [`SceneSnapshot::classify`] of many points, on all threads.
    pub fn classify_batch(&self, points: &[[f64; 3]]) -> Vec<Containment> {
        let mut all = vec![Containment::Outside; points.len()];
        threads::write(&mut all, PIECE, |i| self.classify(points[i]));
        all
    }
}

/// The signed sum of crossings.
struct Winding<'a> {
    ray: &'a Ray64,
    containment: Containment,
}

impl Collect for Winding<'_> {
    const SHORTENS: bool = false;
    const ALL_GEOMETRIES: bool = true;

    fn take(&mut self, hit: Candidate) -> bool {
        // A crossing is a hit by the rule *once*, so the triangle has a side.
        let leaves = facing(self.ray, &hit.triangle) == Some(Side::Leaves);
        self.containment = self.containment.crossed(leaves);
        true
    }

    #[inline(always)]
    fn far(&self) -> f64 {
        f64::INFINITY
    }
}
