//! The slab test: tests one ray against the eight boxes of a node without losing a hit.
//!
//! ```text
//!        lo      hi               near = lo·r - (o·r + pad·|rd|)      r slightly less than rd = 1/d
//!   o ───│───────│──► d           far  = hi·R - (o·R - pad·|rd|)      R slightly more
//!      pad     pad                swapped where d < 0
//! ```
//!
//! A node costs one multiply-add per plane, because everything that depends only on the ray is
//! precomputed. One part of the rounding error is proportional to the origin, which `pad` covers,
//! and the other to t, which r and R cover. Other triangles of the scene have no effect, so a large
//! ground plane or a stray triangle does not widen other boxes. `docs/numerics/hierarchy.md` has
//! the proof.

use intertri::simd::Vec3;
use intertri::simd::{Lanes, Mask, Simd};
use intertri::{Ray, RayPacket};

use crate::tree::{Margin, Node};

/// The rounding unit of f32: 2^-24.
const U: f32 = f32::EPSILON / 2.0;

/// The padding along an axis, as a fraction of the origin's coordinate.
const PAD: f32 = 5.0 * U;

/// The factor that moves near planes nearer.
const NEARER: f32 = 1.0 - 6.0 * U;

/// The factor that moves far planes farther away.
const FARTHER: f32 = 1.0 + 6.0 * U;

/// The relative error of a computed negative t.
const BEFORE: f32 = 12.0 * U;

/// The magnitude of each direction component is raised to at least this fraction of the largest
/// component: 2^-65.
const STEEPEST: f32 = power_of_two(-65);

/// The magnitude of each direction component is also raised to at least this value (2^-120), and to
/// at least this fraction of the origin's largest coordinate and of the margin, so that products
/// with an inverse direction do not overflow.
const LEAST: f32 = power_of_two(-120);

/// A bound on the effect of underflow: 2^-120.
const TINY: f32 = power_of_two(-120);

/// Coordinates up to this value, and direction lengths between its inverse and this value, need no
/// scaling: 2^50.
const PLAIN: f32 = power_of_two(50);

/// The maximum magnitude of a coordinate: 2^124.
const LARGEST: f32 = power_of_two(124);

/// Returns `2^e`, which must be a normal number.
const fn power_of_two(e: i32) -> f32 {
    f32::from_bits(((127 + e) as u32) << 23)
}

/// Converts a number to f64. Subnormal numbers are read from their bits, because the CPU may be set
/// to read them as 0, but in a short direction, they matter.
fn widened(x: f32) -> f64 {
    let size = x.to_bits() << 1 >> 1;
    if size >> 23 == 0 {
        let unit = f64::from_bits((1023 - 149) << 52);
        (f64::from(size) * unit).copysign(x.into())
    } else {
        x.into()
    }
}

/// Returns the octant of a ray: bit k is set if the direction is negative along axis k.
#[inline(always)]
pub(crate) fn octant(ray: &Ray) -> usize {
    let [x, y, z] = ray.dir.map(|d| usize::from(d.is_sign_negative()));
    x | y << 1 | z << 2
}

/// Returns the largest magnitude of a coordinate.
#[inline(always)]
fn largest([x, y, z]: [f32; 3]) -> f32 {
    larger(larger(x.abs(), y.abs()), z.abs())
}

/// Returns the larger of two numbers. Unlike [`f32::max`], this takes a single instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// A ray prepared for the slab test: x, y, z, and an unused fourth lane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slabs {
    /// The inverse direction for near planes.
    near_rd: [f32; 4],
    /// The inverse direction for far planes.
    far_rd: [f32; 4],
    /// The negated contribution of the ray's origin and padding to the t of a near plane.
    minus_near: [f32; 4],
    /// The negated contribution of the ray's origin and padding to the t of a far plane.
    minus_far: [f32; 4],
}

/// [`Slabs`] packed into three quarters of a cache line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PackedSlabs([[f32; 3]; 4]);

