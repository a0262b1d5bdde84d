//! Measures how closely errors approach the projection's bounds. It compares the forms and the
//! inverse depth of triangles with values computed in f64, whose own error is a billionth of the
//! bounds, and with the reference's t.

use crate::common;
use intertri::internal::{Frame, Windows};
use intertri::simd::{Level, Simd, Vec3, WithSimd};
use intertri::{Mode, Ray, Triangle, TriangleBlock};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;
use intertri_reference as reference;

type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn to_f64(v: [f32; 3]) -> V {
    v.map(f64::from)
}

/// A triangle, a ray near it, and the axes of a projection.
#[derive(Clone, Copy)]
struct Case {
    triangle: Triangle,
    ray: Ray,
    axes: [[f32; 3]; 3],
    /// The offset of the ray from the projection's origin.
    off: [f32; 3],
}

impl Case {
    fn length_off(&self) -> f32 {
        (dot(to_f64(self.off), to_f64(self.off)).sqrt() as f32).next_up()
    }
}

/// Generates axes that are orthogonal up to rounding. The first is approximately parallel to `dir`.
fn axes(dir: V, rng: &mut Rng) -> Option<[[f32; 3]; 3]> {
    let unit = |v: V| v.map(|x| x / dot(v, v).sqrt());
    let depth = unit(unit(dir).map(|x| x + 0.1 * rng.signed()));
    let right = unit(cross(depth, rng.direction()));
    let axes = [depth, right, cross(depth, right)].map(|v| v.map(|x| x as f32));
    axes.iter().flatten().all(|x| x.is_finite()).then_some(axes)
}

/// Computes the forms, the error bound of the inverse depth, and the unit of the edges at one SIMD
/// level.
struct Compute<'a>(&'a Case);

impl WithSimd for Compute<'_> {
    type Output = Option<([f32; 4], f32, f32)>;
    fn run<S: Simd>(self) -> Self::Output {
        let Case { triangle, ray, axes: [a, r, b], .. } = *self.0;
        let frame = Frame::new(ray.origin, a, r, b);
        let points = frame.points(Vec3::<f32>::splat(ray.dir));
        let reach = [points.x.abs(), points.y.abs()];
        let frame = frame.passed_within(self.0.length_off(), reach);
        if !frame.on_screen(&points) {
            return None;
        }
        let block = TriangleBlock::<8>::new(&[triangle]);
        let filter = Mode::certified().filter();
        let outline = filter.outlines_in::<S>(&block, None, &frame, points.z).lane(0);
        let (values, err) = outline.at(&points);
        Some((values, err, outline.unit()))
    }
}

/// Returns how much of the bounds for the edges and for the inverse depth a case uses, or `None` if
/// the projection decides nothing.
fn shares(case: &Case, level: Level) -> Option<[f64; 2]> {
    let (values, err, unit) = level.run(Compute(case))?;
    if values.iter().any(|x| !x.is_finite()) {
        return None;
    }

    // Compute the same values in f64, in the frame's axes.
    let Case { triangle, ray, axes, off } = *case;
    let into = |v: V| axes.map(|axis| dot(to_f64(axis), v));
    let [c1, c2, c3] = triangle.0.map(to_f64);
    let a = sub(sub(c1, to_f64(ray.origin)), to_f64(off));
    let (a, h4, h5) = (into(a), into(sub(c2, c1)), into(sub(c3, c1)));
    let d = into(to_f64(ray.dir));
    let point = [1.0, d[1] / d[0], d[2] / d[0]];
    let (n, fv, fw) = (cross(h4, h5), cross(h5, a), cross(a, h4));
    let t = dot(n, a);
    let fu = sub(sub(n, fv), fw);

    // The edges have the same sign as T.
    let unit = f64::from(unit) * t.signum();
    let edge = [fu, fv, fw]
        .iter()
        .zip(values)
        .map(|(f, value)| (f64::from(value) - dot(*f, point) / unit).abs())
        .fold(0.0, f64::max);

    // Use the reference's t if it computes one, and otherwise the t at which the ray meets the
    // plane.
    let scene = reference::Scene::from_triangles([triangle.0]);
    let line = reference::Ray::new(ray.origin, ray.dir);
    let mut hit = 0.0;
    let s = match scene.inter_tri(0, &line, &mut hit) {
        1 if off == [0.0; 3] => 1.0 / (hit * d[0]),
        _ => dot(n, point) / t,
    };
    Some([edge, (f64::from(values[3]) - s).abs() / f64::from(err)])
}

