//! The lane types of one instruction level.

use super::int::Ints;
use super::lanes::{Lanes, Mask};
use super::level::Level;
use super::vec3::Vec3;

/// The lane types of one instruction level.
///
/// Only [`dispatch`](super::dispatch) and [`Level::run`] provide these types, and only on a CPU
/// that has the instructions.
///
/// ```
/// use intertri::simd::{Ints, Lanes, Simd, WithSimd, dispatch};
/// struct Widths;
/// impl WithSimd for Widths {
///     type Output = [usize; 6];
///     fn run<S: Simd>(self) -> [usize; 6] {
///         assert!(intertri::simd::Level::all().any(|level| level == S::LEVEL));
///         let [a, b, c] = [S::F32x4::N, S::F32x8::N, S::F32x16::N];
///         [a, b, c, S::F64x4::N, S::F64x8::N, S::I64x8::N]
///     }
/// }
/// assert_eq!(dispatch(Widths), [4, 8, 16, 4, 8, 8]);
/// ```
pub trait Simd: Copy {
    /// Four f32 lanes.
    type F32x4: Lanes<Scalar = f32>;
    /// Eight f32 lanes.
    type F32x8: Lanes<Scalar = f32>;
    /// Sixteen f32 lanes.
    type F32x16: Lanes<Scalar = f32>;
    /// Four f64 lanes.
    type F64x4: Lanes<Scalar = f64>;
    /// Eight f64 lanes.
    type F64x8: Lanes<Scalar = f64>;
    /// Eight i64 lanes.
    type I64x8: Ints;
    /// Eight lanes of the widest integers that are worthwhile in lanes: 128 bits with AVX-512, otherwise
    /// those of [`Simd::I64x8`].
    type WideInts: Ints;
    /// As many f32 lanes as fit in one register.
    type F32s: Lanes<Scalar = f32>;
    /// As many f64 lanes as [`Simd::F32s`] has f32 lanes.
    type F64s: Lanes<Scalar = f64>;
    /// The level.
    const LEVEL: Level;

    /// Runs work in a separate function that is compiled with this level's instructions. The
    /// closure and the functions it calls must be `#[inline(always)]`.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Twice(f32);
    /// impl WithSimd for Twice {
    ///     type Output = f32;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> f32 {
    ///         let mut lanes = [self.0; 8];
    ///         S::vectorize(#[inline(always)] || {
    ///             let x = S::F32x8::load(&lanes);
    ///             (x + x).store(&mut lanes);
    ///         });
    ///         lanes[7]
    ///     }
    /// }
    /// assert_eq!(dispatch(Twice(21.0)), 42.0);
    /// ```
    fn vectorize<R>(work: impl FnOnce() -> R) -> R {
        work()
    }

    /// Permutes lanes. Byte i of `order`, starting at the lowest, is the index, modulo 8, of the
    /// lane that becomes lane i.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    /// struct Reversed([f32; 8]);
    /// impl WithSimd for Reversed {
    ///     type Output = [f32; 8];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(mut self) -> [f32; 8] {
    ///         S::permute(S::F32x8::load(&self.0), 0x00_01_02_03_04_05_06_07).store(&mut self.0);
    ///         self.0
    ///     }
    /// }
    /// let reversed = dispatch(Reversed([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]));
    /// assert_eq!(reversed, [7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0]);
    /// ```
    #[inline(always)]
    fn permute(lanes: Self::F32x8, order: u64) -> Self::F32x8 {
        // Like the other default implementations in this trait, this one goes through memory. It is
        // correct at every level; levels that have a suitable instruction override it.
        let (mut from, mut to) = ([0.0; 8], [0.0; 8]);
        lanes.store(&mut from);
        for (to, lane) in to.iter_mut().zip(order.to_le_bytes()) {
            *to = from[usize::from(lane % 8)];
        }
        Lanes::load(&to)
    }

