//! Where rays cross a mesh, each edge and corner once: by the mode `exact`.

use intertri::internal::Resolver;
use intertri::internal::exact::{self, Side};
use intertri::{Counts, Crossing, Crossings, Exact, Mode, Ray};

use super::{batch, one};
use crate::tree::Bvh;

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
        let resolver = Resolver::Exact;
        let mut all: Vec<_> = self
            .crossed(*mode, ray)
            .map(|(place, side)| {
                let triangle = self.triangle_in(place);
                let hit = resolver.hit_attributes(ray, &triangle, self.index_of(place));
                (Crossing { hit, leaves: side == Side::Leaves }, triangle)
            })
            .collect();
        all.sort_unstable_by(|(a, at), (b, bt)| resolver.first(ray, (&a.hit, at), (&b.hit, bt)));
        all.into_iter().map(|(crossing, _)| crossing).collect()
    }

    /// How often each of many rays crosses the triangles: `crossings[i]` becomes the count of `rays[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn crossings_batch(&self, mode: &Exact, rays: &[Ray], crossings: &mut [Crossings]) {
        batch::chunks(rays, crossings, |rays, crossings| {
            for (ray, to) in rays.iter().zip(crossings) {
                *to = self.count(*mode, ray);
            }
            Counts::default()
        });
    }

    /// How often a ray crosses the triangles.
    pub(crate) fn count(&self, mode: Exact, ray: &Ray) -> Crossings {
        let mut count = Crossings::default();
        self.crossed(mode, ray).for_each(|(_, side)| count.add(side == Side::Leaves));
        count
    }

    /// The places of the triangles that a ray crosses, and from which side. Each is hit, too.
    fn crossed(&self, mode: Exact, ray: &Ray) -> impl Iterator<Item = (u32, Side)> {
        let places = one::places(self, mode.test().into(), ray);
        places.into_iter().filter_map(|place| {
            exact::crossing(ray, &self.triangle_in(place)).map(|side| (place, side))
        })
    }
}
