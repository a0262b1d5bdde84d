//! Snaps many rays to a grid. For rays that hit nothing, snapping accounts for most of the work in
//! the `fixed` mode.
//!
//! ```text
//!   x, y, z, t_max in memory ──► * 2^k, 2^k, 2^k, 2^(scale - k) ──► x, y, z rounded
//! ```

use super::{Grid, GridError};
use crate::fixed::Ray;
use crate::fixed::numbers::{exponent, f32s, pow2, round};
use crate::simd::{Lanes, Mask, Simd, WithSimd, dispatch};

impl Grid {
    /// Snaps a ray's origin, and scales its direction by its own power of two so that the longest
    /// component uses all `q` bits. Each component changes by less than `2^-q` of the longest
    /// component. The interval does not change.
    ///
    /// # Errors
    /// Returns the same errors as [`Grid::snap`], and also an error if the direction is zero or not
    /// finite.
    #[inline]
    pub fn ray(&self, ray: &crate::Ray) -> Result<Ray, GridError> {
        let nothing = Ray::new([0; 3], [0; 3]);
        let (mut snapped, mut failed) = ([nothing], None);
        self.rays(&[*ray], &mut snapped, |_, error| {
            failed = Some(error);
            nothing
        });
        failed.map_or(Ok(snapped[0]), Err)
    }

    /// Like [`Grid::ray`], but for many rays. `snapped[i]` becomes the snapped `rays[i]` or, if
    /// snapping fails, the result of `otherwise` for the index and the error. An origin that
    /// consecutive rays share is snapped only once.
    ///
    /// ```
    /// use intertri::Ray;
    /// use intertri::fixed::{Bits, Grid};
    /// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
    /// let nothing = grid.ray_of([0; 3], [1, 0, 0])?.between(0.0, 0.0);
    /// let rays = [[1.0, 2.0, 3.0], [0.0; 3]].map(|dir| Ray::new([4.0, 5.0, 6.0], dir));
    /// let mut snapped = [nothing; 2];
    /// grid.rays(&rays, &mut snapped, |_, error| {
    ///     println!("{error}");
    ///     nothing
    /// });
    /// assert_eq!(snapped, [grid.ray(&rays[0])?, nothing]);
    /// # Ok::<_, intertri::fixed::GridError>(())
    /// ```
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    #[inline]
    pub fn rays(
        &self,
        rays: &[crate::Ray],
        snapped: &mut [Ray],
        otherwise: impl FnMut(usize, GridError) -> Ray,
    ) {
        assert_eq!(rays.len(), snapped.len(), "`rays` and `snapped` must have the same length");
        dispatch(Snap { grid: self, rays, snapped, otherwise });
    }

    /// Snaps the direction and the interval of a ray whose origin is already on the grid. This
    /// works for directions of any magnitude, because it scales by two factors: `2^k` itself may
    /// not be representable in f32.
    fn aim(&self, [x, y, z, _]: [f32; 4], ray: &crate::Ray) -> Result<Ray, GridError> {
        let longest = ray.dir.iter().fold(0.0, |far: f32, x| x.abs().max(far));
        if longest == 0.0 || !ray.dir.iter().all(|x| x.is_finite()) {
            return Err(GridError::Direction(ray.dir));
        }
        let q = self.bits.q as i32;
        let k = q - 1 - exponent(f64::from(longest) + pow2(exponent(longest.into()) - q));

        // Here, underflow and overflow affect only negligible components, or interval ends at which
        // no crossing is possible.
        let (up, back) = (halves(k), halves((self.scale - k).clamp(-252, 252)));
        let component = |x: f32| round((x * up[0] * up[1]).into()) as f32;
        let end = |t: f32| t * back[0] * back[1];
        let line = crate::Ray {
            origin: [x, y, z],
            t_min: end(ray.t_min),
            dir: ray.dir.map(component),
            t_max: end(ray.t_max),
        };
        Ok(Ray { line, exponent: k - self.scale })
    }
}

