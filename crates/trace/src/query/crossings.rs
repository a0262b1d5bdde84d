//! Where rays cross a mesh, each edge and corner once: by the mode `exact`.

use intertri::{Crossing, Crossings, Exact, RayOf};

use super::{Only, one};
use crate::answers::Answers;
use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::select::Select;

impl<S: Given> Bvh<S>
where
    Exact: ModeFor<S>,
{
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
    pub fn crossings(&self, mode: &Exact, ray: &RayOf<S>) -> Vec<Crossing> {
        self.only(&Select::ALL).crossings(mode, ray)
    }

    /// How often each of many rays crosses the triangles: `crossings[i]` becomes the count of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn crossings_batch(&self, mode: &Exact, rays: &[RayOf<S>], crossings: &mut [Crossings]) {
        self.only(&Select::ALL).crossings_batch(mode, rays, crossings);
    }
}

impl<S: Given> Only<'_, S>
where
    Exact: ModeFor<S>,
{
    /// [`Bvh::crossings`] of the triangles that count.
    pub fn crossings(&self, mode: &Exact, ray: &RayOf<S>) -> Vec<Crossing> {
        let choice = self.one();
        self.bvh.ask_one(mode, ray, |tree, which, ray| one::crossings(tree, &choice, which, ray))
    }

    /// [`Bvh::crossings_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn crossings_batch(&self, mode: &Exact, rays: &[RayOf<S>], crossings: &mut [Crossings]) {
        crossings.fill(Crossings::default());
        self.answer(mode, rays, Answers::Crossings(crossings));
    }
}
