//! A random number generator that yields the same bits on every CPU. Its f64 values are computed
//! with only `+ - * /` and square roots.
//!
//! The generator is `SplitMix64` (Steele, Lea, and Flood, "Fast splittable pseudorandom number
//! generators", OOPSLA 2014). It increments a counter by a constant derived from the golden ratio
//! and mixes the counter's bits twice.

/// A stream of random numbers, determined by its seed.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// Creates the stream for a seed. Every seed is suitable, including 0.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Returns an integer in `0..n` (the high half of a product), or 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// Returns an integer in `-n..=n`.
    pub fn within(&mut self, n: i32) -> i32 {
        self.below(2 * n.unsigned_abs() as usize + 1) as i32 - n
    }

    /// Returns true with probability `1 / n`.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// Returns a random element of a list.
    ///
    /// # Panics
    /// Panics if the list is empty.
    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    /// Returns a multiple of 2^-53 in `0..1`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number in `-1..1`.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Returns a point whose coordinates are in `-1..1`.
    pub fn cube(&mut self) -> [f64; 3] {
        [self.signed(), self.signed(), self.signed()]
    }

    /// Returns a random unit vector by normalizing a point in the unit ball.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let [x, y, z] = self.cube();
            let square = x * x + y * y + z * z;
            if 1e-4 < square && square <= 1.0 {
                let length = square.sqrt();
                return [x / length, y / length, z / length];
            }
        }
    }

    /// Returns a number between two bounds whose logarithm is distributed almost uniformly.
    ///
    /// The bounds may be in either order. They must be positive, normal, and finite.
    pub fn log(&mut self, a: f64, b: f64) -> f64 {
        const FRACTION: u64 = (1 << 52) - 1;
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let (from, to) = (low.to_bits() >> 52, high.to_bits() >> 52);
        loop {
            let exponent = from + self.below((to - from) as usize + 1) as u64;
            let x = f64::from_bits(exponent << 52 | self.bits() & FRACTION);
            if (low..=high).contains(&x) {
                return x;
            }
        }
    }
}

/// Moves `x` up or down by a number of f32 steps, across 0 if necessary. Stops at the infinities
/// and returns a NaN unchanged.
///
/// ```
/// assert_eq!(intertri_lab::rng::step(1.0, 1), 1.0_f32.next_up());
/// assert_eq!(intertri_lab::rng::step(0.0, -1), -f32::from_bits(1));
/// ```
pub fn step(x: f32, steps: i32) -> f32 {
    if x.is_nan() {
        return x;
    }
    // Convert sign and magnitude to a signed integer, so that consecutive f32 values become
    // consecutive integers.
    let bits = x.to_bits();
    let magnitude = i64::from(bits & 0x7FFF_FFFF);
    let place = if bits >> 31 == 0 { magnitude } else { -magnitude };
    let infinity = i64::from(f32::INFINITY.to_bits());
    let moved = (place + i64::from(steps)).clamp(-infinity, infinity);
    let magnitude = f32::from_bits(moved.unsigned_abs() as u32);
    // A zero that does not move keeps its sign.
    if moved < 0 || (moved == 0 && bits >> 31 == 1 && steps == 0) { -magnitude } else { magnitude }
}

/// Moves `x` up or down by a number of f64 steps. Stops at the infinities and returns a NaN
/// unchanged.
pub fn step64(mut x: f64, steps: i32) -> f64 {
    for _ in 0..steps.unsigned_abs() {
        x = if steps > 0 { x.next_up() } else { x.next_down() };
    }
    x
}

#[cfg(test)]
mod tests {
    use super::{Rng, step, step64};

    #[test]
    fn the_stream_is_the_published_one() {
        // The first outputs of SplitMix64 for the seed 1234567, as its authors' program prints
        // them.
        let mut rng = Rng::new(1_234_567);
        let first = [rng.bits(), rng.bits(), rng.bits()];
        assert_eq!(
            first,
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

    #[test]
    fn numbers_stay_in_their_ranges_and_fill_them() {
        let mut rng = Rng::new(1);
        let mut seen = [0_u32; 7];
        for _ in 0..7000 {
            seen[(rng.within(3) + 3) as usize] += 1;
            assert!((0.0..1.0).contains(&rng.unit()));
            let x = rng.log(1e30, 1e-30);
            assert!((1e-30..=1e30).contains(&x));
            let [x, y, z] = rng.direction();
            assert!((x * x + y * y + z * z - 1.0).abs() < 1e-15);
        }
        assert!(seen.iter().all(|&n| n > 850), "{seen:?}");
    }

    #[test]
    fn steps_go_through_zero_and_stop_at_the_end() {
        assert_eq!(step(f32::from_bits(2), -4), -f32::from_bits(2));
        assert_eq!(step(f32::MAX, 5), f32::INFINITY);
        assert!(step(-0.0, 0).is_sign_negative());
        assert!(step(f32::NAN, 3).is_nan());
        assert_eq!(step64(1.0, -2), 1.0 - f64::EPSILON);
    }
}
