//! The end plane of a bundle: all rays end in front of it, so they cannot hit anything in boxes
//! beyond it.
//!
//! ```text
//!         ╱ │ │      Rays from a light to a table end at the table, so the floor below is beyond
//!   o ────▌ │ │      all their ends. For slanted surfaces, one depth is not enough, but the
//!         ╲▌│ │      inverse depths of a plane are a linear form on the projection, like those
//!           ▌ floor  of a triangle.
//! ```

use intertri::internal::{Apex, Frame};
use intertri::simd::{Lanes, Mask, Simd};

use super::plane::CullingPlane;
use super::projection::Projection;
use crate::tree::{Margin, Node};
use crate::util::lane_ops::{smallest, total};

/// A bound on the rounding error of the form, relative to its coefficients: 20u.
/// `docs/numerics/hierarchy.md`, section 5, derives it.
const ROUNDING: f32 = 20.0 / (1 << 24) as f32;

/// The error of the points of parallel rays, and of the points of the originals of copies: 9u.
const POINTS: f32 = 9.0 / (1 << 24) as f32;

/// A bound on the ratio of a ray's length to its depth, including the rounding of inverse depths.
const LEAN: f32 = 1.25;

/// The maximum number of packets to whose rays the slopes are fitted.
const SAMPLE: usize = 16;

/// The maximum magnitude of a form's coefficient: 2^40.
const LARGEST: f32 = (1_u64 << 40) as f32;

/// A plane in front of which all rays end.
pub(crate) struct EndPlane {
    plane: CullingPlane,
    /// All rays end before the signed distance along the plane's normal exceeds this value.
    limit: f32,
}

impl EndPlane {
    /// Computes the end plane of a bundle's live rays.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(projection: &Projection<S>, margin: &Margin) -> Self {
        let (frame, (form, least)) = (&projection.frame, form(projection));
        let away = frame.origin().iter().fold(0.0, |m: f32, x| m.max(x.abs()));
        let Some(form) = form else {
            let plane = CullingPlane::new([0.0; 3], frame, margin);
            return Self { plane, limit: f32::INFINITY };
        };
        let plane = CullingPlane::new(normal(frame, form), frame, margin);

        // Hits are inside the scene and no farther away than the farthest end of a ray. Parallel rays
        // may be traced from infinity.
        let (limit, distance) = match frame.apex() {
            Apex::Finite => (1.0, (LEAN / least).min(away + margin.reach)),
            Apex::AtInfinity { .. } => (-form[0], 2.0 * (away + margin.reach)),
        };
        Self { plane: plane.for_places_within(distance, limit), limit }
    }

    /// Returns a mask of a node's boxes that are not beyond the plane.
    #[inline(always)]
    pub(crate) fn may_meet<F: Lanes<Scalar = f32>>(&self, node: &Node) -> F::Mask {
        self.plane.of_boxes::<F>(node, true).le(F::splat(self.limit + self.plane.pad))
    }
}

/// Returns the normal of the plane with a given linear form on a frame's projection.
fn normal(frame: &Frame, [one, x, y]: [f32; 3]) -> [f32; 3] {
    let (depth, [right, up]) = (frame.depth(), frame.across());
    // The inverse depth is 1 over the distance along the depth axis or, for parallel rays, the
    // negative of that distance.
    let one = if let Apex::Finite = frame.apex() { one } else { 1.0 };
    [0, 1, 2].map(|k| one * depth[k] + x * right[k] + y * up[k])
}

/// Computes a linear form on the projection that is below the inverse depths at which all live rays
/// end, and close to them if the rays end near a plane. If the values are too large, there is no form.
/// Also returns the smallest of those inverse depths.
#[inline(always)]
fn form<S: Simd>(projection: &Projection<S>) -> (Option<[f32; 3]>, f32) {
    let splat = S::F32x16::splat;
    // Start with the slopes of a least-squares fit and lower the form until it is below the inverse
    // end depth of every ray. Any plane lowered in this way is correct; a good fit culls more
    // boxes.
    let [along_x, along_y] = slopes(projection);
    let (mut least, mut ends) = (splat(f32::INFINITY), splat(f32::INFINITY));
    for packet in 0..projection.used {
        let (points, live) = (&projection.points[packet], Mask::from_bits(projection.live[packet]));
        let slope = points.x.mul_add(splat(along_x), points.y * splat(along_y));
        let end = projection.nearest[packet].least();
        least = S::F32x16::select(live, least.min(end - slope), least);
        ends = S::F32x16::select(live, ends.min(end), ends);
    }
    let (least, ends) = (smallest::<S>(least), smallest::<S>(ends));
    let size = least.abs() + along_x.abs() + along_y.abs();
    // The points of parallel rays are less exact.
    let rounding = match projection.frame.parallel_rays() {
        None => ROUNDING,
        Some(rays) => ROUNDING + POINTS * rays.scale * rays.away,
    };
    let form = (size < LARGEST).then_some([least - rounding * size, along_x, along_y]);
    (form, ends)
}

