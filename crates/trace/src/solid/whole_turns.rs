//! Computes how many whole turns a boundary adds to the crossings of rays, for eight points at
//! once.
//!
//! ```text
//!   cluster  ──► far from all eight points, and all rays miss the sphere: a bound
//!            └──► otherwise its parts, down to loops: a product with one complex number per edge
//!                                │
//!   angle of the product ────────┴──► not near half a turn: turns are certain without computing an angle
//! ```
//!
//! `docs/numerics/winding.md`, section 5, has the derivation and the bound.

use intertri::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd};
use intertri::{RayOf, Scalar};

use super::boundary::Boundary;
use crate::util::lane_ops::lanes_of;

/// The number of points to process at once.
pub(super) const POINTS: usize = 8;

/// A cluster counts as far if it covers a smaller fraction of all directions than this. If one
/// value leaves points undecided, the next one is tried.
const FAR: [f64; 3] = [1.0 / 64.0, 1.0 / 4096.0, 0.0];

/// If the squared distance of an edge's complex number from the negative axis is below this
/// fraction of the product of its ends' squared distances, the side must be determined exactly.
const NEAR_AXIS: f64 = 1.0 / (1_u64 << 40) as f64;

/// If every corner's squared distance is at least this, the products of a loop cannot underflow.
const NEAR_CORNER: f64 = 1.0 / (1_u64 << 32) as f64;

/// An upper bound on the rounding error of an edge's solid angle, divided by 4π.
const EDGE_OFF: f64 = 1.0 / (1_u64 << 24) as f64;

/// An upper bound on the relative rounding error of a squared distance.
const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// Computes, for up to eight rays, the integer nearest to the number of turns that a boundary adds
/// at the ray's origin. Returns the turns and a mask of the rays for which they are certain. Only
/// the rays in `asked` are processed.
pub(super) fn whole_turns<S: Scalar>(
    boundary: &Boundary<S>,
    rays: &[RayOf<S>],
    asked: u32,
) -> ([f64; POINTS], u32) {
    let some = asked.trailing_zeros() as usize;
    let mut points = [[0.0; POINTS]; 3];
    for i in 0..POINTS {
        // Unused lanes repeat the point of a used lane.
        let ray = &rays[if asked >> i & 1 == 1 { i } else { some }];
        for (row, x) in points.iter_mut().zip(ray.origin) {
            row[i] = x.into();
        }
    }
    Level::best().run(WholeTurns { boundary, points, asked })
}

struct WholeTurns<'a, S> {
    boundary: &'a Boundary<S>,
    points: [[f64; POINTS]; 3],
    asked: u32,
}

impl<S: Scalar> WithSimd for WholeTurns<'_, S> {
    type Output = ([f64; POINTS], u32);

    #[inline(always)]
    fn run<L: Simd>(self) -> Self::Output {
        let (mut all, mut sure) = ([0.0; POINTS], 0);
        let points = Vec3::<L::F64x8>::load(&self.points);
        for far in FAR {
            let (turns, certain) = self.rounded::<L>(points, far);
            let mut some = [0.0; POINTS];
            turns.store(&mut some);
            for i in lanes_of(certain) {
                all[i] = some[i];
            }
            sure |= certain;
            if sure & self.asked == self.asked {
                break;
            }
        }
        (all, sure)
    }
}

impl<S: Scalar> WholeTurns<'_, S> {
    /// Returns the rounded turns, and a mask of the points for which they are certain.
    #[inline(always)]
    fn rounded<L: Simd>(&self, points: Vec3<L::F64x8>, far: f64) -> (L::F64x8, u32) {
        let splat = L::F64x8::splat;
        let clusters = &self.boundary.clusters;
        let along = Vec3::splat(self.boundary.axes.0[0]);
        let axes = self.boundary.axes.0.map(|axis| Vec3::splat(axis.map(|x| clusters.scale * x)));
        let mut product = Product::<L>::new();
        let (mut off, mut edges, mut i) = (splat(0.0), 0, 0);
        while let Some(cluster) = clusters.clusters.get(i) {
            let v = Vec3::splat(cluster.middle) - points;
            let (along, away) = (v.dot_fused(along), v.dot_fused(v));
            let radius = splat(cluster.radius);
            let across = away * splat(1.0 - ROUNDING) - along * along;
            let passes_by = along.lt(splat(0.0)) | across.gt(radius);
            // Compute a lower bound on the product of the distances from the sphere's centre and
            // from its surface.
            let gap = away * splat(0.875) - (radius + radius);
            // The cluster covers at most this fraction of all directions. The quotient matters only
            // if it is small.
            let (num, den) = (splat(cluster.area) * away, gap * gap);
            let is_far = passes_by & gap.gt(splat(0.0)) & num.lt(splat(far) * den);
            if is_far.bits() == (1 << POINTS) - 1 {
                off = off + num / den;
                i = cluster.next;
                continue;
            }
            if let Some([start, end]) = cluster.corners {
                product.add_loop(&axes, points, &clusters.corners[start..end]);
                edges += end - start;
            }
            i += 1;
        }
        let off = off + splat(EDGE_OFF * edges as f64);
        (product.turns, product.is_certain(off).bits())
    }
}

