//! Compares every operation of every lane type with scalar arithmetic, bit for bit.

use super::{Ints, Lanes, Level, Simd, WithSimd};

const NUMBERS: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e-45,
    3.4e38,
    -3.4e38,
    0.1,
    -0.3,
    1e-20,
    7.0,
    1e20,
    -1e-42,
];

/// Checks the lane types of one scalar type. Over the sixteen turns, each lane's value is paired
/// with every entry of `NUMBERS`.
macro_rules! check {
    ($name:ident, $scalar:ty) => {
        mod $name {
            use super::super::{Lanes, Level, Mask};
            use super::NUMBERS;

            type Sixteen = [$scalar; 16];

            pub(super) fn all<L: Lanes<Scalar = $scalar>>(level: Level) {
                let a = NUMBERS.map(|x| x as $scalar);
                for turn in 0..16 {
                    let b: Sixteen = core::array::from_fn(|i| a[(i + turn) % 16]);
                    arithmetic::<L>(level, &a, &b);
                    order::<L>(level, &a, &b);
                    masks::<L>(level, turn as u32);
                    products::<L>(level, &a, &b);
                }
                conversion::<L>(level);
            }

            fn stored<L: Lanes<Scalar = $scalar>>(lanes: L) -> Sixteen {
                let mut out = [0.0; 16];
                lanes.store(&mut out);
                out
            }

            fn arithmetic<L: Lanes<Scalar = $scalar>>(level: Level, a: &Sixteen, b: &Sixteen) {
                let (la, lb) = (L::load(a), L::load(b));
                let same = |what: &str, lanes: L, plain: &dyn Fn($scalar, $scalar) -> $scalar| {
                    for (i, &out) in stored(lanes)[..L::N].iter().enumerate() {
                        let (x, y) = (a[i], b[i]);
                        let want = plain(x, y);
                        let equal =
                            out.to_bits() == want.to_bits() || (out.is_nan() && want.is_nan());
                        assert!(equal, "{level:?} {what}({x}, {y}) = {out}, not {want}");
                    }
                };
                same("add", la + lb, &|x, y| x + y);
                same("sub", la - lb, &|x, y| x - y);
                same("mul", la * lb, &|x, y| x * y);
                same("div", la / lb, &|x, y| x / y);
                same("neg", -la, &|x, _| -x);
                same("abs", la.abs(), &|x, _| x.abs());
                same("power", la.power(), &|x, _| x.power());
                same("sqrt", la.abs().sqrt(), &|x, _| x.abs().sqrt());
                same("flip", la.flip(lb), &|x, y| if y.is_sign_negative() { -x } else { x });
                same("select", L::select(la.lt(lb), la, lb), &|x, y| if x < y { x } else { y });
                let signs = la.or_sign(lb).negative().bits();
                for i in 0..L::N {
                    // If an operand is a zero or a NaN, `or_sign` may return either sign.
                    let (x, y) = (a[i], b[i]);
                    if !x.is_nan() && !y.is_nan() && x != 0.0 && y != 0.0 {
                        let (is, want) = (signs >> i & 1 != 0, x < 0.0 || y < 0.0);
                        assert!(is == want, "{level:?} negative({x} or {y}) = {is}");
                    }
                }
            }

            fn order<L: Lanes<Scalar = $scalar>>(level: Level, a: &Sixteen, b: &Sixteen) {
                let (la, lb) = (L::load(a), L::load(b));
                let ordered = |lanes: L, plain: &dyn Fn($scalar, $scalar) -> $scalar| {
                    let out = stored(lanes);
                    for i in 0..L::N {
                        if !a[i].is_nan() && !b[i].is_nan() {
                            assert!(out[i] == plain(a[i], b[i]), "{level:?}");
                        }
                    }
                };
                ordered(la.max(lb), &|x, y| x.max(y));
                ordered(la.min(lb), &|x, y| x.min(y));

                let bits = |plain: &dyn Fn($scalar, $scalar) -> bool| {
                    (0..L::N).fold(0, |m, i| m | (plain(a[i], b[i]) as u32) << i)
                };
                assert_eq!(la.lt(lb).bits(), bits(&|x, y| x < y), "{level:?}");
                assert_eq!(la.le(lb).bits(), bits(&|x, y| x <= y), "{level:?}");
                assert_eq!(la.gt(lb).bits(), bits(&|x, y| x > y), "{level:?}");
                assert_eq!(la.ge(lb).bits(), bits(&|x, y| x >= y), "{level:?}");
            }

            /// Checks the conversions between bits and masks, and the operators on masks.
            fn masks<L: Lanes<Scalar = $scalar>>(level: Level, turn: u32) {
                let all = (1u32 << L::N) - 1;
                let (m, n) = (0b0110_1001_0011_0101 & all, (turn * 0x1357) & all);
                let (lm, ln) = (L::Mask::from_bits(m), L::Mask::from_bits(n));
                assert_eq!(lm.bits(), m, "{level:?}");
                assert_eq!((lm & ln).bits(), m & n, "{level:?}");
                assert_eq!((lm | ln).bits(), m | n, "{level:?}");
                assert_eq!((!lm).bits(), !m & all, "{level:?}");
                assert_eq!(ln.any(), n != 0, "{level:?}");
                assert_eq!(<L::Mask as Mask>::N, L::N);
            }

            fn products<L: Lanes<Scalar = $scalar>>(level: Level, a: &Sixteen, b: &Sixteen) {
                // A multiply-add may round once or twice.
                let (la, lb) = (L::load(a), L::load(b));
                let out = stored(la.mul_add(lb, L::splat(0.25)));
                for i in 0..L::N {
                    let (once, twice) = (a[i].mul_add(b[i], 0.25), a[i] * b[i] + 0.25);
                    let equal = |x: $scalar| out[i] == x || (out[i].is_nan() && x.is_nan());
                    assert!(equal(once) || equal(twice), "{level:?}");
                }

                // `mul_error` is exact unless an operand is extremely large or small.
                let out = stored(la.mul_error(lb, la * lb));
                for i in 0..L::N {
                    let lacks = a[i].mul_add(b[i], -(a[i] * b[i]));
                    let fair = |x: $scalar| x == 0.0 || (1e-9..1e9).contains(&x.abs());
                    if fair(a[i]) && fair(b[i]) {
                        assert!(out[i] == lacks, "{level:?} {} {} lacks {lacks}", a[i], b[i]);
                    }
                }
            }

            fn conversion<L: Lanes<Scalar = $scalar>>(level: Level) {
                let from: [f32; 16] = NUMBERS.map(|x| x as f32);
                let out = stored(L::load_f32(&from));
                for i in 0..L::N {
                    let want = from[i] as $scalar;
                    assert!(out[i] == want || (out[i].is_nan() && want.is_nan()), "{level:?}");
                }
            }
        }
    };
}
check!(check_f32, f32);
check!(check_f64, f64);