/// Returns the slopes of the rays' inverse end depths along x and y, by least squares; 0 if they
/// cannot be determined.
#[inline(always)]
fn slopes<S: Simd>(projection: &Projection<S>) -> [f32; 2] {
    let (zero, one) = (S::F32x16::splat(0.0), S::F32x16::splat(1.0));
    let (mut sums, mut products) = ([zero; 4], [zero; 5]);
    for packet in (0..projection.used).step_by(projection.used.div_ceil(SAMPLE)) {
        let live = Mask::from_bits(projection.live[packet]);
        let (points, s) = (&projection.points[packet], projection.nearest[packet].least());
        let x = S::F32x16::select(live, points.x, zero);
        let y = S::F32x16::select(live, points.y, zero);
        let s = S::F32x16::select(live, s, zero);
        let one = S::F32x16::select(live, one, zero);
        sums = [sums[0] + one, sums[1] + x, sums[2] + y, sums[3] + s];
        let [xx, xy, yy, xs, ys] = products;
        let (xx, xy, yy) = (x.mul_add(x, xx), x.mul_add(y, xy), y.mul_add(y, yy));
        products = [xx, xy, yy, x.mul_add(s, xs), y.mul_add(s, ys)];
    }

    // Make the sums relative to the mean.
    let [n, x, y, s] = [total(sums[0]), total(sums[1]), total(sums[2]), total(sums[3])];
    let [xx, xy, yy, xs, ys] = products;
    let (xx, xy, yy) = (total(xx) - x * x / n, total(xy) - x * y / n, total(yy) - y * y / n);
    let (xs, ys) = (total(xs) - x * s / n, total(ys) - y * s / n);

    // Collinear points determine no slope perpendicular to their line.
    let size = xx * yy - xy * xy;
    if size > 1e-3 * xx * yy {
        [(xs * yy - ys * xy) / size, (ys * xx - xs * xy) / size]
    } else {
        [0.0; 2]
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::{Lanes, Level, Simd, WithSimd};
    use intertri::{Mode, Ray};

    use super::{ROUNDING, form, normal};
    use crate::util::prefetch::Prefetch;
    use crate::util::test_numbers::random;
    use crate::walk::bundle::projection::Projection;
    use crate::walk::bundle::rays::{BundleRays, Common};

    /// Computes the form for rays from one origin, and the axes of the frame: depth, right, and up.
    struct Form<'a>(&'a [Ray]);

    impl WithSimd for Form<'_> {
        type Output = ([f32; 3], [[f32; 3]; 3]);
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let mut projection = Projection::<S>::empty();
            let rays = BundleRays {
                rays: self.0,
                first: intertri::RayId(0),
                next: &[],
                common: Common::Origin,
            };
            projection
                .project(&Mode::certified().filter(), &rays, 10.0, &mut Prefetch::of(&[], 0))
                .unwrap();
            let (depth, [right, up]) = (projection.frame.depth(), projection.frame.across());
            (form(&projection).0.unwrap_or_default(), [depth, right, up])
        }
    }

    /// Creates a ray that ends before a slanted wall, by a fraction `off` of its length.
    fn to_wall(i: usize, off: f32) -> Ray {
        let (packet, lane) = (i / 16, i % 16);
        let [x, y] = [4 * (packet % 8) + lane % 4, 4 * (packet / 8) + lane / 4];
        let (x, y) = (x as f32 / 40.0, y as f32 / 60.0);
        let dir = [x, y, 5.0 + 2.0 * x - 3.0 * y];
        Ray::new([1.0, 2.0, 3.0], dir).between(0.0, 1.0 - off)
    }

    /// Returns the extent of a ray along an axis.
    fn along(axis: [f32; 3], ray: &Ray) -> f64 {
        (0..3).map(|k| f64::from(axis[k]) * f64::from(ray.dir[k])).sum()
    }

    /// Returns the difference between the inverse depth at which a ray ends and the form, relative
    /// to that inverse depth.
    fn room(ray: &Ray, (form, axes): ([f32; 3], [[f32; 3]; 3])) -> f64 {
        let [z, x, y] = axes.map(|axis| along(axis, ray));
        let form = form.map(f64::from);
        let end = 1.0 / (f64::from(ray.t_max) * z);
        (end - (form[0] + form[1] * x / z + form[2] * y / z)) / end
    }

    #[test]
    fn the_form_is_below_all_ends_and_not_far() {
        // Rays end at the plane or up to 0.7 % in front of it.
        let off = |i: usize| (i * 13 % 8) as f32 * 1e-3;
        let mut rays: Vec<Ray> = (0..1024).map(|i| to_wall(i, off(i))).collect();
        // A ray whose interval is empty is dead and may end elsewhere.
        rays[100] = rays[100].between(3.0, 2.0);
        for count in [16, 100, 1000, 1024] {
            let rays = &rays[..count];
            for level in Level::all() {
                let form = level.run(Form(rays));
                let rooms = rays.iter().filter(|ray| ray.t_min < ray.t_max);
                let rooms = rooms.map(|ray| room(ray, form));
                let [least, most] =
                    rooms.fold([1.0, 0.0], |[a, b]: [f64; 2], room| [a.min(room), b.max(room)]);
                assert!(least > 0.0 && least < 3e-5, "{count}: {least}");
                assert!(most < 0.012, "{count}: {most}");
            }
        }
    }

    /// Computes the fraction of the rounding margin that is needed to keep the end of every live ray
    /// in front of the plane with the computed normal.
    struct Used<'a>(&'a [Ray]);

    impl WithSimd for Used<'_> {
        type Output = f64;
        #[inline(always)]
        fn run<S: Simd>(self) -> f64 {
            let mut projection = Projection::<S>::empty();
            let rays = BundleRays {
                rays: self.0,
                first: intertri::RayId(0),
                next: &[],
                common: Common::Origin,
            };
            if projection
                .project(&Mode::certified().filter(), &rays, 10.0, &mut Prefetch::of(&[], 0))
                .is_none()
            {
                return 0.0;
            }
            let form = form(&projection).0.unwrap_or_default();
            let (normal, depth) = (normal(&projection.frame, form), projection.frame.depth());
            let room = f64::from(ROUNDING) * form.iter().map(|&x| f64::from(x.abs())).sum::<f64>();
            let mut used = 0.0_f64;
            for (i, ray) in self.0.iter().enumerate() {
                let mut ends = [0.0; 16];
                projection.nearest[i / 16].least().store(&mut ends);
                if projection.live[i / 16] >> (i % 16) & 1 != 0 {
                    let beyond = along(normal, ray) / along(depth, ray) - f64::from(ends[i % 16]);
                    used = used.max(1.0 + beyond / room);
                }
            }
            used
        }
    }

    #[test]
    fn no_end_is_beyond_by_rounding() {
        let mut random = random();
        let mut random = || 2.0 * random() - 1.0;
        let levels: Vec<Level> = Level::all().collect();
        let mut most = 0.0_f64;
        for bundle in 0..200 {
            // Choose a few rays with similar directions that end at a plane with a random
            // orientation.
            let [axis, plane] = [(); 2].map(|()| [random(), random(), random()]);
            let ray = |dir: [f32; 3]| {
                let slope = (0..3).map(|k| plane[k] * dir[k]).sum::<f32>().abs().max(1e-3);
                Ray::new([0.0; 3], dir).between(0.0, 1.0 / slope)
            };
            let count = 3 + bundle % 3;
            let mut rays: Vec<Ray> = (0..count)
                .map(|_| ray([0, 1, 2].map(|k: usize| axis[k] + 0.4 * random())))
                .collect();

            // Keep every change that uses more of the margin.
            let (level, mut used) = (levels[bundle % levels.len()], 0.0);
            for step in 0..600 {
                let (number, before) = (step % count, rays[step % count]);
                let by = if step % 2 == 0 { 1e-6 } else { 1e-2 };
                rays[number] = ray(before.dir.map(|x| x * (1.0 + by * random())));
                let now = level.run(Used(&rays));
                if now >= used {
                    used = now;
                } else {
                    rays[number] = before;
                }
            }
            most = most.max(used);
        }
        assert!(most > 0.08 && most < 1.0, "{most}");
    }

    #[test]
    fn of_rays_without_end_nothing_is_known() {
        let endless: Vec<Ray> = (0..64).map(|i| to_wall(i, -f32::INFINITY)).collect();
        let dead: Vec<Ray> = (0..64).map(|i| to_wall(i, 2.0)).collect();
        for level in Level::all() {
            assert_eq!(level.run(Form(&endless)).0, [0.0; 3]);
            assert_eq!(level.run(Form(&dead)).0, [0.0; 3]);
        }
    }
}
