//! One ray against eight triangles at a time, from a hierarchy of one's own: here a flat one, of boxes
//! around eights. `cargo run --release --example own_hierarchy`

use intertri::{Certified, Hit, Mode, Ray, Triangle, TrianglePack};

struct Leaf {
    low: [f32; 3],
    high: [f32; 3],
    pack: TrianglePack<8>,
}

/// Where the ray is in the box, a little widened for rounding; no hit may be lost.
fn enters(leaf: &Leaf, ray: &Ray) -> bool {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..3 {
        let pad = 1e-6 * leaf.low[k].abs().max(leaf.high[k].abs()).max(ray.origin[k].abs());
        let ends = [leaf.low[k] - pad, leaf.high[k] + pad];
        let t = ends.map(|x| (f64::from(x) - f64::from(ray.origin[k])) / f64::from(ray.dir[k]));
        near = near.max(t[0].min(t[1]));
        far = far.min(t[0].max(t[1]));
    }
    near <= far && far >= 0.0
}

fn main() {
    let height = |x: usize, z: usize| ((x * 7 + z * 3) % 5) as f32 * 0.1;
    let corner = |x: usize, z: usize| [x as f32, height(x, z), z as f32];
    let squares = (0..64).flat_map(|x| (0..64).map(move |z| (x, z)));
    let half = |(x, z)| Triangle([corner(x, z), corner(x + 1, z), corner(x, z + 1)]);
    let triangles: Vec<Triangle> = squares.map(half).collect();
    let leaf = |chunk: &[Triangle]| {
        let bound = |end: fn(f32, f32) -> f32, from: f32| {
            [0, 1, 2].map(|k| chunk.iter().flat_map(|t| t.0).fold(from, |a, p| end(a, p[k])))
        };
        let (low, high) = (bound(f32::min, f32::MAX), bound(f32::max, f32::MIN));
        Leaf { low, high, pack: TrianglePack::new(chunk) }
    };
    let leaves: Vec<Leaf> = triangles.chunks(8).map(leaf).collect();

    let (mode, ray) = (Certified::default(), Ray::new([20.2, 9.0, 3.0], [0.1, -1.0, 0.9]));
    let mut best = (Hit::NOTHING, f64::INFINITY);
    for (i, leaf) in leaves.iter().enumerate().filter(|(_, leaf)| enters(leaf, &ray)) {
        let hits = mode.pack(&ray, &leaf.pack);
        for lane in (0..8).filter(|lane| hits.bits >> lane & 1 == 1) {
            best = if hits.t[lane] < best.1 { ((8 * i + lane) as u64, hits.t[lane]) } else { best };
        }
    }
    let all = mode.closest(&triangles, &ray);
    assert_eq!(best, (all.triangle, all.t));
    println!("{best:?}, as without the hierarchy");
}
