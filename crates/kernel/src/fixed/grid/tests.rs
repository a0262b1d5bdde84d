//! Tests the grid at its limits.

use super::rays::Snap;
use super::{Bits, Grid, GridError};
use crate::Ray;
use crate::simd::Level;

#[test]
fn the_budgets_are_kept() {
    for b in 0..30 {
        for q in 0..70 {
            let inside = (1..=20).contains(&b) && (1..=24).contains(&q) && 2 * b + q <= 58;
            assert_eq!(Bits::new(b, q).is_ok(), inside, "{b} {q}");
        }
        assert_eq!(Bits::of_grid(b).is_ok(), (1..=20).contains(&b), "{b}");
    }
    assert_eq!(Bits::of_grid(u32::MAX), Err(GridError::Bits { b: u32::MAX, q: 1 }));
}

/// Returns a generator of random 64-bit integers.
fn numbers() -> impl FnMut() -> u64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    }
}

#[test]
fn snapping_rounds_once_and_a_second_time_changes_nothing() {
    let mut next = numbers();
    for _ in 0..20_000 {
        // A box of any size at any position, with points inside it and at its corners.
        let size = f32::from_bits((next() % (250 << 23)) as u32);
        let middle = f32::from_bits((next() % (250 << 23)) as u32);
        let points: [[f32; 3]; 6] = core::array::from_fn(|_| {
            [(); 3].map(|()| middle + size * ((next() >> 40) as f32 / 8_388_608.0 - 1.0))
        });
        let b = 1 + (next() % 20) as u32;
        let Ok(grid) = Grid::around(points, Bits::of_grid(b).unwrap()) else {
            assert!(points.iter().flatten().any(|x| !x.is_finite()));
            continue;
        };
        for p in points {
            let i = grid.snap(p).unwrap();
            let back = grid.unsnap(i);
            assert!(grid.moved(p).unwrap() <= grid.step() / 2.0, "{p:?}");
            let f = back.map(|x| x as f32);
            assert_eq!(f.map(f64::from), back, "a snapped point must be exact in f32");
            assert_eq!(grid.snap(f).unwrap(), i, "{p:?} moves when snapped again");
        }
        // Also test a direction.
        let dir = [(); 3].map(|()| f32::from_bits(next() as u32));
        if let Ok(ray) = grid.ray(&Ray::new(points[0], dir)) {
            let q = grid.bits().q();
            let longest = ray.dir().map(i32::unsigned_abs).into_iter().max().unwrap();
            assert!(longest >= 1 << (q - 1) && longest < 1 << q, "{dir:?} {:?}", ray.dir());
            let k = ray.exponent() + grid.scale();
            let back = ray.dir().map(|x| f64::from(x) * 0.5_f64.powi(k));
            let far = dir.map(f32::abs).into_iter().fold(0.0, f32::max);
            for axis in 0..3 {
                let moved = (back[axis] - f64::from(dir[axis])).abs();
                assert!(moved <= f64::from(far) * 0.5_f64.powi(q as i32), "{dir:?}");
            }
            let again = back.map(|x| x as f32);
            assert_eq!(again.map(f64::from), back, "a snapped direction must be exact in f32");
            assert_eq!(ray.to_f32().dir, ray.dir().map(|x| x as f32), "must not contain -0");
            let again = grid.ray(&Ray::new(points[0], again)).unwrap();
            assert_eq!(again, ray, "{dir:?} turns when snapped again");
        }
    }
}

#[test]
fn the_grid_is_the_finest() {
    let grid = Grid::around([[0.0; 3], [1.0, 0.25, 0.0]], Bits::FINE).unwrap();
    assert_eq!(grid.step(), 0.5_f64.powi(21));
    assert_eq!(grid.snap([0.0; 3]).unwrap()[0], -(1 << 20));
    assert_eq!(grid.snap([1.0, 0.0, 0.0]).unwrap()[0], 1 << 20);
    // A point one step farther out does not fit.
    assert!(grid.snap([1.0 + f32::EPSILON * 4.0, 0.0, 0.0]).is_err());
}