    /// Returns the lane of the smallest value among the lanes in a mask. If several values are
    /// equal except for their last three bits, the result may be the lane of any of them. For
    /// negative values or an empty mask, it may be any of the eight lanes.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    /// struct Below([f32; 8], f32);
    /// impl WithSimd for Below {
    ///     type Output = usize;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> usize {
    ///         let lanes = S::F32x8::load(&self.0);
    ///         S::lane_of_least(lanes, lanes.gt(Lanes::splat(self.1)))
    ///     }
    /// }
    /// let lanes = [7.0, 0.5, 3.0, 4.0, 2.0, 9.0, 0.0, 1.0];
    /// assert_eq!([0.2, 0.7, 2.5].map(|x| dispatch(Below(lanes, x))), [1, 7, 2]);
    /// ```
    #[inline(always)]
    fn lane_of_least(lanes: Self::F32x8, mask: <Self::F32x8 as Lanes>::Mask) -> usize {
        let (mut numbers, bits) = ([0.0; 8], mask.bits());
        lanes.store(&mut numbers);
        let mut least = (u32::MAX, 0);
        for (lane, number) in numbers.iter().enumerate() {
            if bits >> lane & 1 != 0 {
                // Nonnegative floats are ordered like their bits.
                least = least.min((number.to_bits(), lane));
            }
        }
        least.1
    }

    /// Transposes four rows of four values.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f32; 4]; 4]);
    /// impl WithSimd for Turn {
    ///     type Output = [f32; 4];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f32; 4] {
    ///         let [a, b, c, d] = &self.0;
    ///         let load = S::F32x4::load;
    ///         let mut first = [0.0; 4];
    ///         S::transpose([load(a), load(b), load(c), load(d)])[0].store(&mut first);
    ///         first
    ///     }
    /// }
    /// let row = |x| [x, 0.0, 0.0, 0.0];
    /// assert_eq!(dispatch(Turn([row(1.0), row(2.0), row(3.0), row(4.0)])), [1.0, 2.0, 3.0, 4.0]);
    /// ```
    #[inline(always)]
    fn transpose(rows: [Self::F32x4; 4]) -> [Self::F32x4; 4] {
        let mut numbers = [[0.0; 4]; 4];
        for (row, to) in rows.into_iter().zip(&mut numbers) {
            row.store(to);
        }
        let [a, b, c, d] = numbers;
        let column = |k: usize| Self::F32x4::load(&[a[k], b[k], c[k], d[k]]);
        [column(0), column(1), column(2), column(3)]
    }

