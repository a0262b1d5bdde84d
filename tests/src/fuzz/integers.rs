//! Checks the `fixed` mode against its scalar reference, and checks the sums of crossings of closed
//! fans of triangles.

use std::array::from_fn;

use intertri::fixed::{Bits, Fixed, Grid, Ray, Triangle, blocks};

use super::input::Input;
use crate::grid_reference::crossings;
use crate::{check_crossings, is_on};

/// Checks eight rays and eight triangles whose coordinates are integers at the limits of the bit
/// budgets, in every form of the kernel and at every SIMD level.
pub fn fixed(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let (b, q) = input.one_of(&[(20, 18), (19, 20), (17, 24), (16, 16), (3, 2), (1, 1)]);
    let grid = Grid::at(Bits::new(b, q).unwrap(), 0, [0; 3]).unwrap();
    let (far, long) = (1 << b, 1 << q);
    let mut number = |limit: i32| match input.below(5) {
        0 => input.within(limit),
        1 => limit - input.below(3.min(limit as usize)) as i32,
        2 => -limit,
        _ => input.within(limit.min(3)),
    };

    // The triangles share a few points. The rays go toward the shared points, along edges, and in
    // arbitrary directions.
    let points: [[i32; 3]; 6] = from_fn(|_| from_fn(|_| number(far)));
    let dirs: [[i32; 3]; 4] = from_fn(|_| from_fn(|_| number(long)));
    let triangles: [Triangle; 8] =
        from_fn(|_| grid.triangle_of(from_fn(|_| input.one_of(&points))).unwrap());
    let shared = input.below(2) == 0;
    let rays: [Ray; 8] = from_fn(|_| {
        let origin = if shared { points[0] } else { input.one_of(&points) };
        let [from, to] = [input.one_of(&points), input.one_of(&points)];
        let dir: [i32; 3] = match input.below(4) {
            0 => from_fn(|i| from[i] - origin[i]),
            1 => from_fn(|i| from[i] + to[i] - 2 * origin[i]),
            2 => from_fn(|i| to[i] - from[i]),
            _ => input.one_of(&dirs),
        };
        let fits = dir != [0; 3] && dir.iter().all(|x| x.abs() <= long);
        let ray = grid.ray_of(origin, if fits { dir } else { [0, -long, 1] }).unwrap();
        let (near, end) = (input.number(), input.number());
        if input.below(4) == 0 { ray.between(near, end) } else { ray }
    });
    check_crossings(&rays, &triangles).unwrap_or_else(|why| panic!("{why}"));
}

/// Builds two fans of triangles that join two tips to a common rim. Together they form a closed
/// mesh, wherever the corners are. From a point off the surface, the number of exits minus the
/// number of entries must be the same for every ray.
///
/// ```text
///        tip
///       / | \        (tip, r0, r1), (tip, r1, r2), ...
///     r0--r1--r2     and, reversed, with the other tip: every edge is traversed both ways
///       \ | /
///       other
/// ```
pub fn fans(bytes: &[u8]) {
    let mut input = Input::on_a_grid(bytes);
    let bits = input.one_of(&[Bits::new(17, 20).unwrap(), Bits::new(4, 8).unwrap()]);
    let grid = Grid::at(bits, 0, [0; 3]).unwrap();
    let far = 1 << bits.b();
    let wide = input.one_of(&[2, 4, far]);
    let point = |input: &mut Input<'_>| -> [i32; 3] { from_fn(|_| input.within(wide)) };

    let (tip, other) = (point(&mut input), point(&mut input));
    let rim: Vec<[i32; 3]> = (0..3 + input.below(6)).map(|_| point(&mut input)).collect();
    let next = rim.iter().cycle().skip(1);
    let fan = rim.iter().zip(next).flat_map(|(&r, &s)| [[tip, r, s], [other, s, r]]);
    let corners: Vec<[[i32; 3]; 3]> = fan.collect();
    let triangles: Vec<Triangle> =
        corners.iter().map(|&corners| grid.triangle_of(corners).unwrap()).collect();
    let blocks = blocks(&triangles);

    let origin = point(&mut input);
    if corners.iter().any(|&corners| is_on(origin, corners)) {
        return;
    }
    // Aim at every corner and every edge's midpoint, along the axes, and in arbitrary directions.
    let to = |p: [i32; 3]| [0, 1, 2].map(|i| p[i] - origin[i]);
    let mut dirs = vec![[1, 0, 0], [0, -1, 0], [0, 0, 1], point(&mut input)];
    for [a, b, _] in &corners {
        let (a, b) = (to(*a), to(*b));
        dirs.extend([a, from_fn(|i| a[i] + b[i])]);
    }
    let fixed = Fixed::default();
    let mut winding = None;
    for dir in dirs.into_iter().filter(|&dir| dir != [0; 3]) {
        let ray = grid.ray_of(origin, dir).unwrap();
        let count = fixed.crossings(&blocks, &ray);
        let expected = *winding.get_or_insert(count.signed);
        assert_eq!(count.signed, expected, "{origin:?} {dir:?} {count:?}\n{corners:?}");

        // The hits must be those of the scalar reference, which compares values of t as ratios.
        let want: Vec<_> = (crossings(&ray, &triangles).iter())
            .map(|(crossing, index)| crossing.to_hit(&ray, *index))
            .collect();
        assert_eq!(fixed.all(&blocks, &ray), want, "{ray:?}\n{corners:?}");
        assert_eq!(fixed.closest(&blocks, &ray).as_ref(), want.first(), "{ray:?}\n{corners:?}");
        assert_eq!(fixed.any(&blocks, &ray), !want.is_empty(), "{ray:?}\n{corners:?}");
        assert_eq!(count.unsigned, want.len() as u64, "{ray:?}\n{corners:?}");
    }
}