/// No family may exceed a bound, and a search must find inputs that use a considerable share of
/// each bound.
#[test]
fn the_bounds_hold_and_are_not_idle() {
    let levels: Vec<Level> = Level::all().collect();
    let mut worst = [0.0_f64; 2];
    for family in FAMILIES {
        let mut rng = Rng::new(11);
        let mut most = [0.0_f64; 2];
        for i in 0..400 {
            let scene = common::scene(family, &mut rng, 1, 1);
            let (triangle, ray) = (scene.triangles[0], scene.rays[0]);
            let Some(axes) = axes(to_f64(ray.dir), &mut rng) else { continue };
            let case = Case { triangle, ray, axes, off: [0.0; 3] };
            let Some(used) = shares(&case, levels[i % levels.len()]) else { continue };
            assert!(
                used.iter().all(|x| *x < 1.0),
                "{}: {used:?}\n{triangle:?}\n{ray:?}",
                family.name
            );
            most = [most[0].max(used[0]), most[1].max(used[1])];
        }
        println!("{:20} edges {:.3} depth {:.3}", family.name, most[0], most[1]);
        worst = [worst[0].max(most[0]), worst[1].max(most[1])];
    }

    // Climb toward the largest share of the edges' bound, one number at a time.
    for seed in 0..12 {
        let mut rng = Rng::new(100 + seed);
        let corner = |rng: &mut Rng| rng.cube().map(|x| x as f32);
        let mut case = Case {
            triangle: Triangle([corner(&mut rng), corner(&mut rng), corner(&mut rng)]),
            ray: Ray::new([0.0; 3], corner(&mut rng)),
            axes: [[0.0; 3]; 3],
            off: [0.0; 3],
        };
        let Some(first) = axes(to_f64(case.ray.dir), &mut rng) else { continue };
        case.axes = first;
        let mut best = 0.0;
        for _ in 0..20_000 {
            let mut next = case;
            let small = rng.log(1e-7, 0.3) as f32;
            let number = match rng.below(12) {
                k @ 0..9 => &mut next.triangle.0[k / 3][k % 3],
                k => &mut next.ray.dir[k - 9],
            };
            *number += small * rng.signed() as f32;
            if let Some(used) = shares(&next, Level::best()) {
                assert!(used.iter().all(|x| *x < 1.0), "{used:?}");
                worst[1] = worst[1].max(used[1]);
                if used[0] > best {
                    (case, best) = (next, used[0]);
                }
            }
        }
        worst[0] = worst[0].max(best);
    }
    println!("search: edges {:.3} depth {:.3}", worst[0], worst[1]);
    assert!(worst[0] > 0.08 && worst[1] > 0.1, "no input comes near the bounds: {worst:?}");
}

/// Computes whether a triangle's rectangle reaches a window of size zero at the projected point of
/// the ray.
struct Reached<'a>(&'a Case);

impl WithSimd for Reached<'_> {
    type Output = Option<bool>;
    fn run<S: Simd>(self) -> Self::Output {
        let Case { triangle, ray, axes: [a, r, b], .. } = *self.0;
        let frame = Frame::new(ray.origin, a, r, b);
        let points = frame.points(Vec3::<f32>::splat(ray.dir));
        let reach = [points.x.abs(), points.y.abs()];
        let frame = frame.passed_within(self.0.length_off(), reach);
        let block = TriangleBlock::<8>::new(&[triangle]);
        let filter = Mode::certified().filter();
        let outline = filter.outlines_in::<S>(&block, None, &frame, points.z).lane(0);
        let window = Windows::<f32>::new([points.x, points.y], [points.x, points.y]);
        frame
            .on_screen(&points)
            .then(|| outline.near(&window) != 0 && outline.within(&window, 0.0) != 0)
    }
}

/// Tests rays that miss the origin by a small offset. To allow for this offset, the bounds of the
/// edges, of the depth, and of the rectangle have additional margins. A search looks for inputs
/// that use most of each margin, to show that half the margin would not be enough.
#[test]
fn rays_that_pass_the_origin_have_room_and_not_much_more() {
    let mut worst = [0.0_f64; 2];
    let (mut closest, mut seen) = (0, 0);
    for seed in 0..24 {
        let mut rng = Rng::new(500 + seed);
        let number = |rng: &mut Rng, size: f64| rng.cube().map(|x| (size * x) as f32);
        let size = rng.log(1e-5, 0.02);
        let mut case = Case {
            triangle: Triangle([0; 3].map(|_| number(&mut rng, 1.0))),
            ray: Ray::new([0.0; 3], number(&mut rng, 1.0)),
            axes: [[0.0; 3]; 3],
            off: number(&mut rng, size),
        };
        let Some(axes) = axes(to_f64(case.ray.dir), &mut rng) else { continue };
        case.axes = axes;
        let which = seed as usize % 2;
        let mut best = 0.0;
        for _ in 0..20_000 {
            let mut next = case;
            let small = rng.log(1e-4, 1.0) as f32;
            let (number, size) = match rng.below(15) {
                k @ 0..9 => (&mut next.triangle.0[k / 3][k % 3], 1.0),
                k @ 9..12 => (&mut next.ray.dir[k - 9], 1.0),
                k => (&mut next.off[k - 12], size as f32),
            };
            *number += small * size * rng.signed() as f32;
            if let Some(used) = shares(&next, Level::best()) {
                assert!(used.iter().all(|x| *x < 1.0), "{used:?} of\n{:?}", next.off);
                worst[1 - which] = worst[1 - which].max(used[1 - which]);
                if used[which] > best {
                    (case, best) = (next, used[which]);
                }
            }

            // If a ray passes just inside an edge, the rectangle must reach the ray's point.
            let [c1, c2, c3] = next.triangle.0.map(to_f64);
            let weight = rng.unit();
            let on_edge = [0, 1, 2].map(|k| c1[k] + weight * (c2[k] - c1[k]));
            let inside = [0, 1, 2].map(|k| on_edge[k] + 1e-6 * (c3[k] - on_edge[k]));
            let dir = sub(inside, to_f64(next.off));
            let Some(axes) = self::axes(dir, &mut rng) else { continue };
            (next.ray.dir, next.axes) = (dir.map(|x| x as f32), axes);
            if let Some(reached) = Level::best().run(Reached(&next)) {
                seen += 1;
                assert!(
                    reached,
                    "an edge's point is not reached: {:?} {:?}",
                    next.triangle, next.off
                );
            }
            closest += 1;
        }
        worst[which] = worst[which].max(best);
    }
    println!(
        "off the origin: edges {:.3} depth {:.3}; {seen} of {closest} reached",
        worst[0], worst[1]
    );
    assert!(worst[0] > 0.55 && worst[1] > 0.55, "the margins are too large: {worst:?}");
    assert!(2 * seen > closest);
}