/// Snaps four rays at once if their longest components are between `2^-EVEN` and `2^EVEN`.
struct Four<S: Simd> {
    /// Half a unit in the last place of q bits, for a longest component in `1..2`.
    half: S::F32x4,
    /// `2^(q - 1)`
    unit: S::F32x4,
    /// `2^(scale - (q - 1))`
    back: S::F32x4,
    /// Adding and subtracting this value rounds the direction and leaves `t_max` unchanged.
    whole: S::F32x4,
    /// The difference between the biased exponent of k and the exponent of the ray.
    bias: i32,
}

/// The exponent of the limits of [`Four`].
const EVEN: i32 = 60;

impl<S: Simd> Four<S> {
    /// Returns `None` if the grid's scale or direction width is beyond the limits of this method.
    #[inline(always)]
    fn new(Grid { bits, scale, .. }: &Grid) -> Option<Self> {
        let (splat, one) = (S::F32x4::splat, bits.q as i32 - 1);
        // From 2^23 to 2^24, all f32 values are integers. Directions reach at most 2^22 from the
        // centre of that range.
        let whole = 1.5 * (1 << 23) as f32;
        (bits.q <= 22 && (scale - one).abs() <= EVEN).then_some(Self {
            half: splat(pow2(-one - 1) as f32),
            unit: splat(pow2(one) as f32),
            back: splat(pow2(scale - one) as f32),
            whole: S::F32x4::load(&[whole, whole, whole, 0.0]),
            bias: 127 + scale,
        })
    }

    /// Snaps the directions and intervals of four rays whose origins are already on the grid. In
    /// the result, bit i is set if `to[i]` is incorrect and must be computed by [`Grid::aim`].
    #[inline(always)]
    fn aim(&self, origins: &[[f32; 4]; 4], from: &[crate::Ray; 4], to: &mut [Ray; 4]) -> u32 {
        let (splat, load) = (S::F32x4::splat, S::F32x4::load);
        let numbers: &[[[f32; 4]; 2]; 4] = bytemuck::cast_ref(from);
        let [a, b, c, d] = numbers;
        let ends = [load(&a[1]), load(&b[1]), load(&c[1]), load(&d[1])];

        // The longest component is scaled to 2^(q-1) .. 2^q. If it would round up to 2^q, the
        // addition here carries into the exponent, and the component becomes 2^(q-1) instead.
        // Snapping a snapped direction again therefore does not change it.
        let [x, y, z, _] = S::transpose(ends);
        let (x, y, z) = (x.abs(), y.abs(), z.abs());
        let longest = x.max(y).max(z);
        let size = longest.power().mul_add(self.half, longest).power();
        let (up, back) = (self.unit / size, self.back * size);
        let mut ups = [0.0; 4];
        up.store(&mut ups);

        // Use a sum for the upper limit: it preserves a NaN that a maximum may lose.
        let (least, most) = (splat(pow2(-EVEN) as f32), splat(pow2(EVEN) as f32));
        let even = (longest.ge(least) & (x + y + z).le(most)).bits();

        // In memory, t_min follows the origin, and t_max follows the direction.
        let none = splat(0.0);
        let (near, far) =
            (S::transpose([none, none, none, back]), S::transpose([up, up, up, back]));
        for i in 0..4 {
            let line: &mut [[f32; 4]; 2] = bytemuck::cast_mut(&mut to[i].line);
            (load(&origins[i]) + load(&numbers[i][0]) * near[i]).store(&mut line[0]);
            (ends[i] * far[i] + self.whole - self.whole).store(&mut line[1]);
            to[i].exponent = (ups[i].to_bits() >> 23) as i32 - self.bias;
        }
        !even & 0xf
    }
}

