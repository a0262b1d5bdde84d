//! The constants of the filter's bounds. Each is derived in `docs/numerics/certified.md`.
//!
//! `u` is half an ulp of 1 in f32; |.|₁ and |.|₂ are the usual norms; h is the longest edge.

/// Half an ulp of 1 in f32.
pub(super) const U: f32 = 1.0 / (1 << 24) as f32;

/// In the precheck V, W, U and the denominator, all over h, are within `PRECHECK |d|₂ (|c1|₁ + h + |o|₁)`.
pub(super) const PRECHECK: f32 = 32.0 * U;

/// V and W are within `EDGE |d|₂ h (|A|₁ + NEAR h)` of the exact value, and the reference's own noise with
/// them.
pub(super) const EDGE: f32 = 6.5 * U;

/// The share of the edges' own length in the bound. U is within twice the bound of V and W.
pub(super) const NEAR: f32 = 0.65;

/// V is within `SHARP perm(h5, d, A)` of the exact value, and W likewise, but for the noise.
pub(super) const SHARP: f32 = 6.25 * U;

/// U is within `SHARP_U` times the sum of all three permanents, but for the noise.
pub(super) const SHARP_U: f32 = 8.25 * U;

/// The denominator is within `DEN |d|₂ h²`.
pub(super) const DEN: f32 = 8.5 * U;

/// The numerator is within `NUM |A|₁ h²`.
pub(super) const NUM: f32 = 8.5 * U;

/// The same of the last try: `SHARP_NUM perm(h4, h5, A)`, and the reference's noise (2^-49) relative to
/// `|A|₁ h²`.
pub(super) const SHARP_NUM: f32 = 8.25 * U;
/// See [`SHARP_NUM`].
pub(super) const NUM_NOISE: f32 = f32::from_bits((127 - 49) << 23);

/// Nothing is decided where the denominator is below `GRAZING |d|₂ h²`: there the reference's own
/// rounding is magnified too much.
pub(super) const GRAZING: f32 = 24.0 * U;

/// The enclosure of t: `SLACK (NUM |A|₁ h² + |t| DEN |d|₂ h²) / |den| + ROUND |t|`.
pub(super) const SLACK: f32 = 1.6;
/// See [`SLACK`].
pub(super) const ROUND: f32 = 8.0 * U;

/// A denominator beyond this multiple of `Threshold |n|` is not parallel.
pub(super) const PARALLEL: f32 = 1.001;

/// |n|₂ is at most `AREA h²`: no triangle has more area for its longest edge than an equilateral one.
pub(super) const AREA: f32 = 0.8661;

/// The rounding of the hit point, relative to the origin's |.|₁: 2^-51.
pub(super) const ORIGIN: f32 = f32::from_bits((127 - 51) << 23);

/// No coordinate and no direction is larger (2^40), or the filter does not decide. Then no product
/// overflows.
pub(super) const LARGEST: f32 = (1_u64 << 40) as f32;
/// No direction is shorter (2^-40), or the filter does not decide.
pub(super) const SHORTEST_DIR: f32 = 1.0 / LARGEST;

/// `GRAZING h²` counts as so much more (2^-80), which with a direction's length is more than underflow
/// takes from the denominator.
pub(super) const GRAZING_ADD: f32 = f32::from_bits((127 - 80) << 23);

/// The bound of an edge is at least `h` times this (2^-72): more than underflow takes.
pub(super) const OFF_ADD: f32 = f32::from_bits((127 - 72) << 23);

/// What underflow, flushed to zero or not, can take from a product or a sum.
pub(super) const TINY: f32 = f32::from_bits((127 - 120) << 23);
/// What it can take from an edge, a direction or a translated corner, as a length.
pub(super) const SMALL: f32 = f32::from_bits((127 - 100) << 23);

/// The square root of a sum of squares, rounded up, with this much added against underflow.
pub(super) const NORM_UP: f32 = 1.0 + 16.0 * U;
/// See [`NORM_UP`]: 2^-49.
pub(super) const NORM_ADD: f32 = f32::from_bits((127 - 49) << 23);

/// The reference's own noise, relative to `|d|₂ h (|A|₂ + h)`, and what f64 loses in a view.
pub(super) const NOISE: f32 = 0.25 * U;

/// On a projection no point is farther from the middle than this, in x or in y.
pub(super) const SCREEN_EDGE: f32 = 0.5;

/// No direction on the projection is longer than its depth times this.
pub(super) const LEAN: f32 = 1.23;

/// A linear form of a point of the projection, rounded to f32, is within `SCREEN |form|₁`.
pub(super) const SCREEN: f32 = 9.25 * U;

