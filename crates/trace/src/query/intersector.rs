//! A ray a call, by an object that is made once: what a plain call chooses each time is chosen.
//!
//! ```text
//!   bvh.closest(&mode, ray)    the mode's test ─ the thread's stack ─ walk
//!   bvh.intersector(&mode)     the mode's test ─ a stack of its own
//!       .closest(ray)                                               walk
//! ```

use intertri::internal::Which;
use intertri::{Hit, Ray, RayOf};

use super::{Only, one};
use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::select::{Choice, Select};
use crate::single::Kept;
use crate::tree::Tree;

/// A hierarchy and a mode, ready for one ray after another: what [`Bvh::intersector`] gives.
///
/// Its answers are those of [`Bvh::closest`], [`Bvh::any`] and [`Bvh::triangles_batch`], bit for bit, and no
/// answer depends on what was asked before. It is for who has one ray at a time, one for each thread: it keeps
/// the stack of the walk, some kilobytes, and where the last rays went on to.
///
/// ```
/// use intertri_trace::Bvh;
/// use intertri_trace::intertri::{Exact, Ray, Triangle};
/// // A particle between two walls, that turns round at each.
/// let wall = |x| Triangle::new([x, -9.0, -9.0], [x, 9.0, -9.0], [x, 0.0, 9.0]);
/// let bvh = Bvh::new(&[wall(-1.0), wall(3.0)])?;
/// let mut intersector = bvh.intersector(&Exact::default());
/// let (mut ray, mut path) = (Ray::new([0.0; 3], [1.0, 0.0, 0.0]), 0.0);
/// for _ in 0..3 {
///     let hit = intersector.closest(&ray).expect("it is between them");
///     path += hit.t;
///     ray = Ray::new([ray.origin[0] + ray.dir[0] * hit.t as f32, 0.0, 0.0], ray.dir.map(|d| -d));
///     ray.t_min = 0.5;
/// }
/// assert_eq!(path, 3.0 + 4.0 + 4.0);
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Debug)]
pub struct Intersector<'a, S: Given = f32> {
    bvh: &'a Bvh<S>,
    choice: Choice<'a>,
    which: Which<'static>,
    kept: Box<Kept>,
}

impl<S: Given> Bvh<S> {
    /// The queries of a mode about one ray after another, faster than [`Bvh::closest`] and [`Bvh::any`]: what
    /// these choose at every call is chosen once.
    ///
    /// An example stands at [`Intersector`].
    pub fn intersector<M: ModeFor<S>>(&self, mode: &M) -> Intersector<'_, S> {
        let choice = Select::ALL.of(&self.tree);
        Intersector { bvh: self, choice, which: mode.which(), kept: Kept::new(&self.tree) }
    }
}

impl<'a, S: Given> Only<'a, S> {
    /// [`Bvh::intersector`] among the triangles that count. A list of what to skip is every ray's.
    ///
    /// # Panics
    /// If there are several lists of what rays skip.
    pub fn intersector<M: ModeFor<S>>(&self, mode: &M) -> Intersector<'a, S> {
        let (bvh, choice) = (self.bvh, self.one());
        Intersector { bvh, choice, which: mode.which(), kept: Kept::new(&bvh.tree) }
    }
}

impl<S: Given> Intersector<'_, S> {
    /// The closest hit; of equal t, the lowest index: as [`Bvh::closest`].
    pub fn closest(&mut self, ray: &RayOf<S>) -> Option<Hit> {
        self.ask(ray, one::closest)
    }

    /// The triangle of [`Intersector::closest`] alone: where nobody asks for t, it need not be computed in f64.
    /// Of several meshes it is a position in the whole ([`Bvh::geometry_of`]).
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::of_meshes(&[&[at(5.0)], &[at(3.0)]])?;
    /// let mut intersector = bvh.intersector(&Exact::default());
    /// let position = intersector.triangle(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// assert_eq!(position.map(|position| bvh.geometry_of(position)), Some((1, 0)));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn triangle(&mut self, ray: &RayOf<S>) -> Option<u32> {
        self.ask(ray, one::triangle)
    }

    /// Whether anything is hit: as [`Bvh::any`].
    pub fn any(&mut self, ray: &RayOf<S>) -> bool {
        self.ask(ray, one::any)
    }

    /// Asks about a ray as the walk goes over it.
    #[inline(always)]
    fn ask<A>(
        &mut self,
        ray: &RayOf<S>,
        ask: impl FnOnce(&Tree, &Choice<'_>, &Which<'_>, &Ray, &mut Kept) -> A,
    ) -> A {
        let Self { bvh, choice, which, kept } = self;
        S::walk_one(&bvh.tree, &bvh.originals, which, ray, |which, ray| {
            ask(&bvh.tree, choice, which, ray, kept)
        })
    }
}
