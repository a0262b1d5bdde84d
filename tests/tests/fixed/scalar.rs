//! Compares every form, width and level of the `fixed` kernels with the scalar reference, for
//! integers at the limits of the bit budgets.

use intertri::fixed::{Bits, Grid, Ray, Triangle};
use intertri_tests::check_crossings;

use super::{Numbers, add, sub};

/// Generates a coordinate or a direction component within `limit`, in one of several styles.
fn component(n: &mut Numbers, style: u64, limit: i32) -> i32 {
    match style {
        0 => n.one_of(&[limit, -limit, limit - 1, 1 - limit, 0]),
        1 => n.within(limit),
        2 => n.within(limit.min(3)),
        3 => n.one_of(&[limit, -limit, 0, 1, -1]),
        _ => limit - n.below(5.min(limit as u64)) as i32,
    }
}

/// Generates eight rays and eight triangles.
fn pairs(n: &mut Numbers) -> ([Ray; 8], [Triangle; 8]) {
    let (b, q) = n.one_of(&[(20, 18), (20, 18), (19, 20), (17, 24), (16, 16), (3, 2), (1, 1)]);
    let grid = Grid::at(Bits::new(b, q).unwrap(), 0, [0; 3]).unwrap();
    let (far, long) = (1 << b, 1 << q);
    let clip = |p: [i32; 3]| p.map(|x| x.clamp(-far, far));

    // The triangles are at the limits, arbitrary, or small and close to a point that many of them
    // share as a corner.
    let style = n.below(7);
    let middle = [(); 3].map(|()| component(n, style % 5, far));
    let triangles: [[[i32; 3]; 3]; 8] = core::array::from_fn(|_| {
        let reach = n.one_of(&[1, 2, 1000]);
        let mut corner = || match style {
            5 => clip(add(middle, n.vector(reach))),
            6 => n.one_of(&[middle, [far; 3], [-far; 3], [0; 3]]),
            _ => [(); 3].map(|()| component(n, style, far)),
        };
        let mut corners = [corner(), corner(), corner()];
        if style == 5 && n.below(2) == 0 {
            corners[n.below(3) as usize] = middle;
        }
        corners
    });

    // The rays are arbitrary, go exactly toward a corner or an edge midpoint, or run along a plane.
    let shared = n.below(2) == 0;
    let common = [(); 3].map(|()| component(n, n.0 % 5, far));
    let rays = core::array::from_fn(|_| {
        let style = n.below(5);
        let mut origin = common;
        let mut dir = [(); 3].map(|()| component(n, style, long));
        let [c1, c2, c3] = n.one_of(&triangles);
        let target = n.one_of(&[c1, c2, c3]);
        if shared {
            // Aim at a corner, if it is close enough.
            let way = sub(target, common);
            if way.iter().all(|x| x.abs() <= long) && n.below(4) != 0 {
                dir = way;
            }
        } else {
            match n.below(6) {
                // Start at a point from which the ray hits the corner exactly.
                0 | 1 => {
                    dir = [(); 3].map(|()| component(n, style, long.min(far)));
                    for axis in 0..3 {
                        if (target[axis] - dir[axis]).abs() > far {
                            dir[axis] = -dir[axis];
                        }
                    }
                    origin = sub(target, dir);
                }
                // Aim at the midpoint of an edge from nearby.
                2 => {
                    origin = clip(add(c1, n.vector((long / 4).min(1000))));
                    let way = add(sub(c1, origin), sub(c2, origin));
                    if way.iter().all(|x| x.abs() <= long) {
                        dir = way;
                    }
                }
                3 => {
                    origin = c3;
                    let way = sub(c2, c1);
                    if way.iter().all(|x| x.abs() <= long) {
                        dir = way;
                    }
                }
                _ => origin = [(); 3].map(|()| component(n, style, far)),
            }
        }
        if dir == [0; 3] {
            dir = [0, -long, 0];
        }
        let ray = grid.ray_of(origin, dir).unwrap();
        let near = n.one_of(&[0.0, -1.0, 0.5, 1.0, 3.0]);
        let end = n.one_of(&[1.0, 2.0, 1e4, f32::INFINITY, f32::NAN]);
        if n.below(8) == 0 { ray.between(near, end) } else { ray }
    });
    let triangles = triangles.map(|corners| grid.triangle_of(corners).unwrap());
    (rays, triangles)
}

fn batches(seed: u64, batches: usize) {
    let mut n = Numbers(seed);
    let mut hits = 0;
    for _ in 0..batches {
        let (rays, triangles) = pairs(&mut n);
        hits += check_crossings(&rays, &triangles).unwrap_or_else(|why| panic!("{why}"));
    }
    println!(
        "{} pairs, {hits} crossings, every form and level agrees with the scalar reference",
        batches * 64
    );
    assert!(hits > batches, "too few crossings: {hits}");
}

#[test]
fn every_form_and_level_answers_as_the_scalar_reference() {
    batches(1, 62_500);
}

#[test]
#[ignore = "takes minutes: 100 million pairs"]
fn every_form_and_level_answers_as_the_scalar_reference_for_long() {
    batches(2, 1_600_000);
}
