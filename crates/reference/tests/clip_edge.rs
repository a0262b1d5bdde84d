//! Tests document E: trivial cases, clipping at each wall, points on walls, and the remaining part.

use intertri_reference::clip_edge::{Point4, clip_edge, outcode};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn p(x: f64, y: f64, z: f64, w: f64) -> Point4 {
    Point4::new(x, y, z, w)
}

fn clip(a: Point4, c: Point4) -> (i32, Point4, Point4) {
    let (mut a, mut c) = (a, c);
    (clip_edge(&mut a, &mut c), a, c)
}

const CENTRE: Point4 = Point4::new(0.0, 0.0, 0.0, 1.0);

#[test]
fn outcodes_name_the_walls() {
    assert_eq!(p(0.5, -0.25, 0.0, 2.0).boundaries(), [2.5, 1.5, 1.75, 2.25, 2.0, 2.0]);
    let code = |x, y, z, w| outcode(p(x, y, z, w).boundaries());
    assert_eq!(code(0.0, 0.0, 0.0, 1.0), 0);
    assert_eq!(code(-2.0, 0.0, 0.0, 1.0), 0b00_0001);
    assert_eq!(code(2.0, 0.0, 0.0, 1.0), 0b00_0010);
    assert_eq!(code(0.0, -2.0, 0.0, 1.0), 0b00_0100);
    assert_eq!(code(0.0, 2.0, 0.0, 1.0), 0b00_1000);
    assert_eq!(code(0.0, 0.0, -2.0, 1.0), 0b01_0000);
    assert_eq!(code(0.0, 0.0, 2.0, 1.0), 0b10_0000);
    assert_eq!(code(1.0, 0.0, 0.0, 1.0), 0b00_0010, "a point on the wall is outside");
    assert_eq!(code(0.0, 0.0, 0.0, -1.0), 0b11_1111, "a point behind the eye is outside all walls");
    assert_eq!(code(f64::NAN, 0.0, 0.0, 1.0), 0b00_0011);
}

#[test]
fn inside_stays_and_outside_of_one_wall_goes() {
    let (a, c) = (p(0.1, -0.2, 0.3, 1.0), p(-1.0, 1.5, 0.5, 2.0));
    assert_eq!(clip(a, c), (1, a, c));
    let (a, c) = (p(3.0, 0.0, 0.0, 1.0), p(2.0, 9.0, -9.0, 1.0));
    assert_eq!(clip(a, c), (0, a, c));
}

#[test]
fn each_wall_cuts_either_end() {
    for (axis, sign) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)] {
        let on_axis = |s: f64| {
            let mut xyz = [0.0; 3];
            xyz[axis] = s * sign;
            p(xyz[0], xyz[1], xyz[2], 1.0)
        };
        assert_eq!(clip(CENTRE, on_axis(2.0)), (1, CENTRE, on_axis(1.0)));
        assert_eq!(clip(on_axis(2.0), CENTRE), (1, on_axis(1.0), CENTRE));
        assert_eq!(clip(on_axis(-2.0), on_axis(4.0)), (1, on_axis(-1.0), on_axis(1.0)));
    }
}

#[test]
fn the_second_end_is_cut_from_the_old_first_end() {
    // If C were computed from the new A, it would be about 0.625 instead of 1.
    let (answer, a, c) = clip(p(-3.0, 0.0, 0.0, 1.0), p(5.0, 0.0, 0.0, 1.0));
    assert_eq!((answer, a.x, c.x), (1, -1.0, 1.0));
    // If A is inside, nothing is stored in the temporary, and A must not change.
    let a = p(0.5, 0.5, 0.5, 1.0);
    assert_eq!(clip(a, p(0.5, 0.5, 2.5, 1.0)), (1, a, p(0.5, 0.5, 1.0, 1.0)));
}

#[test]
fn past_a_corner_of_the_volume_the_interval_closes_early() {
    // One end is outside in x and the other in y, and the edge passes outside the corner (1, 1).
    let (a, c) = (p(3.0, 0.0, 0.0, 1.0), p(0.0, 3.0, 0.0, 1.0));
    assert_eq!(clip(a, c), (0, a, c));
    // An edge through the corner itself is clipped to one point.
    let (answer, a, c) = clip(p(2.0, 0.0, 0.0, 1.0), p(0.0, 2.0, 0.0, 1.0));
    assert_eq!((answer, a, c), (1, p(1.0, 1.0, 0.0, 1.0), p(1.0, 1.0, 0.0, 1.0)));
}