/// Parallel lines from which [`Slabs`] are computed.
struct Lines {
    /// The box in which the lines start.
    from: [[f32; 3]; 2],
    dir: [f32; 3],
    /// The largest component of the direction.
    length: f32,
    /// The largest coordinate of the start.
    away: f32,
    /// The minimum magnitude of a direction component.
    least: f32,
    /// The t at which the lines start, which is at most 0.
    start: f32,
}

impl Slabs {
    /// Prepares a ray. Returns `None` if its values are so large or so small that it must be
    /// scaled; see [`Slabs::scaled`].
    #[inline(always)]
    pub(crate) fn new<S: Simd>(ray: &Ray, margin: &Margin) -> Option<Self> {
        Self::around::<S>([ray.origin, ray.origin], ray.dir, 0.0, margin)
    }

    /// Prepares parallel lines that start in a box and whose t begins at `start`.
    #[inline(always)]
    pub(crate) fn around<S: Simd>(
        from: [[f32; 3]; 2],
        dir: [f32; 3],
        start: f32,
        margin: &Margin,
    ) -> Option<Self> {
        let (length, away) = (largest(dir), larger(largest(from[0]), largest(from[1])));
        // Negate the whole condition, so that NaN also requires scaling.
        if !(length < PLAIN && length > 1.0 / PLAIN && away + margin.reach < PLAIN) {
            return None;
        }
        // The inverse of a component near 0 would overflow. A component below `least` is replaced
        // by `least`, which `level` compensates for below.
        let least = length * STEEPEST + (away + margin.room(away) + 1.0) * LEAST;
        Some(Self::of::<S>(&Lines { from, dir, length, away, least, start }, margin))
    }

    /// Prepares a ray of any length by scaling its direction to a length of about 1. The scaled
    /// ray's t is then unrelated to the original t. Returns `None` if coordinates are near the
    /// limits of f32, where only a plain loop is safe.
    #[cold]
    #[inline(never)]
    pub(crate) fn scaled<S: Simd>(ray: &Ray, margin: &Margin) -> Option<Self> {
        let (dir, away) = (ray.dir.map(widened), largest(ray.origin));
        let length = dir.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if !(away + margin.reach < LARGEST && length > 0.0 && length < f64::INFINITY) {
            return None;
        }
        // Scale in f64, because the power of two may not be representable in f32. Components that
        // become 0 are negligible.
        let by = f64::from_bits(((1023.0 - length.log2().floor()) as u64) << 52);
        let dir = dir.map(|x| (x * by) as f32);
        let length = largest(dir);
        let least = length * STEEPEST + (away + margin.room(away) + 1.0) * LEAST;
        let (from, least) = ([ray.origin, ray.origin], least.min(0.25 * length));
        Some(Self::of::<S>(&Lines { from, dir, length, away, least, start: 0.0 }, margin))
    }

    #[inline(always)]
    fn of<S: Simd>(lines: &Lines, margin: &Margin) -> Self {
        let &Lines { from: [lo, hi], dir: [dx, dy, dz], length, away, least, start } = lines;
        let splat = S::F32x4::splat;
        let load = |[x, y, z]: [f32; 3]| S::F32x4::load(&[x, y, z, 0.0]);
        let room = Room {
            least: splat(least),
            off: splat(margin.room(away) + TINY),
            before: splat(start.abs() * BEFORE + TINY),
        };
        // The fourth lane is unused. With 1, the division below does not have to wait for `length`.
        let dir = S::F32x4::load(&[dx, dy, dz, 1.0]);
        let [near_rd, far_rd, minus_near, minus_far] = planes(
            [load(lo), load(hi)],
            dir,
            &room,
            #[inline(always)]
            || splat(2.0 * (away + margin.reach) / length),
        );
        let mut slabs = Self::default();
        near_rd.store(&mut slabs.near_rd);
        far_rd.store(&mut slabs.far_rd);
        minus_near.store(&mut slabs.minus_near);
        minus_far.store(&mut slabs.minus_far);
        slabs
    }

