//! The constants of the filter's error bounds. `docs/numerics/certified.md` derives each of them.
//!
//! `u` is half an ulp of 1 in f32, |.|₁ and |.|₂ are the 1-norm and the 2-norm, and h is the
//! longest edge. The noise of the reference is the rounding error of document A's own computation
//! in f64.

/// Half an ulp of 1 in f32.
pub(super) const U: f32 = 1.0 / (1 << 24) as f32;

/// The errors of V, W, U, and the denominator in the precheck, each divided by h, are within
/// `PRECHECK |d|₂ (|c1|₁ + h + |o|₁)`.
pub(super) const PRECHECK: f32 = 32.0 * U;

/// The errors of V and W, including the reference's own noise, are within
/// `EDGE |d|₂ h (|A|₁ + NEAR h)`.
pub(super) const EDGE: f32 = 6.5 * U;

/// The coefficient of the edge length in the bound described at [`EDGE`]. The error of U is within
/// twice the bound on V and W.
pub(super) const NEAR: f32 = 0.65;

/// The error of V is within `SHARP perm(h5, d, A)`, plus noise. The error of W is bounded in the
/// same way.
pub(super) const SHARP: f32 = 6.25 * U;

/// The error of U is within `SHARP_U` times the sum of all three permanents, plus noise.
pub(super) const SHARP_U: f32 = 8.25 * U;

/// The error of the denominator is within `DEN |d|₂ h²`.
pub(super) const DEN: f32 = 8.5 * U;

/// The error of the numerator is within `NUM |A|₁ h²`.
pub(super) const NUM: f32 = 8.5 * U;

/// The sharp error bound on the numerator is `SHARP_NUM perm(h4, h5, A)`, plus the reference's
/// noise.
pub(super) const SHARP_NUM: f32 = 8.25 * U;
/// The reference's noise in the numerator is within `NUM_NOISE |A|₁ h²`. The value is 2^-49.
pub(super) const NUM_NOISE: f32 = f32::from_bits((127 - 49) << 23);

/// The filter decides nothing if the denominator is below `GRAZING |d|₂ h²`, because the
/// reference's own rounding errors are amplified too much.
pub(super) const GRAZING: f32 = 24.0 * U;

/// The error of t is within `SLACK (NUM |A|₁ h² + |t| DEN |d|₂ h²) / |den| + ROUND |t|`.
pub(super) const SLACK: f32 = 1.6;
/// The coefficient of `|t|` in the error bound described at [`SLACK`].
pub(super) const ROUND: f32 = 8.0 * U;

/// A ray is certainly not parallel if its denominator exceeds this multiple of `Threshold |n|`.
pub(super) const PARALLEL: f32 = 1.001;

/// |n|₂ is at most `AREA h²`: among the triangles with a given longest edge, the equilateral one
/// has the largest area.
pub(super) const AREA: f32 = 0.8661;

/// The rounding error of the hit point, relative to the 1-norm of the origin: 2^-51.
pub(super) const ORIGIN: f32 = f32::from_bits((127 - 51) << 23);

/// The filter does not decide if a coordinate or the length of a direction exceeds this value
/// (2^40). The limit keeps products from overflowing.
pub(super) const LARGEST: f32 = (1_u64 << 40) as f32;
/// The filter does not decide if a direction is shorter than this value (2^-40).
pub(super) const SHORTEST_DIR: f32 = 1.0 / LARGEST;

/// A term added to `GRAZING h²` (2^-80). Multiplied by the length of a direction, it exceeds the
/// effect of underflow on the denominator.
pub(super) const GRAZING_ADD: f32 = f32::from_bits((127 - 80) << 23);

/// The error bound on an edge function is at least `OFF_ADD h`, which exceeds the effect of
/// underflow. The value is 2^-72.
pub(super) const OFF_ADD: f32 = f32::from_bits((127 - 72) << 23);

/// A bound on the effect of underflow on a product or a sum, whether or not results are flushed to
/// zero.
pub(super) const TINY: f32 = f32::from_bits((127 - 120) << 23);
/// A bound on the effect of underflow on an edge, a direction, or a translated corner, as a length.
pub(super) const SMALL: f32 = f32::from_bits((127 - 100) << 23);

