//! What users ask of a hierarchy: of one ray, or of many.

mod batch;
mod closest_point;
mod crossings;
#[cfg(feature = "fixed")]
mod fixed;
mod intersector;
mod lists;
mod one;
mod only;
mod places;
mod visible;

#[cfg(feature = "fixed")]
pub use fixed::FixedBvh;
pub use intersector::Intersector;
pub use lists::HitLists;
pub use only::Only;

use intertri::internal::Which;
use intertri::{Counts, Hit, Ray, RayOf};

use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::memory::OutOfMemory;
use crate::select::Select;
use crate::single::Kept;
use crate::tree::Tree;

impl<S: Given> Bvh<S> {
    /// The closest hit; of equal t, the lowest index.
    pub fn closest<M: ModeFor<S>>(&self, mode: &M, ray: &RayOf<S>) -> Option<Hit> {
        // Not by `only`, whose frame takes a twentieth of a ray's time.
        self.ask_one(mode, ray, |tree, which, ray| {
            one::closest(tree, &Select::ALL.of(tree), which, ray, &mut Kept::lend(tree))
        })
    }

    /// Whether anything is hit.
    pub fn any<M: ModeFor<S>>(&self, mode: &M, ray: &RayOf<S>) -> bool {
        self.ask_one(mode, ray, |tree, which, ray| {
            one::any(tree, &Select::ALL.of(tree), which, ray, &mut Kept::lend(tree))
        })
    }

    /// Every hit, in order of t; of equal t, of the index.
    pub fn all<M: ModeFor<S>>(&self, mode: &M, ray: &RayOf<S>) -> Vec<Hit> {
        self.only(&Select::ALL).all(mode, ray)
    }

    /// [`Bvh::closest`] of many rays: `hits[i]` becomes the answer of `rays[i]`, [`Hit::MISS`] where there is
    /// none.
    ///
    /// Rays that are neighbours in the slice are best neighbours in space, too. Fastest are rays that
    /// share their origin, 1024 of them in a row in a narrow cone, such as 32 by 32 pixels in Z-order;
    /// whether that is so is found out here, and no answer depends on it.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        hits: &mut [Hit],
    ) -> Counts {
        self.only(&Select::ALL).closest_batch(mode, rays, hits)
    }

    /// The triangles of [`Bvh::closest_batch`] alone, [`Hit::NO_TRIANGLE`] for a miss: where nobody asks for
    /// t, it need not be computed in f64. Of several meshes these are positions in the whole
    /// ([`Bvh::geometry_of`]).
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn triangles_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        triangles: &mut [u32],
    ) -> Counts {
        self.only(&Select::ALL).triangles_batch(mode, rays, triangles)
    }

    /// [`Bvh::any`] of many rays: `any[i]` becomes the answer of `rays[i]`.
    ///
    /// Fastest where neighbours share their origin, or end at one point but for rounding, at t = 1 or at
    /// `t_max`, and do not look beyond it. For shadows ask [`Bvh::visible_batch`]: a ray that starts on a surface
    /// may hit it, because the point is rounded.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        any: &mut [bool],
    ) -> Counts {
        self.only(&Select::ALL).any_batch(mode, rays, any)
    }

    /// [`Bvh::all`] of many rays, in compact arrays; of each ray the first `limit` hits, if there is a limit.
    ///
    /// Rays are best ordered as for [`Bvh::closest_batch`]. With a limit a ray looks no farther than the last
    /// of so many hits.
    ///
    /// # Errors
    /// If there is too little memory for what is found.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::new(&[at(5.0), at(7.0), at(3.0)])?;
    /// let rays = [0.2, 9.0, 0.3].map(|x| Ray::new([x, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// let lists = bvh.all_batch(&Exact::default(), &rays, Some(2))?;
    /// assert_eq!(lists.offsets, [0, 2, 2, 4]);
    /// assert!(lists.of(2).iter().map(|hit| hit.triangle).eq([2, 0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn all_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        limit: Option<usize>,
    ) -> Result<HitLists, OutOfMemory> {
        self.only(&Select::ALL).all_batch(mode, rays, limit)
    }

    /// The same queries among some of the triangles: by a mask of geometries, by the side from which they are
    /// met, and without what rays skip.
    ///
    /// The answers are those of a plain loop over the triangles that count. Bundles know nothing of the choice:
    /// rays of one origin are then traced as streams. Where every triangle counts, it costs nothing.
    ///
    /// An example stands at [`Select`].
    pub fn only<'a>(&'a self, select: &'a Select<'a>) -> Only<'a, S> {
        Only::new(self, select)
    }

    /// Asks about one ray.
    #[inline]
    pub(crate) fn ask_one<M: ModeFor<S>, A>(
        &self,
        mode: &M,
        ray: &RayOf<S>,
        ask: impl FnOnce(&Tree, &Which<'_>, &Ray) -> A,
    ) -> A {
        let (tree, which) = (&self.tree, mode.which());
        S::walk_one(tree, &self.originals, &which, ray, |which, ray| ask(tree, which, ray))
    }
}