    /// Packs the slabs into less memory.
    #[inline(always)]
    pub(crate) fn packed(&self) -> PackedSlabs {
        let three = |v: &[f32; 4]| [v[0], v[1], v[2]];
        let Self { near_rd, far_rd, minus_near, minus_far } = self;
        PackedSlabs([three(near_rd), three(far_rd), three(minus_near), three(minus_far)])
    }
}

/// The amounts by which a ray's slabs are widened, not including the amounts that depend on its
/// coordinates along an axis.
struct Room<F> {
    /// The minimum magnitude of a direction component.
    least: F,
    /// The widening, as a length in space.
    off: F,
    /// The additional widening, as an interval of t.
    before: F,
}

/// Computes the factors and constants of slabs in lanes, for lines that start between two
/// coordinates along an axis. The lanes are the axes of one ray, or one axis of several rays. No
/// hit has a t beyond `last`.
#[inline(always)]
fn planes<F: Lanes<Scalar = f32>>(
    [lo, hi]: [F; 2],
    dir: F,
    room: &Room<F>,
    last: impl FnOnce() -> F,
) -> [F; 4] {
    let (size, splat) = (dir.abs(), F::splat);
    // Traversal waits for this division, so it starts before `least` is known.
    let mut rd = splat(1.0) / dir;
    let level = !room.least.le(size);
    let is_level = level.any();
    if is_level {
        // A component near 0 is replaced. `flip` keeps the sign of a zero: a ray with -0 enters
        // boxes through their upper sides.
        rd = splat(1.0) / size.max(room.least).flip(dir);
    }
    // Move near planes slightly nearer and far planes slightly farther, so that rounding never
    // loses a box.
    let (near_rd, far_rd) = (rd * splat(NEARER), rd * splat(FARTHER));

    // The rounding error of the origin's coordinate is a length in space. Divided by the direction,
    // it becomes an interval of t.
    let off = lo.abs().max(hi.abs()) * splat(PAD) + room.off;
    let mut pad = off * rd.abs() + room.before;
    if is_level {
        // A component that was replaced changes the t of a plane by less than `last`, beyond which
        // nothing is hit.
        pad = pad + F::select(level, last(), splat(0.0));
    }
    // `side * rd + minus` is then a single multiply-add per plane of a node. A beam starts in a
    // box, so use the start with the nearest near plane and the start with the farthest far plane.
    let minus_near = -((lo * near_rd).max(hi * near_rd) + pad);
    [near_rd, far_rd, minus_near, pad - (lo * far_rd).min(hi * far_rd)]
}

/// Slabs in lanes: one ray against eight boxes, or several rays in an octant against one box.
#[derive(Clone, Copy)]
pub(crate) struct SlabLanes<F> {
    near_rd: Vec3<F>,
    far_rd: Vec3<F>,
    minus_near: Vec3<F>,
    minus_far: Vec3<F>,
    negative: [bool; 3],
}

impl<F: Lanes<Scalar = f32>> SlabLanes<F> {
    /// Broadcasts a ray to all lanes.
    #[inline(always)]
    pub(crate) fn splat(slabs: &Slabs, octant: usize) -> Self {
        Self::unpack(&slabs.packed(), octant)
    }

    /// Broadcasts a packed ray to all lanes.
    #[inline(always)]
    pub(crate) fn unpack(PackedSlabs(slabs): &PackedSlabs, octant: usize) -> Self {
        Self {
            near_rd: Vec3::splat(slabs[0]),
            far_rd: Vec3::splat(slabs[1]),
            minus_near: Vec3::splat(slabs[2]),
            minus_far: Vec3::splat(slabs[3]),
            negative: [0, 1, 2].map(|k| octant >> k & 1 != 0),
        }
    }

