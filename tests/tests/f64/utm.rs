//! Tests rays that leave a wall at UTM coordinates (mikedh/trimesh#48). A tracer that rounds
//! coordinates to f32 hits the wall again.

use intertri::{Ray64, Triangle64};
use intertri_trace::Bvh;

/// Returns a room at UTM coordinates whose walls are not axis-aligned.
fn room() -> Vec<Triangle64> {
    let corner = |i: usize| {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f64);
        let (x, y) = (4.1 * x, 3.7 * y);
        [148_376.213 + 0.8 * x - 0.6 * y, 528_980.447 + 0.6 * x + 0.8 * y, 31.02 + 2.6 * z]
    };
    // The corners of each face are in counter-clockwise order as seen from outside.
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    faces.into_iter().flat_map(halves).map(|t| Triangle64(t.map(corner))).collect()
}

/// Returns a point inside a triangle, in f64, and the triangle's unit normal.
fn point(triangle: &Triangle64) -> ([f64; 3], [f64; 3]) {
    let [a, b, c] = triangle.0;
    let n = triangle.normal();
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    ([0, 1, 2].map(|k| 0.3 * a[k] + 0.3 * b[k] + 0.4 * c[k]), n.map(|x| x / length))
}

#[test]
fn a_ray_that_leaves_a_wall_does_not_hit_it() {
    let walls = room();
    let bvh = Bvh::new(&walls).unwrap();
    let mut rays = vec![];
    for (i, wall) in walls.iter().enumerate() {
        let (on, n) = point(wall);
        for exponent in 1..=9 {
            // Start 10 cm to 1 nm from the wall, on both sides, and go outward and inward, straight
            // and at a slant.
            for side in [1.0, -1.0] {
                let off = side * 10.0_f64.powi(-exponent);
                let origin = [0, 1, 2].map(|k| on[k] + off * n[k]);
                for (out, slant) in [(1.0, 0.0), (-1.0, 0.0), (1.0, 0.7), (-1.0, 0.7)] {
                    let dir = [out * n[0] - slant * n[1], out * n[1] + slant * n[0], out * n[2]];
                    rays.push((i, side, out, exponent, Ray64::new(origin, dir)));
                }
            }
        }
    }
    let all: Vec<Ray64> = rays.iter().map(|ray| ray.4).collect();
    let hits = bvh.closest_batch(&all);
    for (&(wall, side, out, exponent, ray), hit) in rays.iter().zip(&hits) {
        let what = format!("wall {wall}, side {side}, out {out}, 1e-{exponent} m: {hit:?}");
        assert_eq!(bvh.closest(&ray), hit.some(), "{what}");
        // A ray that starts outside and goes outward hits nothing. A ray toward the wall hits the
        // wall first, at the distance between the ray's origin and the wall.
        let toward = side != out;
        assert_eq!(bvh.any(&ray), toward || side < 0.0, "{what}");
        if toward {
            // The hit may be on the other half of the wall's face.
            assert_eq!(hit.triangle as usize / 2, wall / 2, "{what}");
            let want = 10.0_f64.powi(-exponent);
            assert!((hit.t - want).abs() < 5e-10 + 1e-6 * want, "{what}");
        } else if side < 0.0 {
            // The ray crosses the room and hits another wall.
            assert!(hit.is_hit() && hit.triangle as usize / 2 != wall / 2, "{what}");
        } else {
            assert_eq!(hit.some(), None, "{what}");
        }
    }
}
