//! The mode `certified`: f32 lanes decide what a proven bound lets them decide; the rare lane that
//! it leaves undecided is replayed by the document's f64 operations.
//!
//! ```text
//!   rays, triangles ──► filter (f32, 8 lanes) ──► surely a miss   nearly all, by their edges
//!                                            ├──► surely a hit    t lies in an f32 interval; its f64
//!                                            │                    bits only where somebody needs them
//!                                            └──► undecided       about 1 in 10,000: replay in f64
//! ```

mod beam;
mod bound;
mod evidence;
mod filter;
mod look;
mod screen;
mod view;

use crate::lanes::{Lanes, Level, Mask, Simd};
use crate::mode::{Counts, Found, Lane, Test, Threshold, Which, Width};
use crate::verbs;
use crate::{Bests, PreparedPacket, Ray, RayPacket, Triangle, TrianglePack};

pub use evidence::Evidence;
pub use screen::{
    Frame, Judge, Nearest, Outline, Outlines, Points, Ranges, Replay, Starts, Windows,
};
pub use view::{View, Views};

use beam::Beam;
use filter::{Edges, Rays, Triangles, Verdict};
use look::{Constants, Look};

/// f32 lanes under a proven bound, f64 where it does not decide: the answers of the scalar f64
/// reference, bit for bit, at the speed of f32.
///
/// ```
/// use intertri::{Certified, Mode, Ray, Triangle};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let hit = Certified::default().closest(&[triangle], &ray);
/// assert_eq!((hit.triangle, hit.t), (0, 5.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Certified {
    threshold: Threshold,
    level: Level,
}

impl Default for Certified {
    fn default() -> Self {
        Self::new(Threshold::DEFAULT)
    }
}

impl Certified {
    /// The mode with a threshold of one's own, at this CPU's best level.
    ///
    /// ```
    /// use intertri::{Certified, Mode, Ray, Threshold, Triangle};
    /// // In a scene of size 1e-7 the default of 1e-9 is a distance.
    /// let small = Triangle::new([0.0, 0.0, 5e-10], [1e-7, 0.0, 5e-10], [0.0, 1e-7, 5e-10]);
    /// let ray = Ray::new([2e-8, 2e-8, 0.0], [0.0, 0.0, 1.0]);
    /// assert!(!Certified::default().any(&[small], &ray));
    /// assert!(Certified::new(Threshold::new(1e-30).unwrap()).any(&[small], &ray));
    /// ```
    pub fn new(threshold: Threshold) -> Self {
        Self { threshold, level: Level::best() }
    }

    /// The same mode at another level. The answers do not depend on it.
    ///
    /// ```
    /// use intertri::{Certified, lanes::Level};
    /// let plain = Certified::default().at(Level::SCALAR);
    /// ```
    pub fn at(self, level: Level) -> Self {
        Self { level, ..self }
    }
}

impl Test for Certified {
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Rays<F>;
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Triangles<F>;
    type Constants = Constants;
    type Look<F: Lanes<Scalar = f32>> = Look<F>;
    type Ray = Rays<f32>;

    #[inline(always)]
    fn level(&self) -> Level {
        self.level
    }

    #[inline(always)]
    fn which(&self) -> Which<'_> {
        Which::Certified(self)
    }

    #[inline(always)]
    fn threshold(&self) -> Threshold {
        self.threshold
    }

    #[inline(always)]
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> Rays<F> {
        Rays::of_packet(packet, self.threshold)
    }

    #[inline(always)]
    fn ray(&self, ray: &Ray) -> Rays<f32> {
        Rays::of_ray(ray, self.threshold)
    }

    #[inline(always)]
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(&self, ray: &Rays<f32>) -> Rays<F> {
        Rays::splat(ray)
    }

    #[inline(always)]
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        pack: &TrianglePack<N>,
    ) -> Triangles<F> {
        Triangles::of_pack(pack)
    }

    #[inline(always)]
    fn constants(&self, triangle: &Triangle) -> Constants {
        Constants::new(triangle)
    }

    #[inline(always)]
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangle: &Triangle,
        constants: &Constants,
    ) -> Triangles<F> {
        Triangles::splat(triangle, constants)
    }

    #[inline(always)]
    fn look<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(&self, rays: &Rays<F>) -> Look<F> {
        Look::new(rays)
    }

    #[inline(always)]
    fn maybe<F: Lanes<Scalar = f32>>(
        &self,
        triangle: &Constants,
        look: &Look<F>,
        live: F::Mask,
    ) -> bool {
        (!look.sure_miss(triangle) & live).any()
    }

    #[inline(always)]
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Triangles<F>,
        rays: &Rays<F>,
        far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Option<Found<F, D>> {
        counts.tests += u64::from(live.count_ones());
        let edges = Edges::new(triangles, rays);
        let verdict = edges.decide(triangles, rays, far, live, self.threshold);
        Some(found(&verdict, counts))
    }
}