#[test]
fn an_edge_in_a_wall_goes_and_one_that_starts_there_stays() {
    let (a, c) = (p(1.0, 0.0, 0.0, 1.0), p(1.0, 0.5, 0.0, 1.0));
    assert_eq!(clip(a, c), (0, a, c));
    assert_eq!(clip(a, CENTRE), (1, a, CENTRE));
    assert_eq!(clip(CENTRE, a), (1, CENTRE, a));
    // A degenerate edge is kept if its point is inside, and rejected otherwise.
    assert_eq!(clip(CENTRE, CENTRE).0, 1);
    assert_eq!(clip(a, a).0, 0);
}

#[test]
fn an_edge_through_the_eyes_plane_loses_what_is_behind() {
    // An edge from w = 1, in front of the eye, to w = -1, behind it, leaves the volume where w
    // falls to |z| = 0.5.
    let (a, c) = (p(0.0, 0.0, 0.5, 1.0), p(0.0, 0.0, 0.5, -1.0));
    assert_eq!(clip(a, c), (1, a, p(0.0, 0.0, 0.5, 0.5)));
    assert_eq!(clip(c, a), (1, p(0.0, 0.0, 0.5, 0.5), a));
    // An edge entirely behind the eye, and a point with all coordinates 0.
    assert_eq!(clip(p(0.1, 0.0, 0.0, -1.0), p(0.0, 0.2, 0.0, -3.0)).0, 0);
    assert_eq!(clip(p(0.0, 0.0, 0.0, 0.0), p(0.0, 0.0, 0.0, 0.0)).0, 0);
}

#[test]
fn nan_and_infinity_have_no_part_inside() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for q in [
            p(bad, 0.0, 0.0, 1.0),
            p(0.0, bad, 0.0, 1.0),
            p(0.0, 0.0, bad, 1.0),
            p(0.0, 0.0, 0.0, bad),
        ] {
            let (mut a, mut c) = (q, CENTRE);
            assert_eq!((clip_edge(&mut a, &mut c), c), (0, CENTRE), "{q:?} first");
            let (mut a, mut c) = (CENTRE, q);
            assert_eq!((clip_edge(&mut a, &mut c), a), (0, CENTRE), "{q:?} last");
        }
    }
}

fn point() -> impl Strategy<Value = Point4> {
    prop::array::uniform4(-3.0f64..3.0).prop_map(|[x, y, z, w]| p(x, y, z, w))
}

/// Returns the smallest boundary coordinate of the point at `t`.
fn depth_inside(a: Point4, c: Point4, t: f64) -> f64 {
    let mix = |a: f64, c: f64| a + t * (c - a);
    let at = p(mix(a.x, c.x), mix(a.y, c.y), mix(a.z, c.z), mix(a.w, c.w));
    at.boundaries().into_iter().fold(f64::INFINITY, f64::min)
}

proptest! {
    // Test the same cases on every run.
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// Walks along the edge: the remaining part is inside, and the rest of the edge is outside.
    #[test]
    fn the_part_that_is_left_is_the_part_inside(a in point(), c in point()) {
        let (answer, new_a, new_c) = clip(a, c);
        // The position of a point along the old edge, measured in the coordinate that changes most.
        let parts = |q: Point4| [q.x - a.x, q.y - a.y, q.z - a.z, q.w - a.w];
        let whole = parts(c);
        let longest = (0..4).max_by(|&i, &j| whole[i].abs().total_cmp(&whole[j].abs())).unwrap();
        prop_assume!(whole[longest] != 0.0);
        let along = |q: Point4| parts(q)[longest] / whole[longest];
        let (t_in, t_out) = if answer == 1 { (along(new_a), along(new_c)) } else { (2.0, 2.0) };
        for step in 0..=100 {
            let t = f64::from(step) / 100.0;
            let depth = depth_inside(a, c, t);
            if t > t_in + 1e-9 && t < t_out - 1e-9 {
                prop_assert!(depth > -1e-12, "kept at {t}: {depth}");
            } else if t < t_in - 1e-9 || t > t_out + 1e-9 {
                prop_assert!(depth < 1e-12, "cut at {t}: {depth}");
            }
        }
        // An end that was inside keeps its bits.
        if answer == 1 {
            prop_assert!(depth_inside(a, c, 0.0) <= 0.0 || new_a == a);
            prop_assert!(depth_inside(a, c, 1.0) <= 0.0 || new_c == c);
        }
    }

    /// Clipping the reversed edge yields the same part.
    #[test]
    fn direction_does_not_matter(a in point(), c in point()) {
        let (one, a1, c1) = clip(a, c);
        let (two, c2, a2) = clip(c, a);
        prop_assert_eq!(one, two);
        let close = |p: Point4, q: Point4| {
            [p.x - q.x, p.y - q.y, p.z - q.z, p.w - q.w].iter().all(|d| d.abs() < 1e-9)
        };
        prop_assert!(close(a1, a2) && close(c1, c2));
    }
}