/// Compares integer lanes with wrapping i64 arithmetic.
fn check_i64<L: Ints>(level: Level) {
    let narrow: [i64; 16] = [
        0,
        1,
        -1,
        2,
        -3,
        7,
        1 << 20,
        -(1 << 20),
        0x7fff_ffff,
        -0x8000_0000,
        46341,
        -65536,
        5,
        9,
        -11,
        13,
    ];
    let wide: [i64; 16] = core::array::from_fn(|i| {
        let x = narrow[i].wrapping_mul(0x1_0000_0001 * (i as i64 + 1)) ^ (i as i64) << 40;
        if i % 5 == 0 { -x } else { x }
    });
    for turn in 0..16 {
        let a: [i64; 16] = narrow;
        let b: [i64; 16] = core::array::from_fn(|i| narrow[(i + turn) % 16]);
        let c: [i64; 16] = core::array::from_fn(|i| wide[(i + turn) % 16]);
        let (la, lb, lc) = (L::load(&a), L::load(&b), L::load(&c));
        let same = |lanes: L, plain: &dyn Fn(usize) -> i64| {
            let plain: [i64; 16] = core::array::from_fn(plain);
            assert_eq!((lanes - L::load(&plain)).zero(), (1 << L::N) - 1, "{level:?}");
        };
        same(la + lc, &|i| a[i].wrapping_add(c[i]));
        same(la - lc, &|i| a[i].wrapping_sub(c[i]));
        same(la.times(lb), &|i| a[i] * b[i]);
        same((la + lc).times(lc), &|i| a[i].wrapping_add(c[i]).wrapping_mul(c[i]));
        same(lc.times(lc - lb), &|i| c[i].wrapping_mul(c[i].wrapping_sub(b[i])));
        same(L::splat(c[0]), &|_| c[0]);
        let exponents: [i64; 16] = core::array::from_fn(|i| 9 * ((i + turn) % 16) as i64);
        same(L::shifted(&c, &exponents), &|i| {
            if exponents[i] < 64 { c[i] << exponents[i] } else { 0 }
        });
        let bits =
            |plain: &dyn Fn(i64) -> bool| (0..L::N).fold(0, |m, i| m | (plain(c[i]) as u32) << i);
        assert_eq!(lc.negative(), bits(&|x| x < 0), "{level:?}");
        assert_eq!(lc.zero(), bits(&|x| x == 0), "{level:?}");
    }
}