impl Certified {
    /// A triangle as it is seen from the origin that rays share (document D): computed once, it makes
    /// each ray's test three dot products.
    ///
    /// ```
    /// use intertri::{Certified, Triangle, View};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let seen: View = Certified::default().view(&wall, [0.25, 0.25, 0.0]);
    /// ```
    pub fn view(&self, triangle: &Triangle, origin: [f32; 3]) -> View {
        let one = TrianglePack::<1>::new(core::slice::from_ref(triangle));
        let [view] = View::all::<f64, 1>(&one, origin, self.threshold.get());
        view
    }

    /// [`Certified::view`] of eight triangles, within a loop at some level.
    ///
    /// An example stands at [`View`].
    #[inline(always)]
    pub fn views_in<S: Simd>(&self, pack: &TrianglePack<8>, origin: [f32; 3]) -> Views {
        Views::new::<S::F64x8>(pack, origin, self.threshold.get())
    }

    /// [`Mode::packet_closest_in`](crate::Mode::packet_closest_in) for rays that all start at the
    /// origin of the view.
    ///
    /// An example stands at [`View`].
    #[inline(always)]
    pub fn view_closest_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        view: &View,
        (index, place): (u32, u32),
        find: impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<<Lane<N> as Width>::F<S>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        counts.tests += u64::from(live.count_ones());
        if view.never {
            return;
        }
        let forms = view::Forms::new(view, rays.lanes());
        if forms.maybe(view).bits() & live == 0 {
            return;
        }
        if let Some(verdict) = forms.decide(view, rays.lanes(), bests.t_hi(), live) {
            let found = found::<_, <Lane<N> as Width>::D<S>>(&verdict, counts);
            let (packet, triangle) = (rays.packet(), &view.triangle);
            let scalar = verbs::Rays { packet, triangle, find, threshold: self.threshold };
            bests.offer(&found, index, place, &scalar);
        }
    }

    /// The triangles of one pack or two as the screen of a frame sees them, for rays none of which has a
    /// smaller z than `slowest`; within a loop at some level. Those of the second begin at lane 8.
    ///
    /// An example stands at [`Outlines`].
    #[inline(always)]
    pub fn outlines_in<S: Simd>(
        &self,
        first: &TrianglePack<8>,
        second: Option<&TrianglePack<8>>,
        frame: &Frame,
        slowest: f32,
    ) -> Outlines {
        // What f32 rounds here is far less than PARALLEL has to spare.
        let least = if self.threshold.get() > 0.0 { self.threshold.above } else { 0.0 };
        let parallel = bound::PARALLEL * least / slowest;
        Outlines::new::<S>(first, second, frame, parallel)
    }

    /// Where the rays so far and the live ones of a packet begin to look for hits.
    ///
    /// An example stands at [`Starts`].
    #[inline(always)]
    pub fn starts_in<F: Lanes<Scalar = f32>>(
        &self,
        starts: &Starts<F>,
        points: &Points<F>,
        t_min: F,
        live: F::Mask,
    ) -> Starts<F> {
        starts.and(points, t_min, live, self.threshold)
    }

    /// [`Certified::view_closest_in`] for eight views after another; index and place of the i-th triangle
    /// are `first + i`, every pack but the last full. The packet is held against eight views at once
    /// before its rays are: what it cannot reach at all costs little if its rays are alike.
    ///
    /// An example stands at [`View`].
    #[inline(always)]
    pub fn views_closest_in<S: Simd, const N: usize>(
        &self,
        rays: &PreparedPacket<'_, Self, S, N>,
        views: &[Views],
        first: u32,
        find: impl Fn(u32) -> Triangle,
        live: u32,
        bests: &mut Bests<<Lane<N> as Width>::F<S>, N>,
        counts: &mut Counts,
    ) where
        Lane<N>: Width,
    {
        let beam = Beam::of::<_, N>(rays.lanes());
        // A copy of its own stays in registers; all tests are counted at once.
        let (mut own, mut few) = (*bests, Counts::default());
        for (block, first) in views.chunks(8).zip((first..).step_by(64)) {
            // Those that the beam may reach, gathered without a branch.
            let mut list = 0_u64;
            for (k, eight) in block.iter().enumerate() {
                list |= u64::from(beam.maybe::<S::F32x8>(eight)) << (8 * k);
                counts.tests += u64::from(live.count_ones() * eight.live.count_ones());
            }
            while list != 0 {
                let i = list.trailing_zeros() as usize;
                list &= list - 1;
                let (view, index) = (&block[i / 8].each[i % 8], first + i as u32);
                self.view_closest_in(rays, view, (index, index), &find, live, &mut own, &mut few);
            }
        }
        counts.undecided += few.undecided;
        *bests = own;
    }
}

/// What a verdict comes to: a sure hit keeps its enclosure of t, for who needs the bits asks for
/// them; an undecided lane goes through the document's test.
#[inline(always)]
fn found<F: Copy, D: Lanes<Scalar = f64>>(
    verdict: &Verdict<F>,
    counts: &mut Counts,
) -> Found<F, D> {
    let Verdict { hit, undecided, t_lo, t_hi } = *verdict;
    counts.undecided += u64::from(undecided.count_ones());
    Found { near: hit, exact: 0, undecided, t_lo, t_hi, t: D::splat(0.0) }
}
