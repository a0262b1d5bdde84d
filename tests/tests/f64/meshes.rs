//! Traces rays toward corners and edges of closed f64 meshes through a hierarchy. Some meshes are
//! far from the coordinate origin. The signed crossings must add up to the winding number of the
//! ray's origin.

use intertri::{Ray64, Triangle64};
use intertri_lab::rng::Rng;
use intertri_trace::Bvh;

/// A closed mesh around a centre. `inner` and `outer` bound the distance of its surface from the
/// centre.
struct Ball {
    triangles: Vec<Triangle64>,
    centre: [f64; 3],
    inner: f64,
    outer: f64,
}

/// Returns a bumpy ball with the given number of rings. If it is on a grid, the differences between
/// corners are exact, and so are the directions of rays toward them.
fn ball(rings: usize, size: f64, centre: [f64; 3], on_grid: bool) -> Ball {
    let sectors = 2 * rings;
    let at = |ring: usize, sector: usize| {
        let bump =
            1.0 + 0.1 * f64::from(u8::from((ring * 7 + sector % sectors * 3).is_multiple_of(5)));
        let (polar, around) = (
            ring as f64 / rings as f64 * std::f64::consts::PI,
            (sector % sectors) as f64 / sectors as f64 * std::f64::consts::TAU,
        );
        // All sectors share one corner at each pole.
        let (r, bump) = if ring.is_multiple_of(rings) { (0.0, 1.0) } else { (polar.sin(), bump) };
        let v = [r * around.cos(), r * around.sin(), polar.cos()].map(|x| x * bump);
        [0, 1, 2].map(|k| {
            let x = if on_grid { (v[k] * 1024.0).round() / 1024.0 } else { v[k] };
            centre[k] + x * size
        })
    };
    let mut triangles = vec![];
    for ring in 0..rings {
        for sector in 0..sectors {
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector), at(ring + 1, sector + 1));
            if ring > 0 {
                triangles.push(Triangle64([a, c, b]));
            }
            if ring + 1 < rings {
                triangles.push(Triangle64([b, c, d]));
            }
        }
    }
    Ball { triangles, centre, inner: 0.8 * size, outer: 1.2 * size }
}

/// Generates directions from a point: exactly or nearly toward corners and edges, into triangles,
/// along axes, and at random.
fn directions(ball: &Ball, origin: [f64; 3], rng: &mut Rng) -> Vec<[f64; 3]> {
    let to = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - origin[k]);
    let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] + b[k]);
    let mut all = vec![];
    for _ in 0..40 {
        let [a, b, c] = rng.pick(&ball.triangles).0.map(to);
        all.extend([a, sum(a, b), sum(sum(a, b), c), a.map(|x| -x)]);
        all.push(rng.direction());
    }
    for axis in 0..6 {
        let mut dir = [0.0; 3];
        dir[axis % 3] = if axis < 3 { 1.0 } else { -1e-300 };
        all.push(dir);
    }
    all
}

#[test]
fn signed_crossings_are_the_winding_number() {
    let (mut rng, mut inside) = (Rng::new(40), 0);
    let places = [
        (1.0, [0.0; 3]),
        (1.0, [1_048_576.0, -524_288.0, 262_144.0]),
        (1024.0, [1e12, 1e12, -1e12]),
        (2.0_f64.powi(-1000), [0.0; 3]),
        (2.0_f64.powi(900), [0.0; 3]),
        (0.7, [148_376.213, 528_980.447, 31.02]),
    ];
    for (size, centre) in places {
        for on_grid in [true, false] {
            let ball = ball(16, size, centre, on_grid);
            let bvh = Bvh::new(&ball.triangles).unwrap();
            for i in 0..8 {
                let away = if i % 2 == 0 { 0.5 * ball.inner } else { 1.5 * ball.outer };
                let way = rng.direction().map(|x| (x * 64.0).round() / 64.0);
                let origin = [0, 1, 2].map(|k| ball.centre[k] + away * way[k]);
                let winding = i64::from(i % 2 == 0);
                let rays: Vec<Ray64> = directions(&ball, origin, &mut rng)
                    .into_iter()
                    .map(|dir| Ray64::new(origin, dir))
                    .collect();
                let counts = bvh.query().count_crossings_batch(&rays);
                let (any, hits) = (bvh.any_batch(&rays), bvh.closest_batch(&rays));
                for (k, ray) in rays.iter().enumerate() {
                    let what = format!("{size:e} {centre:?} {on_grid} {ray:?}");
                    assert_eq!(counts[k].signed, winding, "{what}");
                    assert!(winding == 0 || any[k], "{what} leaks");
                    assert_eq!(any[k], hits[k].is_hit(), "{what}");
                    inside += usize::from(winding == 1);
                }
            }
        }
    }
    assert!(inside > 5000, "{inside}");
}