    /// Prepares a packet whose rays share an octant, one ray per lane. The mask marks the rays that
    /// do not need scaling; see [`Slabs::new`].
    #[inline(always)]
    pub(crate) fn of_packet<const N: usize>(
        packet: &RayPacket<N>,
        octant: usize,
        margin: &Margin,
    ) -> (Self, F::Mask) {
        let (splat, load) = (F::splat, Vec3::<F>::load);
        let (from, dir) = (load(&packet.origin), load(&packet.dir));
        let away = from.x.abs().max(from.y.abs()).max(from.z.abs());
        let length = dir.x.abs().max(dir.y.abs()).max(dir.z.abs());
        let beside = away * splat(margin.beside) + splat(margin.lean);
        let least = length * splat(STEEPEST) + (away + beside + splat(1.0)) * splat(LEAST);
        let room = Room { least, off: beside + splat(TINY), before: splat(TINY) };
        let most = away + splat(margin.reach);
        let is_plain =
            length.lt(splat(PLAIN)) & splat(1.0 / PLAIN).lt(length) & most.lt(splat(PLAIN));

        // Avoid `map`: it is not always inlined and would then be compiled without the level's
        // instructions.
        let last = splat(2.0) * most / length;
        let x = planes(
            [from.x; 2],
            dir.x,
            &room,
            #[inline(always)]
            || last,
        );
        let y = planes(
            [from.y; 2],
            dir.y,
            &room,
            #[inline(always)]
            || last,
        );
        let z = planes(
            [from.z; 2],
            dir.z,
            &room,
            #[inline(always)]
            || last,
        );
        let slabs = Self {
            near_rd: Vec3 { x: x[0], y: y[0], z: z[0] },
            far_rd: Vec3 { x: x[1], y: y[1], z: z[1] },
            minus_near: Vec3 { x: x[2], y: y[2], z: z[2] },
            minus_far: Vec3 { x: x[3], y: y[3], z: z[3] },
            negative: [0, 1, 2].map(|k| octant >> k & 1 != 0),
        };
        (slabs, is_plain)
    }

    /// Returns a mask of a node's boxes that the ray intersects within `t_min..=t_max`, and a lower
    /// bound on the t at which each box begins. No box with a hit in that interval is missed.
    #[inline(always)]
    pub(crate) fn meet(&self, node: &Node, t_min: f32, t_max: f32) -> (F::Mask, F) {
        self.meet_sides(
            #[inline(always)]
            |axis, upper| F::load(node.sides(axis, upper)),
            F::splat(t_min),
            F::splat(t_max),
        )
    }

    /// Like [`SlabLanes::meet`], but takes boxes as their lower and upper sides along each axis,
    /// with a separate interval in each lane.
    #[inline(always)]
    pub(crate) fn meet_sides(
        &self,
        side: impl Fn(usize, bool) -> F,
        t_min: F,
        t_max: F,
    ) -> (F::Mask, F) {
        // Along each axis, the ray enters through one plane and leaves through the other.
        let [x, y, z] = self.negative;
        let near = (side(0, x).mul_add(self.near_rd.x, self.minus_near.x))
            .max(side(1, y).mul_add(self.near_rd.y, self.minus_near.y))
            .max(side(2, z).mul_add(self.near_rd.z, self.minus_near.z).max(t_min));
        let far = (side(0, !x).mul_add(self.far_rd.x, self.minus_far.x))
            .min(side(1, !y).mul_add(self.far_rd.y, self.minus_far.y))
            .min(side(2, !z).mul_add(self.far_rd.z, self.minus_far.z).min(t_max));
        (near.le(far), near)
    }
}

#[cfg(test)]
mod tests {
    use intertri::Ray;
    use intertri::simd::{Level, Mask, Simd, WithSimd};

    use super::{SlabLanes, Slabs, octant, widened};
    use crate::tree::{Aabb, Margin, Node};
    use crate::util::test_numbers::random;

