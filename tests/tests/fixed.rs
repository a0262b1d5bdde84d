//! The mode `fixed`: against its scalar i128 reference and rationals, on closed meshes, and its golden hash.

mod bundles;
mod golden;
mod hierarchy;
mod meshes;
mod rationals;
mod scalar;
mod solids;

/// A generator of numbers, the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    /// `0..n`
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// `-limit..=limit`
    fn within(&mut self, limit: i32) -> i32 {
        (self.below(2 * limit as u64 + 1) as i64 - i64::from(limit)) as i32
    }

    fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len() as u64) as usize]
    }

    fn vector(&mut self, limit: i32) -> [i32; 3] {
        [(); 3].map(|()| self.within(limit))
    }
}

fn sub(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn add(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