/// An edge in the projection's axes is within `EDGES h (|A|₁ + h)` as its coefficients go, the
/// reference's noise included.
pub(super) const EDGES: f32 = 16.75 * U;

/// The inverse depth is within `DEPTH |s|₁` and `LOST h² / |T|`.
pub(super) const DEPTH: f32 = 16.0 * U;
/// See [`DEPTH`]: 2^-45.
pub(super) const LOST: f32 = 1.0 / (1_u64 << 45) as f32;

/// The inverse of a t and a depth is within this share of itself.
pub(super) const INVERSE: f32 = 10.0 * U;

/// Around a triangle the reference may accept a point that lies `ROOM h + ROOM_AWAY |o|₁` over its
/// least depth outside, on the projection, and its corners are known within `CORNER |A|₁`; rounding adds
/// `ROOM_SCREEN`. 2^-19, 2^-46, 2^-20.
pub(super) const ROOM: f32 = 1.0 / (1_u64 << 19) as f32;
/// See [`ROOM`].
pub(super) const ROOM_AWAY: f32 = 1.0 / (1_u64 << 46) as f32;
/// See [`ROOM`].
pub(super) const CORNER: f32 = 11.0 * U;
/// See [`ROOM`].
pub(super) const ROOM_SCREEN: f32 = 16.0 * U;

/// Of a triangle for which `h² / |n|₁` is more than this (2^24) no rectangle is known.
pub(super) const THIN: f32 = (1_u64 << 24) as f32;

/// On a projection a t below this (2^-80) counts as unknown: its product with a depth could be subnormal, which
/// rounds by more than `INVERSE`.
pub(super) const SHORTEST_T: f32 = f32::from_bits((127 - 80) << 23);

/// Where rays pass the origin at a distance of up to `off`, the bound of an edge is `OFF_EDGE h off` more.
pub(super) const OFF_EDGE: f32 = 1.25;
/// The inverse depth is `OFF_DEPTH off |s|₁` more uncertain, relative to its largest value on the projection as
/// far as rays reach there and [`OFF_REACH`] farther: 2^-19.
pub(super) const OFF_DEPTH: f32 = 1.5;
/// See [`OFF_DEPTH`].
pub(super) const OFF_REACH: f32 = 1.0 / (1 << 19) as f32;
/// The room around a triangle is `OFF_ROOM off` more.
pub(super) const OFF_ROOM: f32 = 1.25;
/// T is known where `|s|₁ off` is this much less than 1.
pub(super) const OFF_PLANE: f32 = 4.0;

/// Of copies in f32 of what is given in f64 (`docs/numerics/f64.md`, section 4): a corner and an origin are each within
/// this of themselves, and so is each component of an edge and of a direction.
pub(super) const COPY: f32 = 1.02 * U;
/// [`EDGE`] of copies.
pub(super) const COPY_EDGE: f32 = 7.5 * U;
/// [`DEN`] of copies.
pub(super) const COPY_DEN: f32 = 9.5 * U;
/// [`GRAZING`] of copies.
pub(super) const COPY_GRAZING: f32 = 27.0 * U;
/// [`NUM`] of copies.
pub(super) const COPY_NUM: f32 = 9.75 * U;
/// [`SHARP`] of copies.
pub(super) const COPY_SHARP: f32 = 7.25 * U;
/// [`SHARP_U`] of copies.
pub(super) const COPY_SHARP_U: f32 = 9.25 * U;
/// [`SCREEN`] of copies.
pub(super) const COPY_SCREEN: f32 = 11.25 * U;
/// [`EDGES`] of copies.
pub(super) const COPY_EDGES: f32 = 18.5 * U;
/// The inverse depth of a copy is `COPY_DEPTH q` more uncertain, and `COPY_SLANT q |A|₁` relative to its largest value
/// on the projection as far as rays reach there.
pub(super) const COPY_DEPTH: f32 = 4.0 * U;
/// See [`COPY_DEPTH`].
pub(super) const COPY_SLANT: f32 = 3.25 * U;
/// T of a copy is known where `q |A|₁` times this is less than 1, and what it may be off by besides.
pub(super) const COPY_PLANE: f32 = 10.0 * U;

/// Rays beside an axis: what rounding makes of V, W and U there, relative to how far they are beside it.
pub(super) const BESIDE: f32 = 16.0 * U;
/// And relative to how far out their origins are.
pub(super) const AWAY: f32 = 7.0 * U;
/// The same of copies.
pub(super) const COPY_AWAY: f32 = 16.0 * U;