    #[test]
    fn numbers_are_widened_exactly() {
        let sizes = [0, 1, 2, 0x0040_0001, 0x007F_FFFF, 0x0080_0000, 0x3F80_0001, 0x7F7F_FFFF];
        for x in sizes.into_iter().flat_map(|bits| [bits, bits | 1 << 31]).map(f32::from_bits) {
            assert_eq!(widened(x).to_bits(), f64::from(x).to_bits(), "{x:e}");
        }
    }

    /// Tests whether a ray intersects a box up to the first t, and whether it does so from the
    /// second t on.
    struct Meets<'a>(&'a Ray, Aabb, [f32; 2]);

    impl WithSimd for Meets<'_> {
        type Output = [bool; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> [bool; 2] {
            let Self(ray, bounds, [before, after]) = self;
            let mut node = Node::NO_CHILDREN;
            node.set(3, &bounds, 0);
            let slabs = Slabs::new::<S>(ray, &Margin::new(1.0, None)).unwrap();
            let lanes = SlabLanes::<S::F32x8>::splat(&slabs, octant(ray));
            let ends = [[0.0, before], [after, f32::INFINITY]];
            ends.map(|[t_min, t_max]| lanes.meet(&node, t_min, t_max).0.bits() == 1 << 3)
        }
    }

    /// Returns a 24-bit integer, often slightly above a power of two, where relative rounding
    /// errors are largest, or slightly below a power of two, where the errors of the inverse are
    /// largest.
    fn digits(random: &mut impl FnMut() -> f32) -> f32 {
        let size = (23.0 * random()).floor().exp2();
        let off = (size * random()).floor();
        let power = 23_f32.exp2();
        if random() < 0.5 { power + off } else { 2.0 * power - 1.0 - off }
    }

    /// Returns an origin, a direction component, and a plane that is reached at a positive t.
    fn origin_direction_plane(random: &mut impl FnMut() -> f32) -> [f32; 3] {
        loop {
            let (dir, mut origin) = (digits(random), digits(random));
            let plane = if random() < 0.4 {
                origin + (1.0 + 23.0 * random()).exp2().floor()
            } else {
                origin *= (34.0 * random() - 26.0).floor().exp2();
                origin = if random() < 0.5 { origin } else { -origin };
                digits(random)
            };
            if plane > origin {
                return [origin, dir, plane];
            }
        }
    }

    /// Checks that the padding and the factors cover rounding errors. A fifth of `PAD` would not be
    /// enough, nor would a third of the difference between `NEARER` or `FARTHER` and 1.
    #[test]
    fn no_plane_is_met_too_late_or_left_too_early() {
        let mut random = random();
        for i in 0..300_000 {
            let [origin, dir, plane] = origin_direction_plane(&mut random);
            // Compute the f32 values just below and above the exact t. The product of two f32
            // values is exact in f64, and so is the distance.
            let way = f64::from(plane) - f64::from(origin);
            let reached = |t: f32| f64::from(t) * f64::from(dir);
            let near = (way / f64::from(dir)) as f32;
            let before = if reached(near) > way { near.next_down() } else { near };
            let after = if reached(near) < way { near.next_up() } else { near };

            let (axis, sign) = (i % 3, if i / 3 % 2 == 0 { 1.0 } else { -1.0 });
            let (mut from, mut to) = ([0.0; 3], [dir; 3]);
            (from[axis], to[axis]) = (sign * origin, sign * dir);
            let ray = Ray::new(from, to);
            // The box is flat along this axis and wide along the other two.
            let (mut lo, mut hi) = ([-1e30; 4], [1e30; 4]);
            (lo[axis], hi[axis]) = (sign * plane, sign * plane);
            for level in Level::all() {
                let met = level.run(Meets(&ray, Aabb { lo, hi }, [before, after]));
                assert_eq!(met, [true; 2], "{}, {axis}: {ray:?}, {plane}", level.name());
            }
        }
    }
}