#[test]
fn what_does_not_fit_is_an_error_by_value() {
    let grid = Grid::at(Bits::COARSE, 0, [0; 3]).unwrap();
    let edge = 65536.0;
    assert_eq!(grid.snap([edge, -edge, 0.4]).unwrap(), [65536, -65536, 0]);
    for bad in [65537.0, -65537.0, 65536.6, 1e20, f32::MAX, -f32::MAX] {
        for axis in 0..3 {
            let mut p = [0.0; 3];
            p[axis] = bad;
            assert_eq!(grid.snap(p), Err(GridError::Outside(p)));
        }
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut p = [0.0; 3];
            p[axis] = bad;
            assert!(matches!(grid.snap(p), Err(GridError::NotFinite(_))));
            assert!(matches!(Grid::around([p], Bits::FINE), Err(GridError::NotFinite(_))));
            let ray = Ray::new([0.0; 3], [1.0, 1.0, 1.0]);
            assert!(matches!(grid.ray(&Ray { origin: p, ..ray }), Err(GridError::NotFinite(_))));
            assert!(matches!(grid.ray(&Ray { dir: p, ..ray }), Err(GridError::Direction(_))));
        }
    }
    assert!(matches!(grid.ray(&Ray::new([0.0; 3], [0.0; 3])), Err(GridError::Direction(_))));
    assert!(grid.ray_of([0; 3], [0; 3]).is_err());
    assert!(grid.ray_of([i32::MIN, 0, 0], [1; 3]).is_err());
    assert!(grid.ray_of([0; 3], [0, i32::MIN, 0]).is_err());
    assert!(grid.triangle_of([[0; 3], [0; 3], [0, 0, 65537]]).is_err());
    assert!(Grid::at(Bits::FINE, 150, [0; 3]).is_err());
    assert!(Grid::at(Bits::FINE, 0, [0, i64::MIN, 0]).is_err());
    // Test a grid around no points, then one around the origin alone.
    assert!(Grid::around([], Bits::FINE).is_ok());
    assert!(Grid::around([[-0.0; 3]], Bits::FINE).unwrap().snap([0.0; 3]).is_ok());
}

#[test]
fn a_direction_that_rounds_up_to_a_power_of_two_stays_where_it_is() {
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    // The other components are odd at 18 bits, so halving them rounds.
    let dir = [1.0_f32.next_down(), 3.0 / 262_144.0, -77_777.0 / 262_144.0];
    let ray = grid.ray(&Ray::new([0.0; 3], dir)).unwrap();
    assert_eq!(ray.dir(), [1 << 17, 2, -38_888]);
    let k = ray.exponent() + grid.scale();
    let again = ray.dir().map(|x| (f64::from(x) * 0.5_f64.powi(k)) as f32);
    assert_eq!(grid.ray(&Ray::new([0.0; 3], again)).unwrap(), ray);
}

/// Tests directions and interval ends of any magnitude, components halfway between two integers,
/// and invalid directions. The result must have the same bits at all levels.
#[test]
fn rays_are_snapped_alike_at_every_level() {
    let mut state = 7_u64;
    let mut bits = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
        f32::from_bits((state >> 32) as u32)
    };
    let mut rays: Vec<Ray> = (0..20_000)
        .map(|i| {
            let near = |x: f32| 1.0 + x % 1.0;
            let any = [bits(), bits(), bits()];
            let dir = if i % 2 == 0 { any } else { any.map(near) };
            Ray::new([(i / 100) as f32, 0.5, -3.0], dir).between(bits(), bits())
        })
        .collect();
    // Ties: scaled to 18 bits, these components end in a half.
    rays.push(Ray::new([0.0; 3], [131_073.0, 0.5, -1.5]));
    for (b, scale) in [(20, 0), (17, 3), (16, -140), (4, 149)] {
        let grid = Grid::at(Bits::of_grid(b).unwrap(), scale, [0; 3]).unwrap();
        let nothing = grid.ray_of([0; 3], [1, 0, 0]).unwrap();
        let mut first = None;
        for level in Level::all() {
            let (mut snapped, mut wrong) = (vec![nothing; rays.len()], 0);
            let otherwise = |_, _| {
                wrong += 1;
                nothing
            };
            level.run(Snap { grid: &grid, rays: &rays, snapped: &mut snapped, otherwise });
            for (ray, from) in snapped.iter().zip(&rays).filter(|(ray, _)| **ray != nothing) {
                // Compare the ends if a crossing is possible there.
                let ends = ray.between(from.t_min, from.t_max);
                let [a, b] = [ray, &ends].map(|ray| [ray.to_f32().t_min, ray.to_f32().t_max]);
                for (a, b) in a.into_iter().zip(b) {
                    assert!(a == b || !(1e-19..=1.9e19).contains(&b), "{from:?} {a} {b}");
                }
            }
            let bits: Vec<[u32; 8]> =
                snapped.iter().map(|ray| bytemuck::cast(*ray.to_f32())).collect();
            let answer = (bits, wrong);
            assert_eq!(
                first.get_or_insert_with(|| answer.clone()),
                &answer,
                "{level:?} {b} {scale}"
            );
        }
    }
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    assert_eq!(grid.ray(&rays[20_000]).unwrap().dir(), [131_073, 0, -2]);
    // A direction whose longest component already uses all 18 bits does not change, unless that
    // component would round up to 19 bits.
    let snapped = |dir: [f32; 3]| grid.ray(&Ray::new([0.0; 3], dir)).unwrap().dir();
    assert_eq!(snapped([3.0, -262_143.0, 1.0]), [3, -262_143, 1]);
    assert_eq!(snapped([262_143.5, 4.0, -8.0]), [131_072, 2, -4]);
    assert_eq!(snapped([262_143.47, 4.0, -8.0]), [262_143, 4, -8]);
}