/// The product of the edges' complex numbers and the number of whole turns. Apart from these turns,
/// the argument of the product is half the solid angle.
struct Product<L: Simd> {
    re: L::F64x8,
    im: L::F64x8,
    turns: L::F64x8,
    /// The smallest squared distance of an edge's complex number from the negative axis, minus the
    /// limit set by [`NEAR_AXIS`].
    beside: L::F64x8,
    /// The smallest squared distance of a corner from each point.
    corner: L::F64x8,
}

/// A corner as seen from the points.
#[derive(Clone, Copy)]
struct ProjectedCorner<L: Simd> {
    across: [L::F64x8; 2],
    excess: L::F64x8,
    /// The squared distance from the points.
    far: L::F64x8,
}

impl<L: Simd> ProjectedCorner<L> {
    #[inline(always)]
    fn new(axes: &[Vec3<L::F64x8>; 3], points: Vec3<L::F64x8>, corner: [f64; 3]) -> Self {
        let v = Vec3::splat(corner) - points;
        let (z, x, y) = (v.dot_fused(axes[0]), v.dot_fused(axes[1]), v.dot_fused(axes[2]));
        let far = z.mul_add(z, x.mul_add(x, y * y));
        Self { across: [x, y], excess: far.sqrt() - z, far }
    }
}

impl<L: Simd> Product<L> {
    #[inline(always)]
    fn new() -> Self {
        let splat = L::F64x8::splat;
        let (zero, many) = (splat(0.0), splat(f64::INFINITY));
        Self { re: splat(1.0), im: zero, turns: zero, beside: many, corner: many }
    }

    #[inline(always)]
    fn add_loop(
        &mut self,
        axes: &[Vec3<L::F64x8>; 3],
        points: Vec3<L::F64x8>,
        corners: &[[f64; 3]],
    ) {
        let zero = L::F64x8::splat(0.0);
        let mut from = ProjectedCorner::<L>::new(axes, points, corners[0]);
        for corner in &corners[1..] {
            let to = ProjectedCorner::<L>::new(axes, points, *corner);
            let ([ax, ay], [bx, by]) = (from.across, to.across);
            let x = from.excess.mul_add(to.excess, ax.mul_add(bx, ay * by));
            let y = ay.mul_add(bx, -(ax * by));
            let ahead = x.max(zero);
            let beside = y.mul_add(y, ahead * ahead);
            let least = (from.far * to.far) * L::F64x8::splat(NEAR_AXIS);
            self.beside = self.beside.min(beside - least);
            self.corner = self.corner.min(to.far);
            self.multiply(x, y);
            from = to;
        }
        // It is enough to normalize here, because the products of a single loop stay in range.
        // Infinite products become NaN.
        let inverse = L::F64x8::splat(1.0) / (self.re.abs() + self.im.abs());
        self.re = self.re * inverse;
        self.im = self.im * inverse;
    }

    #[inline(always)]
    fn multiply(&mut self, x: L::F64x8, y: L::F64x8) {
        let (zero, one) = (L::F64x8::splat(0.0), L::F64x8::splat(1.0));
        let re = self.re.mul_add(x, -(self.im * y));
        let im = self.re.mul_add(y, self.im * x);
        // If two angles on the same side of 0 have a sum on the other side, a turn was completed.
        let (was, by, is) = (self.im.lt(zero), y.lt(zero), im.lt(zero));
        let up = L::F64x8::select(!was & !by & is, one, zero);
        self.turns = self.turns + L::F64x8::select(was & by & !is, -one, up);
        (self.re, self.im) = (re, im);
    }