/// A factor that rounds up the square root of a sum of squares. [`NORM_ADD`] covers underflow.
pub(super) const NORM_UP: f32 = 1.0 + 16.0 * U;
/// A term added to the square root of a sum of squares to cover underflow: 2^-49.
pub(super) const NORM_ADD: f32 = f32::from_bits((127 - 49) << 23);

/// A bound on the reference's own noise, relative to `|d|₂ h (|A|₂ + h)`, and on the f64 rounding
/// error in a frame.
pub(super) const NOISE: f32 = 0.25 * U;

/// The largest distance of a projected point from the centre, along x and along y.
pub(super) const SCREEN_EDGE: f32 = 0.5;

/// A direction on the projection is at most this many times as long as its depth.
pub(super) const LEAN: f32 = 1.23;

/// The error of a linear form at a point on the projection, rounded to f32, is within
/// `SCREEN |form|₁`.
pub(super) const SCREEN: f32 = 9.25 * U;

/// In the projection's axes, the errors of an edge form's coefficients, including the reference's
/// noise, are within `EDGES h (|A|₁ + h)`.
pub(super) const EDGES: f32 = 16.75 * U;

/// The error of the inverse depth is within `DEPTH |s|₁` plus `LOST h² / |T|`.
pub(super) const DEPTH: f32 = 16.0 * U;
/// The coefficient of `h² / |T|` in the error bound described at [`DEPTH`]: 2^-45.
pub(super) const LOST: f32 = 1.0 / (1_u64 << 45) as f32;

/// The relative error of `1 / (t * depth)`.
pub(super) const INVERSE: f32 = 10.0 * U;

/// On the projection, the reference may accept a point that is outside a triangle by up to
/// `ROOM h + ROOM_AWAY |o|₁`, divided by the triangle's least depth. The value is 2^-19.
pub(super) const ROOM: f32 = 1.0 / (1_u64 << 19) as f32;
/// The coefficient of `|o|₁` in the margin described at [`ROOM`]: 2^-46.
pub(super) const ROOM_AWAY: f32 = 1.0 / (1_u64 << 46) as f32;
/// The error of a triangle's corner is within `CORNER |A|₁`.
pub(super) const CORNER: f32 = 11.0 * U;
/// The rounding error of a bounding rectangle's sides on the projection: 2^-20.
pub(super) const ROOM_SCREEN: f32 = 16.0 * U;

/// A triangle for which `h² / |n|₁` exceeds this value (2^24) has no bounding rectangle.
pub(super) const THIN: f32 = (1_u64 << 24) as f32;

/// On a projection, a t below this value (2^-80) counts as unknown: its product with a depth could
/// be subnormal, and the rounding error of a subnormal result exceeds `INVERSE`.
pub(super) const SHORTEST_T: f32 = f32::from_bits((127 - 80) << 23);

/// If rays miss the origin by up to `off`, the bound on an edge function grows by `OFF_EDGE h off`.
pub(super) const OFF_EDGE: f32 = 1.25;
/// If rays miss the origin by up to `off`, the error of the inverse depth grows by
/// `OFF_DEPTH off |s|₁`, relative to the largest inverse depth on the part of the projection that
/// the rays reach.
pub(super) const OFF_DEPTH: f32 = 1.5;
/// If rays miss the origin, this margin (2^-19) is added to the extent of the part of the
/// projection that they reach.
pub(super) const OFF_REACH: f32 = 1.0 / (1 << 19) as f32;
/// If rays miss the origin by up to `off`, the margin around a triangle grows by `OFF_ROOM off`.
pub(super) const OFF_ROOM: f32 = 1.25;
/// If rays miss the origin by up to `off`, the sign of T is known if `OFF_PLANE |s|₁ off` is less
/// than 1.
pub(super) const OFF_PLANE: f32 = 4.0;

