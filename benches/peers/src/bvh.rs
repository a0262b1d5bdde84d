//! The crate `bvh`: boxes are its business, triangles the caller's, who gets a plain f32
//! Möller-Trumbore here.

use std::ops::Range;

use ::bvh::aabb::{Aabb, Bounded};
use ::bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use ::bvh::bvh::Bvh;
use intertri::{Ray, Triangle};
use nalgebra::{Point3, Vector3};

use crate::engine::{Answer, Engine, Question, Singles};

struct Shape {
    corners: [Point3<f32>; 3],
    index: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = &self.corners;
        Aabb::with_bounds(a.inf(&b.inf(c)), a.sup(&b.sup(c)))
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Shape {
    /// How far the triangle is, within `0..far`.
    #[inline(always)]
    fn hit(&self, ray: &::bvh::ray::Ray<f32, 3>, far: f32) -> Option<f32> {
        let [a, b, c] = &self.corners;
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(&e2);
        let inverse = 1.0 / e1.dot(&p);
        let s = ray.origin - a;
        let u = s.dot(&p) * inverse;
        let q = s.cross(&e1);
        let v = ray.direction.dot(&q) * inverse;
        let t = e2.dot(&q) * inverse;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t < far).then_some(t)
    }
}

pub struct TwoWay {
    bvh: Bvh<f32, 3>,
    shapes: Vec<Shape>,
    /// With the end of the interval.
    rays: Singles<(::bvh::ray::Ray<f32, 3>, f32)>,
}

impl TwoWay {
    pub fn new(triangles: &[Triangle]) -> Self {
        let shape = |(i, t): (usize, &Triangle)| Shape {
            corners: t.0.map(Point3::from),
            index: i as u32,
            node: 0,
        };
        let mut shapes: Vec<_> = triangles.iter().enumerate().map(shape).collect();
        let bvh = Bvh::build_par(&mut shapes);
        Self { bvh, shapes, rays: Singles::default() }
    }
}

impl Engine for TwoWay {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.rays.load(rays, question, |r| {
            let direction = Vector3::from(r.dir);
            let inv_direction = direction.map(|x| 1.0 / x);
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
                    // They come in the order of their boxes.
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
