//! What a mode is: a way to decide which lanes are hits, and at which t.

use core::fmt;

use crate::lanes::{Lanes, Level, Simd};
use crate::{Certified, Double, Ray, RayPacket, Triangle, TrianglePack};

/// The document's `Threshold`: the smallest `|nrm & dir|` that is not parallel, and the largest t
/// that is still no hit.
///
/// ```
/// use intertri::{Certified, Mode, Ray, Threshold, Triangle};
/// let near = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// assert!(Certified::new(Threshold::DEFAULT).any(&[near], &ray));
/// assert!(!Certified::new(Threshold::new(5.0).unwrap()).any(&[near], &ray));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    exact: f64,
    /// Rounded to f32, and the f32 below and above that.
    pub(crate) near: f32,
    pub(crate) below: f32,
    pub(crate) above: f32,
}

impl Threshold {
    /// The default: far above the rounding of f64 in a scene of unit size, far below its features.
    ///
    /// ```
    /// assert_eq!(intertri::Threshold::DEFAULT.get(), 1e-9);
    /// ```
    pub const DEFAULT: Self = Self::of(1e-9);

    /// None: parallel is what is so exactly.
    ///
    /// ```
    /// use intertri::{Certified, Threshold};
    /// assert_eq!(Threshold::ZERO, Threshold::new(0.0).unwrap());
    /// let mode = Certified::new(Threshold::ZERO);
    /// ```
    pub const ZERO: Self = Self::of(0.0);

    /// A threshold of one's own.
    ///
    /// # Errors
    /// If it is negative, infinite or NaN.
    ///
    /// ```
    /// use intertri::Threshold;
    /// assert_eq!(Threshold::new(0.0).unwrap().get(), 0.0);
    /// assert!(Threshold::new(-1.0).is_err());
    /// ```
    pub fn new(threshold: f64) -> Result<Self, BadThreshold> {
        if threshold >= 0.0 && threshold.is_finite() {
            Ok(Self::of(threshold))
        } else {
            Err(BadThreshold(threshold))
        }
    }

    const fn of(exact: f64) -> Self {
        let near = exact as f32;
        Self { exact, near, below: near.next_down(), above: near.next_up() }
    }

    /// The number.
    ///
    /// ```
    /// assert_eq!(intertri::Threshold::new(1e-6).unwrap().get(), 1e-6);
    /// ```
    #[inline(always)]
    pub fn get(self) -> f64 {
        self.exact
    }
}

impl Default for Threshold {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A threshold that is negative, infinite or NaN.
///
/// ```
/// let refused = intertri::Threshold::new(f64::NAN).unwrap_err();
/// assert!(refused.to_string().contains("finite"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BadThreshold(pub f64);

impl fmt::Display for BadThreshold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a threshold of {}: it must be finite and not negative", self.0)
    }
}

impl core::error::Error for BadThreshold {}

/// Which of the modes a [`Mode`](crate::Mode) is, so that what is generic over modes may treat one apart, or be
/// compiled for both in one place.
///
/// ```
/// use intertri::{Certified, Double, Mode, Which};
/// fn name<M: Mode>(mode: &M) -> &'static str {
///     match mode.which() {
///         Which::Certified(_) => "certified",
///         Which::Double(_) => "double",
///     }
/// }
/// assert_eq!((name(&Certified::default()), name(&Double::default())), ("certified", "double"));
/// ```
#[derive(Clone, Copy, Debug)]
pub enum Which<'a> {
    /// f32 lanes that answer as f64 would.
    Certified(&'a Certified),
    /// f64 lanes.
    Double(&'a Double),
}

/// How many lanes a packet may have: the marker `Lane<N>` of a width that there is.
///
/// ```
/// use intertri::lanes::Lanes;
/// use intertri::{Lane, Mode, Prepared, RayPacket, Width};
/// // Generic over the number of lanes.
/// fn hits<M: Mode, const N: usize>(mode: &M, rays: &RayPacket<N>, triangle: &Prepared<M>) -> u32
/// where
///     Lane<N>: Width,
/// {
///     mode.packet(rays, triangle).bits
/// }
/// ```
pub trait Width {
    /// So many f32.
    type F<S: Simd>: Lanes<Scalar = f32>;
    /// So many f64.
    type D<S: Simd>: Lanes<Scalar = f64>;
}

/// A width of N lanes.
///
/// ```
/// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
/// use intertri::{Lane, Width};
/// struct Count;
/// impl WithSimd for Count {
///     type Output = (usize, usize);
///     fn run<S: Simd>(self) -> (usize, usize) {
///         (<Lane<16> as Width>::F::<S>::N, <Lane<4> as Width>::D::<S>::N)
///     }
/// }
/// assert_eq!(dispatch(Count), (16, 4));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Lane<const N: usize>;

impl Width for Lane<4> {
    type F<S: Simd> = S::F32x4;
    type D<S: Simd> = S::F64x4;
}
impl Width for Lane<8> {
    type F<S: Simd> = S::F32x8;
    type D<S: Simd> = S::F64x8;
}
impl Width for Lane<16> {
    type F<S: Simd> = S::F32x16;
    type D<S: Simd> = crate::lanes::Pair<S::F64x8>;
}

/// How many tests were made, and how many of them the f32 bound left undecided.
///
/// ```
/// let mut all = intertri::Counts { tests: 64, undecided: 1 };
/// all += intertri::Counts { tests: 36, undecided: 0 };
/// assert_eq!((all.tests, all.undecided), (100, 1));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Ray/triangle tests, dead lanes not counted.
    pub tests: u64,
    /// Tests that were replayed in f64.
    pub undecided: u64,
}

