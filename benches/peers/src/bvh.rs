//! An engine that uses the `bvh` crate. The crate traverses boxes and leaves the triangle test to
//! the caller; this engine uses plain Möller-Trumbore, in f32 or f64.

use std::ops::Range;

use ::bvh::aabb::{Aabb, Bounded};
use ::bvh::bounding_hierarchy::{BHShape, BHValue, BoundingHierarchy};
use ::bvh::bvh::Bvh;
use intertri::{RayOf, Scalar, TriangleOf};
use nalgebra::{Point3, Vector3};

use crate::engine::{Answer, Engine, Question, Singles};

/// A scalar that the crate supports: f32 or f64.
pub trait Real: BHValue + Scalar {}
impl Real for f32 {}
impl Real for f64 {}

struct Shape<S: Real> {
    corners: [Point3<S>; 3],
    index: u32,
    node: usize,
}

impl<S: Real> Bounded<S, 3> for Shape<S> {
    fn aabb(&self) -> Aabb<S, 3> {
        let [a, b, c] = &self.corners;
        Aabb::with_bounds(a.inf(&b.inf(c)), a.sup(&b.sup(c)))
    }
}

impl<S: Real> BHShape<S, 3> for Shape<S> {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl<S: Real> Shape<S> {
    /// Returns the distance to the triangle, if the ray hits it within `0..far`.
    #[inline(always)]
    fn hit(&self, ray: &::bvh::ray::Ray<S, 3>, far: S) -> Option<S> {
        let [a, b, c] = &self.corners;
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(&e2);
        let inverse = S::ONE / e1.dot(&p);
        let s = ray.origin - a;
        let u = s.dot(&p) * inverse;
        let q = s.cross(&e1);
        let v = ray.direction.dot(&q) * inverse;
        let t = e2.dot(&q) * inverse;
        (u >= S::ZERO && v >= S::ZERO && u + v <= S::ONE && t >= S::ZERO && t < far).then_some(t)
    }
}

pub struct TwoWay<S: Real = f32> {
    bvh: Bvh<S, 3>,
    shapes: Vec<Shape<S>>,
    /// Each ray with the end of its interval.
    rays: Singles<(::bvh::ray::Ray<S, 3>, S)>,
}

impl<S: Real> TwoWay<S> {
    pub fn new(triangles: &[TriangleOf<S>]) -> Self {
        let shape = |(i, t): (usize, &TriangleOf<S>)| Shape {
            corners: t.0.map(Point3::from),
            index: i as u32,
            node: 0,
        };
        let mut shapes: Vec<_> = triangles.iter().enumerate().map(shape).collect();
        let bvh = Bvh::build_par(&mut shapes);
        Self { bvh, shapes, rays: Singles::default() }
    }
}

impl<S: Real> Engine<RayOf<S>> for TwoWay<S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
        self.rays.load(rays, question, |r| {
            let direction = Vector3::from(r.dir);
            let inv_direction = direction.map(|x| S::ONE / x);
            let origin = Point3::from(r.origin);
            (::bvh::ray::Ray { origin, direction, inv_direction }, r.t_max)
        });
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { bvh, shapes, rays } = self;
        let (bvh, shapes) = (&*bvh, &shapes[..]);
        rays.trace(
            part,
            |(ray, far)| {
                let (mut best, mut far) = (Answer::MISS, *far);
                for shape in bvh.nearest_traverse_iterator(ray, shapes) {
                    // Candidates arrive in order of box distance, so all remaining ones are farther
                    // away.
                    let from = ray.intersection_slice_for_aabb(&shape.aabb());
                    if from.is_some_and(|(from, _)| from > far) {
                        break;
                    }
                    if let Some(t) = shape.hit(ray, far) {
                        best = Answer { triangle: shape.index, t: t.into() };
                        far = t;
                    }
                }
                best
            },
            |(ray, far)| {
                bvh.traverse_iterator(ray, shapes).any(|shape| shape.hit(ray, *far).is_some())
            },
        );
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
