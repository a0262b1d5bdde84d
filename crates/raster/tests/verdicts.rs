//! Tests the rule that excuses differences between images, just inside and just outside its exact
//! limits.

use crate::common::Numbers;
use dashu_ratio::Relaxed as Exact;
use intertri::{Hit, Triangle};
use intertri_raster::{Verdict, View, differences};

const SIDE: u32 = 8;
const PIXEL: (u32, u32) = (5, 3);

fn exact(x: f64) -> Exact {
    Exact::try_from(x).unwrap()
}

fn ahead(half_height: f64) -> View {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    View::new([0.0; 3], axes, half_height, SIDE, SIDE).unwrap()
}

/// Returns the verdict on one pixel for which the two images have these hits.
fn verdict(view: &View, soup: &[Triangle], pair: [Hit; 2]) -> Verdict {
    let place = (PIXEL.1 * SIDE + PIXEL.0) as usize;
    let [one, other] = pair.map(|hit| {
        let mut hits = vec![Hit::MISS; (SIDE * SIDE) as usize];
        hits[place] = hit;
        hits
    });
    differences(view, soup, &one, &other)[place]
}

fn shows(triangle: u32, t: f64) -> Hit {
    Hit { t, triangle, ..Hit::MISS }
}

/// Returns the smallest f64 between `lo` and `hi` for which a predicate is true. The predicate must
/// be false below the result and true above it.
fn turning_point(lo: f64, hi: f64, question: impl Fn(f64) -> bool) -> f64 {
    let (mut lo, mut hi) = (lo.to_bits(), hi.to_bits());
    while hi - lo > 1 {
        let middle = lo.midpoint(hi);
        if question(f64::from_bits(middle)) {
            hi = middle;
        } else {
            lo = middle;
        }
    }
    f64::from_bits(hi)
}

#[test]
fn an_edge_at_the_distance_to_the_last_bit() {
    // At a certain image width, a vertical edge to the right of a pixel's centre comes within the
    // tolerance. Test the widths just below and just above it, for which f64 arithmetic may give
    // the wrong verdict.
    let mut numbers = Numbers(71);
    let (mut wrong_in_f64, mut excused, mut tried) = (0, 0, 0);
    for _ in 0..40 {
        let (w, x) = (2.0 + numbers.next(), 1.5 + 0.5 * numbers.next());
        let (w, x) = (w as f32, x as f32);
        let soup = [Triangle([[x, -90.0, -w], [x, 90.0, -w], [x + 90.0, 0.0, -w]])];

        // The edge's distance to the right of the centre, in pixels. Up to the tolerance, x / w is
        // 3 / 8 of half the image's width.
        let centre = f64::from(PIXEL.0) + 0.5;
        let apart =
            |half: f64| (1.0 + f64::from(x) / half / f64::from(w)) * f64::from(SIDE) * 0.5 - centre;
        let apart_exactly = |half: f64| {
            let half_side = Exact::from(SIDE) / Exact::from(2);
            exact(x.into()) / exact(w.into()) / exact(half) * &half_side + half_side - exact(centre)
        };
        let within = |half: f64| apart_exactly(half) <= exact(ahead(half).tolerance());
        let half = f64::from(x) / f64::from(w) / 0.375;
        let turn = turning_point(half * 0.999, half * 1.001, within);
        for step in -20..=20 {
            let half = f64::from_bits(turn.to_bits().wrapping_add_signed(step));
            let view = ahead(half);
            let found = verdict(&view, &soup, [shows(0, 1.0), Hit::MISS]);
            let expected = if within(half) { Verdict::Excused } else { Verdict::Unexcused };
            assert_eq!(found, expected, "{x} {w} {half:e}");
            tried += 1;
            excused += usize::from(within(half));
            wrong_in_f64 += usize::from((apart(half) <= view.tolerance()) != within(half));
        }
    }
    assert!(excused > tried / 3 && excused < tried * 2 / 3, "{excused} of {tried}");
    assert!(wrong_in_f64 > 20, "f64 decides only {wrong_in_f64} of {tried} cases wrongly");
}

#[test]
fn planes_that_tie_beside_the_disc_excuse_nothing() {
    // Two planes intersect in a vertical line: at the centre, just within the tolerance, and beyond
    // the tolerance.
    let view = ahead(1.0);
    let centre = (f64::from(PIXEL.0) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
    let wall = |slope: f64, line: f64| {
        let at = |x: f64, y: f64| {
            // q = 1/4 + slope (x - line)
            let w = 1.0 / (0.25 + slope * (x - line));
            [x * w, y * w, -w].map(|x| x as f32)
        };
        Triangle([at(-3.0, -5.0), at(3.0, -5.0), at(0.1, 9.0)])
    };
    let pixels = 2.0 / f64::from(SIDE);
    for (off, expected) in [
        (0.0, Verdict::Excused),
        (0.98, Verdict::Excused),
        (1.02, Verdict::Unexcused),
        (30.0, Verdict::Unexcused),
    ] {
        for side in [-1.0, 1.0] {
            let line = centre + side * off * view.tolerance() * pixels;
            let soup = [wall(0.03, line), wall(-0.03, line)];
            let found = verdict(&view, &soup, [shows(0, 4.0), shows(1, 4.0)]);
            // Rounding corners to f32 moves the line by at most a hundredth of the tolerance.
            assert_eq!(found, expected, "{off} {side}");
        }
    }
    // Two equal planes tie everywhere. Two planes one behind the other tie nowhere, even though the
    // nearest corner of the second is closer than the farthest corner of the first.
    let soup = [wall(0.03, 0.0), wall(0.03, 0.0)];
    assert_eq!(verdict(&view, &soup, [shows(0, 4.0), shows(1, 4.0)]), Verdict::Excused);
    let behind = Triangle(soup[0].0.map(|[x, y, z]| [x, y, z * (1.0 + 1e-6)]));
    let soup = [soup[0], behind];
    assert_eq!(verdict(&view, &soup, [shows(0, 4.0), shows(1, 4.0)]), Verdict::Unexcused);
}

#[test]
fn the_same_triangle_is_at_one_depth() {
    // A wall perpendicular to the view has the same depth over the whole disc.
    let view = ahead(1.0);
    let soup = [Triangle([[-90.0, -90.0, -4.0], [90.0, -90.0, -4.0], [0.0, 90.0, -4.0]])];
    let d = view.direction(f64::from(PIXEL.0) + 0.5, f64::from(PIXEL.1) + 0.5);
    let t = 4.0 * d.iter().map(|x| x * x).sum::<f64>().sqrt();
    let same = |t| verdict(&view, &soup, [shows(0, t); 2]) == Verdict::Same;
    let e = 2f64.powi(-22);
    assert!(same(t) && same(t * (1.0 + 0.9 * e)) && same(t * (1.0 - 0.9 * e)));
    assert!(!same(t * (1.0 + 1.1 * e)) && !same(t * (1.0 - 1.1 * e)));
    assert!(!same(0.0) && !same(-t) && !same(f64::NAN) && !same(f64::INFINITY));
    // A triangle that is degenerate or not finite is never visible.
    let broken = [Triangle([[f32::NAN; 3]; 3]), Triangle([[1.0; 3]; 3])];
    for triangle in [0, 1] {
        let found = verdict(&view, &broken, [shows(triangle, 1.0), Hit::MISS]);
        assert_eq!(found, Verdict::Unexcused);
    }
}
