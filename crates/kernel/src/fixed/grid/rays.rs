//! Rays onto a grid, many at a time: this is most of what `fixed` does for a ray that meets nothing.
//!
//! ```text
//!   x, y, z, t_max in memory ──► * 2^k, 2^k, 2^k, 2^(scale - k) ──► x, y, z rounded
//! ```

use super::{Grid, GridError};
use crate::fixed::Ray;
use crate::fixed::edges::f32s;
use crate::lanes::{Lanes, Simd, WithSimd, dispatch};

impl Grid {
    /// A ray with its origin snapped, and its direction by a power of two of its own, so that its
    /// longest component has all `q` bits: each component moves by less than `2^-q` of the longest.
    /// The interval stays as it is.
    ///
    /// # Errors
    /// Those of [`Grid::snap`], and a direction that is zero or not finite.
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

    /// [`Grid::ray`] of many rays: `snapped[i]` becomes `rays[i]`, or what `otherwise` gives for its
    /// number and error. An origin that neighbours share is snapped once.
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
    /// If the slices differ in length.
    #[inline]
    pub fn rays(
        &self,
        rays: &[crate::Ray],
        snapped: &mut [Ray],
        otherwise: impl FnMut(usize, GridError) -> Ray,
    ) {
        assert_eq!(rays.len(), snapped.len(), "one snapped ray a ray");
        dispatch(Snap { grid: self, rays, snapped, otherwise });
    }

    /// Snaps a ray whose origin is on the grid already.
    #[inline(always)]
    fn aim<S: Simd>(
        &self,
        origin: [f32; 3],
        ray: &crate::Ray,
        to: &mut Ray,
    ) -> Result<(), GridError> {
        // Without signs, the bits of f32 are ordered as the numbers are, infinity and NaNs last.
        let [x, y, z] = ray.dir.map(|x| x.abs().to_bits());
        let longest = x.max(y).max(z);
        if longest.wrapping_sub(1) >= f32::MAX.to_bits() {
            return Err(GridError::Direction(ray.dir));
        }

        // The longest component comes to lie in 2^(q-1) .. 2^q. Where it would be rounded up to 2^q, what
        // is added here carries into the exponent, and it comes to lie at 2^(q-1): so that a snapped
        // direction is snapped to itself.
        let q = self.bits.q as i32;
        let carried = f64::from(f32::from_bits(longest)).to_bits() + (1 << (52 - q));
        let k = q - 1 - ((carried >> 52) as i32 - 1023);

        // Direction and far end lie side by side. Each is scaled in two steps, for 2^k need not be an
        // f32; what underflows or overflows on the way is nothing, or an end where no crossing can be.
        let ([a, b], [c, d]) = (halves(k), halves((self.scale - k).clamp(-252, 252)));
        let numbers: &[f32; 8] = bytemuck::cast_ref(ray);
        let unit = [S::F32x4::load(&[a, a, a, c]), S::F32x4::load(&[b, b, b, d])];
        let far = S::F32x4::load(&numbers[4..]) * unit[0] * unit[1];

        // The direction is rounded, ties to even: from 2^23 on f32 have no fractions.
        let (size, whole) = (far.abs(), (1 << 23) as f32);
        let above = S::F32x4::splat(whole);
        let rounded = ((size + above) - above).flip(far) + S::F32x4::splat(0.0);
        let fraction = size.lt(S::F32x4::load(&[whole, whole, whole, 0.0]));
        let mut numbers = [0.0; 4];
        S::F32x4::select(fraction, rounded, far).store(&mut numbers);
        let [x, y, z, t_max] = numbers;
        to.line = crate::Ray { origin, t_min: ray.t_min * c * d, dir: [x, y, z], t_max };
        to.exponent = k - self.scale;
        Ok(())
    }
}

/// Many rays, at the best level.
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
        let Self { grid, rays, snapped, mut otherwise } = self;
        let mut last = ([f32::NAN; 3], Ok([0.0; 3]));
        for (i, (ray, to)) in rays.iter().zip(snapped).enumerate() {
            if ray.origin != last.0 {
                last = (ray.origin, grid.snap(ray.origin).map(f32s));
            }
            if let Err(error) = last.1.and_then(|origin| grid.aim::<S>(origin, ray, to)) {
                *to = otherwise(i, error);
            }
        }
    }
}

/// Two factors that make `2^e` up, `-252 <= e <= 254`.
#[inline(always)]
fn halves(e: i32) -> [f32; 2] {
    let half = e >> 1;
    [half, e - half].map(|e| f32::from_bits(((e + 127) as u32) << 23))
}