/// Compares lanes of 128-bit integers with wrapping i128 arithmetic.
fn check_i128<L: Ints>(level: Level) {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        // Short numbers and numbers of both signs.
        (state as i64) >> (state >> 58)
    };
    for _ in 0..20_000 {
        let (mut x, mut plain) = ([L::splat(0); 4], [[0_i128; 8]; 4]);
        for (x, plain) in x.iter_mut().zip(&mut plain) {
            let from: [i64; 8] = core::array::from_fn(|_| random());
            let by: [i64; 8] = core::array::from_fn(|_| random() & 0xff);
            *plain = core::array::from_fn(|i| {
                i128::from(from[i]).checked_shl(by[i] as u32).unwrap_or(0)
            });
            *x = L::shifted(&from, &by);
        }
        let ([a, b, c, d], [pa, pb, pc, pd]) = (x, plain);
        let all =
            |plain: &dyn Fn(usize) -> bool| (0..8).fold(0, |m, i| m | u32::from(plain(i)) << i);
        let product = a.times(b) - c.times(d) + c;
        let of = |i: usize| {
            let (one, other) = (pa[i].wrapping_mul(pb[i]), pc[i].wrapping_mul(pd[i]));
            one.wrapping_sub(other).wrapping_add(pc[i])
        };
        // A number minus its upper half, moved up again, is its lower half: every digit is compared.
        let split = |i: usize| [of(i) as i64, (of(i) >> 64) as i64];
        let low: [i64; 8] = core::array::from_fn(|i| split(i)[0]);
        let high: [i64; 8] = core::array::from_fn(|i| split(i)[1] + i64::from(low[i] < 0));
        let rest = product - L::shifted(&high, &[64; 8]) - L::load(&low);
        assert_eq!(rest.zero(), 0xff, "{level:?}");
        assert_eq!(product.negative(), all(&|i| of(i) < 0), "{level:?}");
        assert_eq!(product.zero(), all(&|i| of(i) == 0), "{level:?}");
        assert_eq!((L::splat(low[0]) - L::load(&[low[0]; 8])).zero(), 0xff, "{level:?}");
        assert_eq!(L::shifted(&[0; 8], &[-2000; 8]).zero(), 0xff, "{level:?}");
    }
}

struct Check;

impl WithSimd for Check {
    type Output = ();
    fn run<S: Simd>(self) {
        check_f32::all::<S::F32x4>(S::LEVEL);
        check_f32::all::<S::F32x8>(S::LEVEL);
        check_f32::all::<S::F32x16>(S::LEVEL);
        check_f64::all::<S::F64x4>(S::LEVEL);
        check_f64::all::<S::F64x8>(S::LEVEL);
        check_i64::<S::I64x8>(S::LEVEL);
        if S::WideInts::BITS == 128 {
            check_i128::<S::WideInts>(S::LEVEL);
        }
        check_f32::all::<f32>(S::LEVEL);
        check_f64::all::<f64>(S::LEVEL);

        let row = |i: usize| S::F32x4::load(&NUMBERS.map(|x| x as f32)[4 * i..]);
        let columns = S::transpose([row(0), row(1), row(2), row(3)]);
        for (k, column) in columns.into_iter().enumerate() {
            let mut numbers = [0.0; 4];
            column.store(&mut numbers);
            for (i, x) in numbers.into_iter().enumerate() {
                assert_eq!(x.to_bits(), (NUMBERS[4 * i + k] as f32).to_bits(), "{:?}", S::LEVEL);
            }
        }

        let (first, last) = ([0, 1, 2, 3, 4, 5, 6, 7].map(|i| i as f32), [9.0; 8]);
        let mut both = [0.0; 16];
        S::halves(&first, &last).store(&mut both);
        assert_eq!((&both[..8], &both[8..]), (&first[..], &last[..]));

        let rows: [[f32; 4]; 16] =
            core::array::from_fn(|i| [0, 1, 2, 3].map(|k| (4 * i + k) as f32));
        for (k, column) in S::columns(|i| &rows[i]).into_iter().enumerate() {
            let mut numbers = [0.0; 16];
            column.store(&mut numbers);
            assert_eq!(numbers, rows.map(|row| row[k]), "{:?}", S::LEVEL);
        }

        let lanes = S::F32s::N;
        for (k, column) in S::register_columns(|i| &rows[i]).into_iter().enumerate() {
            let mut numbers = [0.0; 16];
            column.store(&mut numbers);
            assert_eq!(numbers[..lanes], rows.map(|row| row[k])[..lanes], "{:?}", S::LEVEL);
        }

        // The bytes of a permutation may be arbitrary; only the lowest three bits of each byte
        // count.
        let from: [f32; 8] = core::array::from_fn(|i| NUMBERS[i] as f32);
        for turn in 0..1000_u64 {
            let order = turn.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(turn as u32);
            let mut numbers = [0.0; 8];
            S::permute(S::F32x8::load(&from), order).store(&mut numbers);
            for (x, lane) in numbers.into_iter().zip(order.to_le_bytes()) {
                let want = from[usize::from(lane & 7)];
                assert_eq!(x.to_bits(), want.to_bits(), "{:?} {order:#x}", S::LEVEL);
            }
        }
    }
}

#[test]
fn every_level_computes_as_plain_numbers_do() {
    for level in Level::all() {
        level.run(Check);
        println!("checked {}", level.name());
    }
}
