//! Where rays cross a mesh, each edge and corner once: by the mode `exact`.

use intertri::internal::Test;
use intertri::internal::exact::{self, Side};
use intertri::{Crossing, Crossings, Exact, Mode, Ray};

use super::{Only, batch, one};
use crate::answers::Answers;
use crate::place::Place;
use crate::select::Select;
use crate::single::is_on_surface;
use crate::tree::Bvh;

/// The way in which winding numbers are counted: any is as good as another. Of the common ones it is none, so
/// that few edges are met exactly.
const DIR: [f32; 3] = [0.537_21, 0.351_37, 0.766_91];

impl Bvh {
    /// Where a ray crosses the triangles, in order of the exact t; of equal t, of the index.
    ///
    /// The answers are those of [`Exact::crossings`] over all triangles: a point on an edge or a corner
    /// belongs to one of the triangles that have it.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// // A square, crossed exactly on its diagonal.
    /// let [a, b, c, d] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
    /// let bvh = Bvh::new(&[Triangle::new(a, b, c), Triangle::new(d, c, b)])?;
    /// let ray = Ray::new([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(bvh.crossings(&Exact::default(), &ray).len(), 1);
    /// assert_eq!(bvh.all(&Exact::default(), &ray).len(), 2);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn crossings(&self, mode: &Exact, ray: &Ray) -> Vec<Crossing> {
        self.only(&Select::ALL).crossings(mode, ray)
    }

    /// How often each of many rays crosses the triangles: `crossings[i]` becomes the count of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn crossings_batch(&self, mode: &Exact, rays: &[Ray], crossings: &mut [Crossings]) {
        self.only(&Select::ALL).crossings_batch(mode, rays, crossings);
    }

    /// Where a point lies.
    pub(crate) fn place(&self, mode: Exact, point: [f32; 3]) -> Place {
        if is_on_surface(self, point) {
            return Place::Surface;
        }
        let ray = Ray::new(point, DIR);
        let places = one::places(self, (&None, 0), mode.test().into(), &ray);
        let sides = places.iter().filter_map(|&i| exact::crossing(&ray, &self.triangle_in(i)));
        sides.fold(Place::Outside, |place, side| place.crossed(side == Side::Leaves))
    }

    /// Where points lie, told by a function of that.
    pub(crate) fn places<A: Send>(
        &self,
        mode: Exact,
        points: &[[f32; 3]],
        answers: &mut [A],
        answer: impl Fn(Place) -> A + Sync,
    ) {
        batch::chunks(points, answers, |_, points, answers| {
            let rays: Vec<Ray> = points.iter().map(|&point| Ray::new(point, DIR)).collect();
            let mut places = vec![Place::Outside; points.len()];
            let asked = batch::Asked { bvh: self, choice: None, rays: &rays, on_grid: &[] };
            let counts = batch::chunk(asked, mode.test(), Answers::Places(&mut places));
            for (place, to) in places.into_iter().zip(answers) {
                *to = answer(place);
            }
            counts
        });
    }
}

impl Only<'_> {
    /// [`Bvh::crossings`] of the triangles that count.
    pub fn crossings(&self, mode: &Exact, ray: &Ray) -> Vec<Crossing> {
        let (bvh, resolver) = (self.bvh, mode.test().resolver());
        let crossed = |place: u32| {
            let triangle = bvh.triangle_in(place);
            let leaves = exact::crossing(ray, &triangle)? == Side::Leaves;
            let hit = resolver.hit_attributes(ray, &triangle, bvh.index_of(place));
            Some((Crossing { hit, leaves }, triangle))
        };
        let choice = self.one();
        let places = one::places(bvh, (&choice, 0), mode.test().into(), ray);
        let mut all: Vec<_> = places.into_iter().filter_map(crossed).collect();
        all.sort_unstable_by(|(a, at), (b, bt)| resolver.first(ray, (&a.hit, at), (&b.hit, bt)));
        let told = |(mut crossing, _): (Crossing, _)| {
            bvh.geometries.tell(std::slice::from_mut(&mut crossing.hit));
            crossing
        };
        all.into_iter().map(told).collect()
    }

    /// [`Bvh::crossings_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn crossings_batch(&self, mode: &Exact, rays: &[Ray], crossings: &mut [Crossings]) {
        crossings.fill(Crossings::default());
        batch::answer(self.many(rays), mode.test().into(), Answers::Crossings(crossings));
    }
}