/// For f32 copies of f64 originals (`docs/numerics/f64.md`, section 4): the relative error of a
/// corner, of an origin, and of each component of an edge and a direction.
pub(super) const COPY: f32 = 1.02 * U;
/// [`EDGE`] for copies.
pub(super) const COPY_EDGE: f32 = 7.5 * U;
/// [`DEN`] for copies.
pub(super) const COPY_DEN: f32 = 9.5 * U;
/// [`GRAZING`] for copies.
pub(super) const COPY_GRAZING: f32 = 27.0 * U;
/// [`NUM`] for copies.
pub(super) const COPY_NUM: f32 = 9.75 * U;
/// [`SHARP`] for copies.
pub(super) const COPY_SHARP: f32 = 7.25 * U;
/// [`SHARP_U`] for copies.
pub(super) const COPY_SHARP_U: f32 = 9.25 * U;
/// [`SCREEN`] for copies.
pub(super) const COPY_SCREEN: f32 = 11.25 * U;
/// [`EDGES`] for copies.
pub(super) const COPY_EDGES: f32 = 18.5 * U;
/// For copies, the error of the inverse depth grows by `COPY_DEPTH q`, where q is `h² / |T|`.
pub(super) const COPY_DEPTH: f32 = 4.0 * U;
/// For copies, the error of the inverse depth also grows by `COPY_SLANT q |A|₁`, relative to the
/// largest inverse depth on the part of the projection that the rays reach.
pub(super) const COPY_SLANT: f32 = 3.25 * U;
/// For copies, the sign of T is known if `COPY_PLANE q |A|₁`, together with the other relative
/// errors of T, is less than 1.
pub(super) const COPY_PLANE: f32 = 10.0 * U;

/// For rays parallel to an axis: the error of V, W, and U, relative to the distance from the axis.
pub(super) const BESIDE: f32 = 16.0 * U;
/// For rays parallel to an axis: the additional error of V, W, and U, relative to the magnitude of
/// the origins' coordinates.
pub(super) const AWAY: f32 = 7.0 * U;
/// [`AWAY`] for copies.
pub(super) const COPY_AWAY: f32 = 16.0 * U;

/// For parallel rays on a projection: the error of a point, relative to the distance of the origin from
/// the frame's origin.
pub(super) const PLACE: f32 = 6.0 * U;
/// For parallel rays: the error of the depth at t is within `BEGIN away / |d|₂ + ALONG |depth|`.
pub(super) const BEGIN: f32 = 8.0 * U;
/// The coefficient of the depth in the error bound described at [`BEGIN`].
pub(super) const ALONG: f32 = 6.0 * U;
/// For parallel rays: the errors of an edge form's coefficients are within
/// `EDGES_ALONG scale² h (|A|₁ + h + 2 away)`.
pub(super) const EDGES_ALONG: f32 = 18.5 * U;
/// [`EDGES_ALONG`] for copies.
pub(super) const COPY_EDGES_ALONG: f32 = 23.0 * U;
/// For parallel rays: the error of a form for depths is within `LOST_ALONG q (|A|₁ + 2 away) / |d|₂`,
/// where q is `h² |d|₂ / |D|`. The value is 2^-47.
pub(super) const LOST_ALONG: f32 = 1.0 / (1_u64 << 47) as f32;
/// [`LOST_ALONG`] for copies, whose coordinates and depths also count.
pub(super) const COPY_LOST_ALONG: f32 = 4.25 * U;
/// For copies of parallel rays: the share of the frame's coordinates that counts in the bounds of
/// edges and rectangles.
pub(super) const COPY_APART: f32 = 0.25;
/// For parallel rays: the sign of D is known if this times `h² |d|₂ / |D|` is below 1. The value is
/// 2^-19.
pub(super) const GRAZING_ALONG: f32 = 1.0 / (1 << 19) as f32;
/// For parallel rays: the margin around a triangle is `ROOM_ALONG scale (|A|₁ + h + away)`.
pub(super) const ROOM_ALONG: f32 = 8.0 * U;
/// [`ROOM_ALONG`] for copies.
pub(super) const COPY_ROOM_ALONG: f32 = 11.0 * U;
/// The largest distance of a ray's point from the centre of the projection of parallel rays, in
/// units of `1 / scale`.
pub(super) const ACROSS: f32 = 0.75;