/// Snaps rays in groups of four.
struct Snapper<'a, S: Simd, F> {
    grid: &'a Grid,
    four: Option<Four<S>>,
    /// The bits of the origin that was snapped last.
    last: (u64, u32),
    /// The result of snapping that origin.
    origin: Result<[f32; 4], GridError>,
    otherwise: F,
}

impl<S: Simd, F: FnMut(usize, GridError) -> Ray> Snapper<'_, S, F> {
    /// Snaps four rays. The first ray has the index `at`.
    #[inline(always)]
    fn snap(&mut self, at: usize, from: &[crate::Ray; 4], to: &mut [Ray; 4]) {
        // Most rays have the same origin as the rays before them.
        let [a, b, c, d] = from;
        let last = (self.last, self.last);
        if ((origin_bits(a), origin_bits(b)), (origin_bits(c), origin_bits(d))) == (last, last)
            && let (Some(four), Ok(origin)) = (&self.four, self.origin)
        {
            let left = four.aim(&[origin; 4], from, to);
            if left == 0 {
                return;
            }
        }

        let (mut origins, mut left) = ([[0.0; 4]; 4], 0);
        for i in 0..4 {
            match self.origin(&from[i]) {
                Ok(origin) => origins[i] = origin,
                Err(_) => left |= 1 << i,
            }
        }
        left |= match &self.four {
            Some(four) => four.aim(&origins, from, to),
            None => 0xf,
        };
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let grid = self.grid;
            let ray = self.origin(&from[i]).and_then(|origin| grid.aim(origin, &from[i]));
            to[i] = ray.unwrap_or_else(|error| (self.otherwise)(at + i, error));
        }
    }

    /// Returns the snapped origin of a ray.
    fn origin(&mut self, ray: &crate::Ray) -> Result<[f32; 4], GridError> {
        let bits = origin_bits(ray);
        if bits != self.last {
            let snapped = self.grid.snap(ray.origin).map(f32s);
            (self.last, self.origin) = (bits, snapped.map(|[x, y, z]| [x, y, z, 0.0]));
        }
        self.origin
    }
}

/// Returns the bits of a ray's origin, packed into two integers.
#[inline(always)]
fn origin_bits(ray: &crate::Ray) -> (u64, u32) {
    let [xy, zw, ..]: [u64; 4] = bytemuck::cast(*ray);
    (xy, zw as u32)
}

/// Snaps many rays at a given instruction level.
pub(super) struct Snap<'a, F> {
    pub(super) grid: &'a Grid,
    pub(super) rays: &'a [crate::Ray],
    pub(super) snapped: &'a mut [Ray],
    pub(super) otherwise: F,
}

impl<F: FnMut(usize, GridError) -> Ray> WithSimd for Snap<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { grid, rays, snapped, otherwise } = self;
        // No finite origin has these bits.
        let (last, origin) = ((u64::MAX, u32::MAX), Err(GridError::NotFinite([f32::NAN; 3])));
        let mut by = Snapper { grid, four: Four::<S>::new(grid), last, origin, otherwise };
        let ((fours, rest), (to_fours, to_rest)) =
            (rays.as_chunks::<4>(), snapped.as_chunks_mut::<4>());
        for (k, (from, to)) in fours.iter().zip(to_fours).enumerate() {
            by.snap(4 * k, from, to);
        }

        // Pad a remainder of fewer than four rays to four.
        if let ([.., ray], [.., to]) = (rest, &mut *to_rest) {
            let (mut four, mut to_four) = ([*ray; 4], [*to; 4]);
            four[..rest.len()].copy_from_slice(rest);
            by.snap(rays.len() - rest.len(), &four, &mut to_four);
            to_rest.copy_from_slice(&to_four[..rest.len()]);
        }
    }
}

/// Returns two factors whose product is `2^e`, for `-252 <= e <= 254`.
#[inline(always)]
fn halves(e: i32) -> [f32; 2] {
    let half = e >> 1;
    [half, e - half].map(|e| f32::from_bits(((e + 127) as u32) << 23))
}
