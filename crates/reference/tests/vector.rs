//! Tests that the operators round in the order written and that the square root matches IEEE 754.

use intertri_reference::Vector;
use intertri_reference::vector::sqrt;

#[test]
fn operators_are_the_documents() {
    let (a, b) = (Vector::new(1.0, 2.0, 3.0), Vector::new(-4.0, 5.0, 6.5));
    assert_eq!(a & b, 25.5);
    assert_eq!(a ^ b, Vector::new(-2.0, -18.5, 13.0));
    assert_eq!(b ^ a, Vector::new(2.0, 18.5, -13.0));
    assert_eq!(a + b, Vector::new(-3.0, 7.0, 9.5));
    assert_eq!(a - b, Vector::new(5.0, -3.0, -3.5));
    assert_eq!(a * 2.0, Vector::new(2.0, 4.0, 6.0));
    assert_eq!(Vector::from([1.0f32, 2.0, 3.0]), Vector::from([1.0f64, 2.0, 3.0]));
    assert_eq!(<[f64; 3]>::from(a), [1.0, 2.0, 3.0]);
}

#[test]
fn dot_is_summed_from_left_to_right_without_fusing() {
    let a = Vector::new(1.0, 1e16, -1e16);
    assert_eq!(a & Vector::new(1.0, 1.0, 1.0), 0.0, "not 1: the 1 is lost in 1e16 first");
    // The square of 1 + 2^-30 contains the term 2^-60, which rounding drops but a fused operation
    // would keep.
    let e = 1.0 + f64::powi(2.0, -30);
    assert_eq!(Vector::new(-(e * e), e, 0.0) & Vector::new(1.0, e, 0.0), 0.0);
    assert_eq!((Vector::new(e, e, 0.0) ^ Vector::new(e, e, 0.0)).z, 0.0);
}

#[test]
fn unit_vectors_at_the_ends_of_the_range() {
    let z = Vector::new(0.0, 0.0, 1.0);
    assert_eq!(Vector::new(0.0, 0.0, 7.0).unit(), z);
    assert_eq!(Vector::new(0.0, 0.0, 1e150).unit(), z);
    assert_eq!(Vector::new(0.0, 0.0, 1e-150).unit(), z);
    assert_eq!(Vector::default().unit(), Vector::default());
    assert_eq!(Vector::new(0.0, 1e-170, 0.0).unit(), Vector::new(0.0, 1e-170, 0.0));
    assert_eq!(Vector::new(0.0, 1e170, 0.0).unit(), Vector::default());
    let infinite = Vector::new(f64::INFINITY, 1.0, 0.0).unit();
    assert!(infinite.x.is_nan() && infinite.y == 0.0);
    let nan = Vector::new(f64::NAN, 1.0, 0.0).unit();
    assert!(nan.x.is_nan() && nan.y.is_nan() && nan.z.is_nan());
}

#[track_caller]
fn check_sqrt(x: f64) {
    let (ours, std) = (sqrt(x), x.sqrt());
    // The sign and payload of a NaN are unspecified.
    assert!(
        ours.to_bits() == std.to_bits() || (ours.is_nan() && std.is_nan()),
        "sqrt({x:e}) is {ours:e}, not {std:e}"
    );
}

#[test]
fn sqrt_of_special_values() {
    for x in [0.0, 1.0, 2.0, 4.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, f64::INFINITY, f64::NAN] {
        check_sqrt(x);
        check_sqrt(-x);
    }
    assert!(sqrt(-0.0).is_sign_negative());
}

#[test]
fn sqrt_of_random_bits_and_around_squares() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    for _ in 0..1_000_000 {
        let bits = random();
        // Any f64, and a subnormal number.
        check_sqrt(f64::from_bits(bits));
        check_sqrt(f64::from_bits(bits >> 12));
        // Squares and their neighbours, where rounding is hardest.
        let root = f64::from_bits(bits >> 12 | 1023 << 52);
        let square = (root * root).to_bits();
        for neighbour in square - 1..=square + 1 {
            check_sqrt(f64::from_bits(neighbour));
        }
    }
    // Test mantissas with all bits set, for which rounding may carry, and with no bits set, at
    // every exponent.
    for exponent in 0..2047_u64 {
        check_sqrt(f64::from_bits((exponent << 52) | ((1 << 52) - 1)));
        check_sqrt(f64::from_bits(exponent << 52));
    }
}