impl core::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.tests += more.tests;
        self.undecided += more.undecided;
    }
}

/// The lanes that a test found to be hits, or may be, but for the far end of their interval.
pub struct Found<F, D> {
    /// Hits of which an enclosure of t is known.
    pub(crate) near: u32,
    /// Hits of which t is known.
    pub(crate) exact: u32,
    /// Lanes that the scalar test of f64 has to decide.
    pub(crate) undecided: u32,
    pub(crate) t_lo: F,
    pub(crate) t_hi: F,
    pub(crate) t: D,
}

impl<F, D> Found<F, D> {
    /// All lanes that may be hits.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> u32 {
        self.near | self.exact | self.undecided
    }
}

/// What is asked of a lane when its turn comes, in f64 and out of line.
pub(crate) trait Scalar {
    /// The exact t, if the lane is a hit.
    fn replay(&self, lane: usize) -> Option<f64>;
    /// The exact t of the lane's ray with the triangle in a place, which it is known to hit.
    fn exact_t(&self, lane: usize, place: u32) -> f64;
}

/// The one test of a mode, generic over its width: rays against triangles, either of them the same
/// in all lanes. All else that a mode can do is made of it, in [`Mode`](crate::Mode).
///
/// `F` and `D` are as many f32 as f64 lanes; a mode uses what it needs of them.
pub trait Test: Copy + Send + Sync {
    /// Rays as lanes.
    type Rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>: Copy;
    /// Triangles as lanes.
    type Triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>: Copy;
    /// What is computed from a triangle once.
    type Constants: Copy;
    /// What a first look at one triangle asks of rays.
    type Look<F: Lanes<Scalar = f32>>: Copy;
    /// One ray with what is computed from it once.
    type Ray: Copy;

    /// The level of instructions to run on.
    fn level(&self) -> Level;

    /// Which mode it is.
    fn which(&self) -> Which<'_>;

    /// The threshold of the document's test.
    fn threshold(&self) -> Threshold;

    /// N rays.
    fn rays<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        packet: &RayPacket<N>,
    ) -> Self::Rays<F, D>;

    /// What is computed from a ray once.
    fn ray(&self, ray: &Ray) -> Self::Ray;

    /// The same ray in all lanes.
    fn one_ray<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        ray: &Self::Ray,
    ) -> Self::Rays<F, D>;

    /// N triangles.
    fn triangles<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>, const N: usize>(
        &self,
        pack: &TrianglePack<N>,
    ) -> Self::Triangles<F, D>;

    /// What is computed from a triangle once.
    fn constants(&self, triangle: &Triangle) -> Self::Constants;

    /// The same triangle in all lanes.
    fn one_triangle<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangle: &Triangle,
        constants: &Self::Constants,
    ) -> Self::Triangles<F, D>;

    /// What a first look asks of rays.
    fn look<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        rays: &Self::Rays<F, D>,
    ) -> Self::Look<F>;

    /// Whether any of the `live` lanes may be a hit with one triangle: a first look without a branch,
    /// after which [`Test::test`] is asked.
    fn maybe<F: Lanes<Scalar = f32>>(
        &self,
        triangle: &Self::Constants,
        look: &Self::Look<F>,
        live: F::Mask,
    ) -> bool;

    /// Which of the `live` lanes are hits with `t_min <= t` and, surely or perhaps, `t <= far`.
    /// `None` where none is.
    fn test<F: Lanes<Scalar = f32>, D: Lanes<Scalar = f64>>(
        &self,
        triangles: &Self::Triangles<F, D>,
        rays: &Self::Rays<F, D>,
        far: F,
        live: u32,
        counts: &mut Counts,
    ) -> Option<Found<F, D>>;
}

/// Bits of a mask, from the lowest.
#[inline(always)]
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