    /// Transposes sixteen rows of four values. `row` returns a row by its index.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f32; 4]; 16]);
    /// impl WithSimd for Turn {
    ///     type Output = [f32; 16];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f32; 16] {
    ///         let mut second = [0.0; 16];
    ///         S::columns(|i| &self.0[i])[1].store(&mut second);
    ///         second
    ///     }
    /// }
    /// let rows = core::array::from_fn(|i| [0.0, i as f32, 0.0, 0.0]);
    /// assert_eq!(dispatch(Turn(rows)), core::array::from_fn(|i| i as f32));
    /// ```
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x16; 4] {
        let mut columns = [[0.0; 16]; 4];
        for i in 0..16 {
            for (column, number) in columns.iter_mut().zip(row(i)) {
                column[i] = *number;
            }
        }
        let [a, b, c, d] = &columns;
        [Lanes::load(a), Lanes::load(b), Lanes::load(c), Lanes::load(d)]
    }

    /// Transposes one row of four values per lane of a register. `row` returns a row by its index.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f32; 4]; 16]);
    /// impl WithSimd for Turn {
    ///     type Output = bool;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> bool {
    ///         let mut second = [0.0; 16];
    ///         S::register_columns(|i| &self.0[i])[1].store(&mut second);
    ///         let lanes = S::F32s::N;
    ///         second[..lanes] == self.0.map(|row| row[1])[..lanes]
    ///     }
    /// }
    /// assert!(dispatch(Turn(core::array::from_fn(|i| [0.0, i as f32, 0.0, 0.0]))));
    /// ```
    #[inline(always)]
    fn register_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32s; 4] {
        let mut columns = [[0.0; 16]; 4];
        for i in 0..Self::F32s::N {
            for (column, number) in columns.iter_mut().zip(row(i)) {
                column[i] = *number;
            }
        }
        let [a, b, c, d] = &columns;
        [Lanes::load(a), Lanes::load(b), Lanes::load(c), Lanes::load(d)]
    }

    /// Loads eight lanes from one array and eight from another.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Both([[f32; 8]; 2]);
    /// impl WithSimd for Both {
    ///     type Output = [f32; 16];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f32; 16] {
    ///         let mut both = [0.0; 16];
    ///         S::halves(&self.0[0], &self.0[1]).store(&mut both);
    ///         both
    ///     }
    /// }
    /// let both = dispatch(Both([[1.0; 8], [2.0; 8]]));
    /// assert_eq!((both[..8].iter().sum(), both[8..].iter().sum()), (8.0, 16.0));
    /// ```
    #[inline(always)]
    fn halves(first: &[f32; 8], last: &[f32; 8]) -> Self::F32x16 {
        let mut both = [0.0; 16];
        both[..8].copy_from_slice(first);
        both[8..].copy_from_slice(last);
        Lanes::load(&both)
    }

    /// Like [`Simd::transpose`], but for f64.
    ///
    /// ```
    /// use intertri::simd::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f64; 4]; 4]);
    /// impl WithSimd for Turn {
    ///     type Output = [[f64; 4]; 2];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         let [a, b, c, d] = &self.0;
    ///         let load = S::F64x4::load;
    ///         let [_, second, ..] = S::transpose_f64([load(a), load(b), load(c), load(d)]);
    ///         let mut out = [[0.0; 4]; 2];
    ///         second.store(&mut out[0]);
    ///         S::first_and_last(second).store(&mut out[1]);
    ///         out
    ///     }
    /// }
    /// let row = |x| [0.0, x, 0.0, 0.0];
    /// let [second, ends] = dispatch(Turn([row(1.0), row(2.0), row(3.0), row(4.0)]));
    /// assert_eq!((second, ends), ([1.0, 2.0, 3.0, 4.0], [1.0, 4.0, 4.0, 4.0]));
    /// ```
    #[inline(always)]
    fn transpose_f64(rows: [Self::F64x4; 4]) -> [Self::F64x4; 4] {
        let mut numbers = [[0.0; 4]; 4];
        for (row, to) in rows.into_iter().zip(&mut numbers) {
            row.store(to);
        }
        let [a, b, c, d] = numbers;
        let column = |k: usize| Self::F64x4::load(&[a[k], b[k], c[k], d[k]]);
        [column(0), column(1), column(2), column(3)]
    }

    /// Returns the first lane, followed by three copies of the last lane.
    #[inline(always)]
    fn first_and_last(lanes: Self::F64x4) -> Self::F64x4 {
        let mut numbers = [0.0; 4];
        lanes.store(&mut numbers);
        let [first, .., last] = numbers;
        Self::F64x4::load(&[first, last, last, last])
    }
}

/// Regroups lanes that hold four values for each of eight triangles, so that the values of each
/// triangle are together.
#[inline(always)]
pub(crate) fn by_triangle<S: Simd>(numbers: [S::F64x8; 4]) -> [[S::F64x4; 4]; 2] {
    let mut rows = [[0.0; 8]; 4];
    // Store eight lanes to memory and load them as two halves of four, because transpositions work
    // on 4×4 blocks.
    for (lanes, row) in numbers.into_iter().zip(&mut rows) {
        lanes.store(row);
    }
    let [a, b, c, d] = &rows;
    let load = S::F64x4::load;
    [
        S::transpose_f64([load(a), load(b), load(c), load(d)]),
        S::transpose_f64([load(&a[4..]), load(&b[4..]), load(&c[4..]), load(&d[4..])]),
    ]
}

/// Writes four vectors for each of eight triangles to the triangles' rows, axis by axis.
#[inline(always)]
pub(crate) fn put_by_triangle<'a, S: Simd>(
    [a, b, c, d]: [Vec3<S::F64x8>; 4],
    to: impl Iterator<Item = &'a mut [[f64; 4]; 3]>,
) {
    let axes = [
        by_triangle::<S>([a.x, b.x, c.x, d.x]),
        by_triangle::<S>([a.y, b.y, c.y, d.y]),
        by_triangle::<S>([a.z, b.z, c.z, d.z]),
    ];
    for (i, to) in to.enumerate() {
        for (rows, to) in axes.iter().zip(to) {
            // The first four triangles are in the first half. A row holds one component of each of
            // the four vectors.
            rows[i / 4][i % 4].store(to);
        }
    }
}
