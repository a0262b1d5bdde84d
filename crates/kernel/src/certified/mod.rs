//! The mode `certified`: f32 lanes decide what a proven bound lets them decide; the rare lane that
//! it leaves undecided is replayed by the document's f64 operations.
//!
//! ```text
//!   rays, triangles ──► filter (f32, 8 lanes) ──► surely a miss   nearly all, by their edges
//!                                            ├──► surely a hit    t lies in an f32 interval; its f64
//!                                            │                    bits only where somebody needs them
//!                                            └──► undecided       about 1 in 10,000: replay in f64
//! ```

mod bound;
mod evidence;
mod filter;
mod view;

use crate::double::{exact_t, replay};
use crate::lanes::{Lanes, Level, Simd};
use crate::mode::{Counts, Found, Lane, Test, Threshold, Width, lanes_of};
use crate::{Bests, PreparedPacket, Ray, RayPacket, Triangle, TrianglePack, Vec3};

pub use evidence::Evidence;
pub use filter::Pencil;
pub use view::{Beams, View, Views};

use filter::{Edges, Rays, Triangles, Verdict};

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
    pub fn new(threshold: Threshold) -> Self {
        Self { threshold, level: Level::best() }
    }

    /// The same mode at another level. The answers do not depend on it.
    pub fn at(self, level: Level) -> Self {
        Self { level, ..self }
    }
}

impl Test for Certified {
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Rays<F>;
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>> = Triangles<F>;
    type Constants = Triangles<f32>;

    #[inline(always)]
    fn level(&self) -> Level {
        self.level
    }

    #[inline(always)]
    fn certified(&self) -> Option<&Self> {
        Some(self)
    }

    #[inline(always)]
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> Rays<F> {
        Rays::of_packet(packet, self.threshold.get())
    }

    #[inline(always)]
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(&self, ray: &Ray) -> Rays<F> {
        Rays::of_ray(ray, self.threshold.get())
    }

    #[inline(always)]
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        pack: &TrianglePack<N>,
    ) -> Triangles<F> {
        Triangles::of_pack(pack)
    }

    #[inline(always)]
    fn constants(&self, triangle: &Triangle) -> Triangles<f32> {
        Triangles::one(triangle)
    }

    #[inline(always)]
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangle: &Triangles<f32>,
    ) -> Triangles<F> {
        Triangles::splat(triangle)
    }

    #[inline(always)]
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Triangles<F>,
        rays: &Rays<F>,
        far: F,
        live: u32,
        counts: &mut Counts,
        scalar: impl Fn(usize) -> (Ray, Triangle),
    ) -> Option<Found<F>> {
        counts.tests += u64::from(live.count_ones());
        let edges = Edges::new(triangles, rays);
        if edges.all_miss(live) {
            return None;
        }
        let verdict = edges.decide(triangles, rays, far, live, self.threshold.get());
        Some(self.replay(&verdict, counts, scalar))
    }
}

impl Certified {
    /// A triangle as it is seen from the origin that rays share (document D): computed once, it makes
    /// each ray's test three dot products.
    pub fn view(&self, triangle: &Triangle, origin: [f32; 3]) -> View {
        let pack = TrianglePack::<1>::new(core::slice::from_ref(triangle));
        Views::new::<f64>(pack.corners(), origin, self.threshold.get(), 1).lane(0)
    }

    /// [`Certified::view`] of a pack of triangles, within a loop at some level.
    #[inline(always)]
    pub fn views_in<S: Simd>(&self, pack: &TrianglePack<8>, origin: [f32; 3]) -> Views<8> {
        Views::new::<S::F64x8>(pack.corners(), origin, self.threshold.get(), pack.live())
    }

    /// [`Mode::packet_closest_in`](crate::Mode::packet_closest_in) for rays that all start at the
    /// origin of the view.
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
        let ray = |lane| rays.packet().ray(lane);
        let pencil = &rays.lanes().pencil;
        self.pencil_closest_in::<S, N>(
            pencil,
            view,
            (index, place),
            ray,
            find,
            live,
            bests,
            counts,
        );
    }

    /// N rays that share an origin, as lanes: `dir[axis][lane]`. No coordinate of the origin may
    /// exceed 2^30.
    #[inline(always)]
    pub fn pencil_in<S: Simd, const N: usize>(
        &self,
        dir: &[[f32; N]; 3],
        t_min: &[f32; N],
    ) -> Pencil<<Lane<N> as Width>::F<S>>
    where
        Lane<N>: Width,
    {
        Pencil::new(Vec3::load(dir), Lanes::load(t_min), self.threshold.get())
    }

    /// [`Certified::view_closest_in`] of a pencil, `ray` being the ray in a lane.
    #[inline(always)]
    pub fn pencil_closest_in<S: Simd, const N: usize>(
        &self,
        pencil: &Pencil<<Lane<N> as Width>::F<S>>,
        view: &View,
        (index, place): (u32, u32),
        ray: impl Fn(usize) -> Ray,
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
        let forms = view::Forms::new(view, pencil);
        if forms.all_miss(view, live) {
            return;
        }
        if let Some(verdict) = forms.decide(view, pencil, bests.t_hi(), live) {
            let found = self.replay(&verdict, counts, |lane| (ray(lane), find(place)));
            bests.offer(&found, index, place, |lane, place| exact_t(&ray(lane), &find(place)));
        }
    }

    /// What a verdict comes to: a sure hit keeps its enclosure of t, for who needs the bits asks for
    /// them; an undecided lane goes through the document's test.
    #[inline(always)]
    fn replay<F>(
        &self,
        verdict: &Verdict<F>,
        counts: &mut Counts,
        scalar: impl Fn(usize) -> (Ray, Triangle),
    ) -> Found<F>
    where
        F: Lanes<Scalar = f32>,
    {
        let Verdict { hit, undecided, t_lo, t_hi } = *verdict;
        let mut found = Found { near: hit, exact: 0, t_lo, t_hi, t: [0.0; 16] };
        counts.undecided += u64::from(undecided.count_ones());
        for lane in lanes_of(undecided) {
            let (ray, triangle) = scalar(lane);
            if let Some(t) = replay(&ray, &triangle, self.threshold.get()) {
                found.exact |= 1 << lane;
                found.t[lane] = t;
            }
        }
        found
    }
}
