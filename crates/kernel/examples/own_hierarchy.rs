//! Uses the kernel with a hierarchy of your own, and tests a ray against eight triangles at a time:
//! `cargo run --release --example own_hierarchy`. The hierarchy in this example is a flat list of
//! boxes, each of which contains eight triangles.

use intertri::{Hit, Mode, Ray, Triangle, TriangleBlock};

/// The bounding box of a leaf's eight triangles, and the triangles.
struct Leaf([[f32; 3]; 2], TriangleBlock<8>);

impl Leaf {
    fn new(triangles: &[Triangle]) -> Self {
        let end = |of: fn(f32, f32) -> f32, from: f32| {
            [0, 1, 2].map(|k| triangles.iter().flat_map(|t| t.0).fold(from, |a, p| of(a, p[k])))
        };
        Self([end(f32::min, f32::MAX), end(f32::max, f32::MIN)], TriangleBlock::new(triangles))
    }

    /// Returns whether the ray enters the box, which is slightly widened so that rounding does not
    /// lose any hit.
    fn enters(&self, ray: &Ray) -> bool {
        let (mut near, mut far) = (0.0, f64::INFINITY);
        for k in 0..3 {
            let [low, high, from] = [self.0[0][k], self.0[1][k], ray.origin[k]].map(f64::from);
            let pad = 1e-6 * low.abs().max(high.abs()).max(from.abs());
            let t = [low - pad, high + pad].map(|x| (x - from) / f64::from(ray.dir[k]));
            near = t[0].min(t[1]).max(near);
            far = t[0].max(t[1]).min(far);
        }
        near <= far
    }
}

fn main() {
    let corner = |x: usize, z: usize| [x as f32, ((x * 7 + z * 3) % 5) as f32 * 0.1, z as f32];
    let half = |(x, z)| Triangle([corner(x, z), corner(x + 1, z), corner(x, z + 1)]);
    let triangles: Vec<_> = (0..64 * 64).map(|i| half((i / 64, i % 64))).collect();
    let leaves: Vec<_> = triangles.chunks(8).map(Leaf::new).collect();

    let (mode, ray) = (Mode::exact(), Ray::new([20.2, 9.0, 3.0], [0.1, -1.0, 0.9]));
    let mut best = (Hit::NO_TRIANGLE, f64::INFINITY);
    for (i, leaf) in leaves.iter().enumerate().filter(|(_, leaf)| leaf.enters(&ray)) {
        for (lane, t) in mode.block(&ray, &leaf.1).iter() {
            best = if t < best.1 { ((8 * i + lane) as u32, t) } else { best };
        }
    }
    let all = mode.closest(&triangles, &ray);
    assert_eq!(Some(best), all.map(|hit| (hit.triangle, hit.t)));
    println!("{best:?}, the same as without the hierarchy");
}