    /// Returns a mask of the points at which the product's argument is certainly not half a turn,
    /// even with an error of `off` whole turns.
    #[inline(always)]
    fn is_certain(&self, off: L::F64x8) -> <L::F64x8 as Lanes>::Mask {
        let splat = L::F64x8::splat;
        // tan 2πx ≤ 8x for x up to 1/8.
        let is_clear = self.im.abs().gt(-(self.re * off * splat(8.0))) & off.le(splat(0.125));
        is_clear & self.beside.gt(splat(0.0)) & self.corner.gt(splat(NEAR_CORNER))
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::{Lanes, Level, Simd, Vec3, WithSimd};
    use intertri::{Triangle64, TriangleOf};

    use super::{FAR, POINTS, WholeTurns};
    use crate::solid::angle::turns;
    use crate::solid::boundary::Boundary;
    use crate::solid::classify::WINDING_DIR;
    use crate::util::test_numbers::random;

    /// Runs the first pass only.
    struct First<'a>(WholeTurns<'a, f64>);
    impl WithSimd for First<'_> {
        type Output = ([f64; POINTS], u32);
        #[inline(always)]
        fn run<L: Simd>(self) -> Self::Output {
            let points = Vec3::load(&self.0.points);
            let (turns, sure) = self.0.rounded::<L>(points, FAR[0]);
            let mut all = [0.0; POINTS];
            turns.store(&mut all);
            (all, sure)
        }
    }

    /// Returns triangle fans of the given size, side by side, each with `count` edges.
    fn fans(count: usize, fans: usize, size: f64) -> Vec<Triangle64> {
        let fan = |k: usize| {
            let corner = move |i: usize| {
                let angle = (i % count) as f64 / count as f64 * std::f64::consts::TAU;
                let (x, z) = (angle.cos() + 2.5 * k as f64, angle.sin() + 0.4 * k as f64);
                [x, 0.3 * (7.0 * angle).sin(), z].map(|x| x * size)
            };
            let middle = [0.1 + 2.5 * k as f64, 0.2, 0.4 * k as f64].map(|x| x * size);
            (0..count).map(move |i| TriangleOf([middle, corner(i), corner(i + 1)]))
        };
        (0..fans).flat_map(fan).collect()
    }

    /// Returns a random point whose kind depends on `i`: anywhere around the fans, next to an edge
    /// or corner, on a ray that passes close to an edge, or with a sum close to one half.
    fn point(
        fans: &[Triangle64],
        boundary: &Boundary<f64>,
        i: usize,
        size: f64,
        random: &mut impl FnMut() -> f64,
    ) -> [f64; 3] {
        let TriangleOf([_, a, b]) = fans[(random() * fans.len() as f64) as usize];
        let at = |share: f64| [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
        let mut anywhere = |reach: f64| [0; 3].map(|_| reach * size * (random() - 0.5));
        let near = [1e-3, 1e-5, 1e-9][i / 5 % 3];
        let beside = anywhere(near);
        match i % 5 {
            0 => anywhere([3.0, 8.0, 60.0][i / 5 % 3]),
            1 => [0, 1, 2].map(|k| at(0.5)[k] + beside[k]),
            2 => [0, 1, 2].map(|k| at(0.0)[k] + beside[k]),
            3 => [0, 1, 2].map(|k| at(0.3)[k] - size * f64::from(WINDING_DIR[k]) + beside[k]),
            _ => {
                // Bisect between two points whose sums are on either side of one half.
                let (mut a, mut b) = (anywhere(3.0), anywhere(3.0));
                let side = |point| turns(boundary, point).rem_euclid(1.0) < 0.5;
                for _ in 0..2 + i / 5 % 16 {
                    let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
                    if side(middle) == side(a) { a = middle } else { b = middle }
                }
                a
            }
        }
    }

    /// Checks that whole turns reported as certain agree with the sum over all edges, at every
    /// level and for every size.
    #[test]
    fn certain_turns_are_those_of_the_sum() {
        let mut numbers = random();
        let mut random = || f64::from(numbers());
        let (mut counts, mut first) = ([0; 2], [0; 2]);
        for (count, side_by_side) in [(3, 1), (16, 1), (17, 1), (40, 3), (129, 1), (600, 2)] {
            for size in [1e-90, 1e-50, 1.0, 1e50] {
                let fans = fans(count, side_by_side, size);
                let boundary = Boundary::of(&fans).unwrap();
                assert_eq!(boundary.edges(), count * side_by_side);
                for turn in 0..40 {
                    let points: [[f64; 3]; POINTS] = std::array::from_fn(|i| {
                        point(&fans, &boundary, POINTS * turn + i, size, &mut random)
                    });
                    let sums = points.map(|point| turns(&boundary, point));
                    let by_axis = [0, 1, 2].map(|k| points.map(|point| point[k]));
                    let of = || WholeTurns { boundary: &boundary, points: by_axis, asked: 0xff };
                    for level in Level::all() {
                        for (counts, (whole, sure)) in
                            [(&mut first, level.run(First(of()))), (&mut counts, level.run(of()))]
                        {
                            for i in 0..POINTS {
                                let is_sure = sure >> i & 1 == 1;
                                counts[usize::from(is_sure)] += 1;
                                let off = (sums[i] - whole[i]).abs();
                                assert!(
                                    !is_sure || off < 0.5,
                                    "{count}: {} for {} at {:?}",
                                    whole[i],
                                    sums[i],
                                    points[i]
                                );
                            }
                        }
                    }
                }
            }
        }
        // At extreme sizes, nothing is certain. For points next to edges or with a sum near one
        // half, many results are uncertain, and some become certain only in a later pass.
        let [open, sure] = counts;
        assert!(open > 1000 && sure > open && first[1] < sure - 20, "{first:?} {counts:?}");
    }

    /// Checks that the whole turns that are certain after all passes agree with the sum over all
    /// edges, at every level. Returns the number of certain results. Ignores points whose sum is
    /// within rounding error of one half.
    fn count_certain(boundary: &Boundary<f64>, points: [[f64; 3]; POINTS]) -> usize {
        let by_axis = [0, 1, 2].map(|k| points.map(|point| point[k]));
        let sums = points.map(|point| turns(boundary, point));
        let mut certain = 0;
        for level in Level::all() {
            let (whole, sure) = level.run(WholeTurns { boundary, points: by_axis, asked: 0xff });
            for i in 0..POINTS {
                let is_half = ((sums[i] - 0.5).rem_euclid(1.0) - 0.5).abs() > 0.5 - 1e-13;
                if sure >> i & 1 == 1 && !is_half {
                    certain += 1;
                    let off = (sums[i] - whole[i]).abs();
                    assert!(off < 0.5, "{} for {} at {:?}", whole[i], sums[i], points[i]);
                }
            }
        }
        certain
    }

    /// Returns a sphere around the origin that consists of small triangles with gaps between them,
    /// so that each triangle is a loop of its own.
    fn shards(size: f64) -> Vec<Triangle64> {
        let mut all: Vec<[[f64; 3]; 3]> = Vec::new();
        for i in 0..8 {
            let [x, y, z] = [1, 2, 4].map(|bit| if i & bit == 0 { 1.0 } else { -1.0 });
            let corners = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
            all.push(if x * y * z > 0.0 { corners } else { [corners[1], corners[0], corners[2]] });
        }
        let middle = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
        for _ in 0..3 {
            let quarters = |[a, b, c]: [[f64; 3]; 3]| {
                let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            };
            all = all.into_iter().flat_map(quarters).collect();
        }
        let shard = |corners: [[f64; 3]; 3]| {
            let corners = corners.map(|c| {
                let far = c.iter().map(|x| x * x).sum::<f64>().sqrt();
                c.map(|x| x / far)
            });
            let center = [0, 1, 2].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / 3.0);
            TriangleOf(
                corners.map(|c| [0, 1, 2].map(|k| size * (center[k] + 0.97 * (c[k] - center[k])))),
            )
        };
        all.into_iter().map(shard).collect()
    }

    /// Tests many distant loops that each add little but together add almost a whole turn. Their
    /// cluster must not count as far, even if squares of their areas overflow or underflow.
    #[test]
    fn many_distant_loops_are_not_far() {
        let mut random = random();
        let sizes = [1.0].into_iter();
        let sizes = sizes.chain((0..20).map(|i| 1e77 * 1.1_f64.powi(i)));
        for size in sizes.chain((0..20).map(|i| 3e-81 * 1.1_f64.powi(i))) {
            let boundary = Boundary::of(&shards(size)).unwrap();
            assert_eq!(boundary.edges(), 3 * 512);
            for _ in 0..5 {
                let points = [0; POINTS].map(|_| [0; 3].map(|_| 0.05 * size * f64::from(random())));
                let certain = count_certain(&boundary, points);
                assert!(size != 1.0 || certain > 0);
            }
        }
    }

    /// Tests distant rays: a ray through the tip of a triangle may be as far from the centre of the
    /// bounding sphere as the tip is, up to a rounding error that exceeds the margin of the radius.
    #[test]
    fn rays_through_the_tip_of_a_distant_loop() {
        let mut numbers = random();
        let mut random = || f64::from(numbers());
        for _ in 0..20_000 {
            let corners = [0; 3].map(|_| [0; 3].map(|_| random()));
            let boundary = Boundary::of(&[TriangleOf(corners)]).unwrap();
            let middle = boundary.clusters.clusters[0].middle;
            let far =
                |c: &[f64; 3]| [0, 1, 2].map(|k| (c[k] - middle[k]).powi(2)).iter().sum::<f64>();
            let tip = *corners.iter().max_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
            let center = [0, 1, 2].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / 3.0);
            let share = 0.5_f64.powi((20.0 * random()) as i32);
            let away = 4.0 * 1e6_f64.powf(random());
            let point = [0, 1, 2]
                .map(|k| tip[k] + share * (center[k] - tip[k]) - away * f64::from(WINDING_DIR[k]));
            // Use the same point eight times, because a cluster is skipped only if it is far from
            // all points.
            count_certain(&boundary, [point; POINTS]);
        }
    }

    /// Tests points next to a corner at the origin, where squared distances are 0 or subnormal with
    /// few significant digits.
    #[test]
    fn points_whose_distance_has_no_square() {
        let mut numbers = random();
        let mut random = || f64::from(numbers());
        for i in 0..20_000 {
            let [a, b] = [0; 2].map(|_| [0; 3].map(|_| random() - 0.5));
            let boundary = Boundary::of(&[TriangleOf([[0.0; 3], a, b])]).unwrap();
            let size = 2.0_f64.powi(-545 + i % 20);
            let points = [0; POINTS].map(|_| {
                // Choose points slightly above the triangle, where the sum is close to one half.
                let [x, y, height] = [random(), random(), 0.5_f64.powf(8.0 * random())];
                [0, 1, 2].map(|k| size * (x * a[k] + y * b[k] + height * (random() - 0.5)))
            });
            count_certain(&boundary, points);
        }
    }

    /// Tests rays that pass close to a corner and whose sum is close to one half, so that the
    /// rounding errors of edges decide the result.
    #[test]
    fn nearly_a_half_beside_a_corner() {
        let mut numbers = random();
        let mut random = || f64::from(numbers());
        let mut passed = 0;
        for _ in 0..20_000 {
            let corners: [[f64; 3]; 5] = [0; 5].map(|_| [0; 3].map(|_| random() - 0.5));
            let fan = [1, 2, 3].map(|i| TriangleOf([corners[0], corners[i], corners[i + 1]]));
            let boundary = Boundary::of(&fan).unwrap();
            let near = 2.0_f64.powi(-15 - (5.0 * random()) as i32);
            let off = [0; 3].map(|_| near * (random() - 0.5));
            let at = |s: f64| {
                [0, 1, 2].map(|k| corners[0][k] + s * (off[k] - f64::from(WINDING_DIR[k])))
            };
            let above = |s: f64| turns(&boundary, at(s)).rem_euclid(1.0) - 0.5;
            // Find two positions whose sums are on either side of one half, not of an integer.
            let places = [0; 16].map(|_| 0.02 + 1.5 * random());
            let half = |s: &f64| above(*s).abs() < 0.25;
            let Some(mut a) = places.into_iter().find(half) else { continue };
            let differs = |s: &f64| half(s) && (above(*s) < 0.0) != (above(a) < 0.0);
            let Some(mut b) = places.into_iter().find(differs) else { continue };
            for _ in 0..20 + (26.0 * random()) as usize {
                let middle = 0.5 * (a + b);
                if (above(middle) < 0.0) == (above(a) < 0.0) { a = middle } else { b = middle }
            }
            passed += 1;
            count_certain(&boundary, [at(a); POINTS]);
        }
        assert!(passed > 100, "{passed}");
    }
}
