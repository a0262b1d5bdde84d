//! Arithmetic on placements: corners and boxes in world space, and rays in mesh space.
//!
//! ```text
//!   mesh ──► corners ((m0·x + m1·y) + m2·z) + m3     by definition, with four roundings
//!     ▲                      │ rounding error, seen from the mesh: η
//!     └── N ≈ A⁻¹ ── ray ◄───┘ plus rounding error and ‖I - N A‖: the sum widens boxes
//! ```
//!
//! `docs/numerics/instances.md` has the bounds and proofs.

use intertri::TriangleOf;
use intertri::simd::{Lanes, Vec3};

use super::mesh::Extent;

/// Half an ulp of 1 in f64.
const W: f64 = f64::EPSILON / 2.0;

/// The error of a world-space corner is at most this fraction of a sum: the magnitude of the last
/// term, which is rounded once, plus four times the magnitudes of the other terms, which are
/// rounded up to four times.
const CORNER: f64 = 1.02 * W;

/// World-space boxes are widened by this fraction of the sums that [`sizes`] returns.
const BOX: f64 = 20.0 * W;

/// A bound on the error of an origin in mesh space, as a fraction of the origin's magnitude times
/// the norm of the inverse.
const ORIGIN: f64 = 5.0 * W;

/// A bound on the error of a direction in mesh space, as a fraction of the direction's magnitude
/// times the norms of the inverse and of the matrix.
const DIR: f64 = 4.1 * W;

/// `ρ / (1 - ρ)` is at most this factor times ρ for ρ up to [`DEFECT`], including rounding.
const INVERSE: f64 = 1.01;

/// The largest acceptable relative error of a direction: 2^-10. It includes `‖I - N A‖`, which is
/// therefore no larger.
const DEFECT: f64 = 1.0 / 1024.0;

/// The error of an entry of `I - N A` is at most this fraction of the sum of its terms' magnitudes.
const PRODUCT: f64 = 5.0 * W;

/// This value exceeds the effect of underflow, even after multiplication by one of the fractions
/// above.
const TINY: f64 = 4.0 * f64::MIN_POSITIVE;

/// If a sum of magnitudes exceeds this (2^1000), its product with another such sum could overflow.
/// Entries of scaled inverses are between the inverse of this value and this value.
const ENORMOUS: f64 = f64::from_bits((1023 + 1000) << 52);

/// A factor that rounds sums of magnitudes up.
const UP: f64 = 1.0 + 1e-12;

/// The three rows of a 3×4 matrix, concatenated.
pub(super) type Matrix = [f64; 12];

/// Transforms a point of a mesh to world space, exactly as the scene defines it.
#[inline(always)]
pub(super) fn placed<D: Lanes>(m: &[D; 12], p: Vec3<D>) -> Vec3<D> {
    Vec3 {
        x: ((m[0] * p.x + m[1] * p.y) + m[2] * p.z) + m[3],
        y: ((m[4] * p.x + m[5] * p.y) + m[6] * p.z) + m[7],
        z: ((m[8] * p.x + m[9] * p.y) + m[10] * p.z) + m[11],
    }
}

/// Transforms a triangle of a mesh to world space.
#[inline]
pub(super) fn placed_triangle(m: &Matrix, corners: [[f64; 3]; 3]) -> TriangleOf<f64> {
    TriangleOf(corners.map(|corner| {
        let Vec3 { x, y, z } = placed(m, Vec3::<f64>::splat(corner));
        [x, y, z]
    }))
}

/// Returns, for each world axis, an upper bound on the sum of the magnitudes of a coordinate's
/// terms.
#[inline]
pub(super) fn sizes(m: &Matrix, extent: &Extent) -> [f64; 3] {
    let [x, y, z] = extent.largest();
    [0, 4, 8].map(|i| {
        (m[i].abs() * x + m[i + 1].abs() * y + m[i + 2].abs() * z + m[i + 3].abs()) * UP + TINY
    })
}

/// Returns a world-space box that contains the world-space corners, as the scene defines them, of
/// all triangles inside a box of the mesh. The result may be infinite.
#[inline(always)]
pub(super) fn world_box(m: &Matrix, [lo, hi]: [[f64; 3]; 2], sizes: &[f64; 3]) -> [[f64; 3]; 2] {
    let [mut from, mut to] = [[0.0; 3]; 2];
    // Transform the centre and half the size: |A| maps half the size to half the extent in world
    // space, whatever the signs of the matrix entries. Halving first keeps sums from overflowing.
    let middle = [0, 1, 2].map(|k| 0.5 * lo[k] + 0.5 * hi[k]);
    let half = [0, 1, 2].map(|k| 0.5 * hi[k] - 0.5 * lo[k]);
    for k in 0..3 {
        let row = &m[4 * k..4 * k + 4];
        let at = row[0] * middle[0] + row[1] * middle[1] + row[2] * middle[2] + row[3];
        let reach = row[0].abs() * half[0] + row[1].abs() * half[1] + row[2].abs() * half[2];
        let reach = reach + BOX * sizes[k];
        (from[k], to[k]) = (at - reach, at + reach);
    }
    [from, to]
}

/// A matrix N close to the inverse of a placement, which transforms rays to the units of a mesh's
/// tree, with error bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inverse {
    /// N times the tree's units per unit of the mesh.
    rows: [[f64; 3]; 3],
    /// The point of the world that is placed at the centre of the tree's units.
    from: [f64; 3],
    /// The largest distance outside a triangle's box at which its hits may lie, in the tree's units:
    /// for a ray that starts at `from`, and the additional distance per unit of the world between
    /// `from` and the origin of the ray. NaN if there is no useful inverse.
    room: [f64; 2],
}

/// Rays in the units of a tree, one per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeRay<D> {
    pub(super) origin: Vec3<D>,
    pub(super) dir: Vec3<D>,
    /// The largest distance outside a triangle's box at which its hits may lie.
    pub(super) room: D,
}

impl Inverse {
    /// The value for a placement that has no useful inverse.
    pub(super) const NONE: Self = Self { rows: [[0.0; 3]; 3], from: [0.0; 3], room: [f64::NAN; 2] };

    /// Computes the inverse of a matrix for a mesh whose tree has coordinates in ±`reach`.
    pub(super) fn new(m: &Matrix, extent: &Extent, reach: f32) -> Self {
        let a = [0, 4, 8].map(|i| [m[i], m[i + 1], m[i + 2]]);
        let rows = near_inverse(a);
        // The residual bounds the error of any N, so the elimination itself needs no proof.
        let defect = defect(&rows, &a);
        let sizes = sizes(m, extent);
        if sizes.iter().any(|&size| size > ENORMOUS) {
            return Self::NONE;
        }
        let (mut size, mut corner) = (0.0_f64, 0.0_f64);
        // The last summand is rounded once and the others four times. This is bound (1) in the
        // proof, without the factor w.
        let rounded = [0, 1, 2].map(|i| 4.0 * sizes[i] - 3.0 * m[4 * i + 3].abs());
        for [x, y, z] in rows.map(|row| row.map(f64::abs)) {
            size = size.max(x + y + z);
            corner = corner.max(x * rounded[0] + y * rounded[1] + z * rounded[2]);
        }
        let row = |[x, y, z]: [f64; 3]| x.abs() + y.abs() + z.abs();
        let forth = row(a[0]).max(row(a[1])).max(row(a[2]));
        let dir = (INVERSE * defect + DIR * size * forth) * UP;
        // The scale is a power of two, so multiplying by it is exact unless an entry overflows or
        // underflows.
        let (scale, centre) = (extent.scale, extent.centre);
        let scaled = rows.map(|row| row.map(|x| x * scale));
        let limits = 1.0 / ENORMOUS..=ENORMOUS;
        let is_exact = |(&x, scaled): (&f64, &f64)| x == 0.0 || limits.contains(&scaled.abs());
        let mut entries = rows.as_flattened().iter().zip(scaled.as_flattened());
        // The comparison is false for NaN.
        if !(dir <= DEFECT && entries.all(is_exact)) {
            return Self::NONE;
        }
        // The centre is placed like a corner, with an error no larger than that of a corner.
        let is_centred = centre.iter().all(|&x| x == 0.0);
        let Vec3 { x, y, z } = placed(m, Vec3::<f64>::splat(centre));
        let corner = CORNER * corner * if is_centred { 1.0 } else { 2.0 };
        // (3) in the proof: the errors of the corners and the origin, plus the effect of the
        // direction's error at the far side of the mesh.
        let (corner, size) = (corner * scale, size * scale);
        let origin = size * (INVERSE * defect + ORIGIN);
        let room = corner + INVERSE * dir * (f64::from(reach) + corner);
        let per_distance = origin + INVERSE * dir * (INVERSE * size + origin);
        let room = [room, per_distance].map(|x| x * UP);
        if !room.iter().all(|x| x.is_finite()) {
            return Self::NONE;
        }
        Self { rows: scaled, from: [x, y, z], room }
    }

    /// Returns whether rays can be transformed to mesh space.
    #[inline(always)]
    pub(super) fn is_useful(&self) -> bool {
        !self.room[0].is_nan()
    }

    /// Transforms rays to the units of the mesh's tree, whose coordinates range over ±`reach`. The
    /// mask marks the rays whose error bounds are small enough; it is empty if there is no useful
    /// inverse.
    #[inline(always)]
    pub(super) fn tree_ray<D: Lanes<Scalar = f64>>(
        &self,
        [origin, dir]: [Vec3<D>; 2],
        reach: f32,
    ) -> (TreeRay<D>, D::Mask) {
        let (splat, reach) = (D::splat, D::splat(reach.into()));
        let from = origin - Vec3::splat(self.from);
        let (origin, dir) = (times(&self.rows, from), times(&self.rows, dir));
        let room = (splat(self.room[0]) + splat(self.room[1]) * largest(from)) * splat(UP);
        // A margin of one hundredth of the mesh's size costs little. With a much larger margin,
        // traversal in world space is faster.
        (TreeRay { origin, dir, room }, room.le(splat(0.25) * reach))
    }
}

/// Returns the largest magnitude of a coordinate; arbitrary if a coordinate is NaN.
#[inline(always)]
pub(super) fn largest<D: Lanes>(v: Vec3<D>) -> D {
    v.x.abs().max(v.y.abs()).max(v.z.abs())
}

/// Multiplies a 3×3 matrix by vectors.
#[inline(always)]
fn times<D: Lanes<Scalar = f64>>([a, b, c]: &[[f64; 3]; 3], v: Vec3<D>) -> Vec3<D> {
    let [a, b, c] = [Vec3::splat(*a), Vec3::splat(*b), Vec3::splat(*c)];
    Vec3 { x: a.dot_fused(v), y: b.dot_fused(v), z: c.dot_fused(v) }
}

/// Computes a matrix close to the inverse by Gaussian elimination with partial pivoting. The result
/// is arbitrary if the matrix is singular.
fn near_inverse(mut a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut n = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for k in 0..3 {
        let mut pivot = k;
        for i in k + 1..3 {
            if a[i][k].abs() > a[pivot][k].abs() {
                pivot = i;
            }
        }
        a.swap(k, pivot);
        n.swap(k, pivot);
        // A zero pivot produces infinities and NaNs, which the defect detects.
        let by = 1.0 / a[k][k];
        (a[k], n[k]) = (a[k].map(|x| x * by), n[k].map(|x| x * by));
        for i in (0..3).filter(|&i| i != k) {
            let by = a[i][k];
            for j in 0..3 {
                a[i][j] -= by * a[k][j];
                n[i][j] -= by * n[k][j];
            }
        }
    }
    n
}

/// Returns an upper bound on `‖I - N A‖`, the largest row sum of magnitudes.
fn defect(n: &[[f64; 3]; 3], a: &[[f64; 3]; 3]) -> f64 {
    let mut worst = 0.0_f64;
    for (i, row) in n.iter().enumerate() {
        let mut sum = 0.0;
        for j in [0, 1, 2] {
            let one = if i == j { 1.0 } else { 0.0 };
            let [x, y, z] = [row[0] * a[0][j], row[1] * a[1][j], row[2] * a[2][j]];
            let sizes = x.abs() + y.abs() + z.abs() + one;
            sum += (one - x - y - z).abs() + PRODUCT * sizes + TINY;
        }
        // `max` would discard a NaN.
        if sum.is_nan() || sum > worst {
            worst = sum;
        }
        if worst.is_nan() {
            return worst;
        }
    }
    worst * UP
}

#[cfg(test)]
mod tests {
    use intertri::Ray64;
    use intertri::simd::Vec3;

    use super::{Inverse, Matrix, largest, placed};
    use crate::instances::mesh::Extent;
    use crate::util::test_numbers::random;

    const EXTENT: Extent =
        Extent { bounds: [[-1.0; 3], [1.0; 3]], centre: [0.0; 3], scale: 1.0, least: 1.0 };

    /// Tests that the rounding errors of corners placed far from the origin come close to the bound
    /// but never exceed it, without and with a centre, which is rounded as well. The matrix only
    /// translates and scales by a power of two, so its inverse is exact.
    #[test]
    fn corners_are_rounded_by_less_than_the_bound() {
        let mut random = random();
        let mut worst = [0.0_f64; 2];
        for i in 0..600_000 {
            let scale = (-10.0 - 20.0 * f64::from(random())).floor().exp2();
            let mut m: Matrix = [0.0; 12];
            for i in 0..3 {
                m[5 * i] = scale;
                // Relative rounding errors are largest just above a power of two.
                let far = 1.0 + 1e-3 * f64::from(random()) * f64::from(random());
                m[4 * i + 3] = far * (30.0 * f64::from(random())).floor().exp2();
            }
            let mut point = || [0; 3].map(|_| 2.0 * f64::from(random()) - 1.0);
            let (at, mut centre) = (point(), point());
            if i % 2 == 0 {
                centre = [0.0; 3];
            }
            let inverse = Inverse::new(&m, &Extent { centre, ..EXTENT }, 1.0);
            let Vec3 { x, y, z } = placed(&m, Vec3::<f64>::splat(at));
            for (k, corner) in [x, y, z].into_iter().enumerate() {
                let off = ((corner - inverse.from[k]) / scale - (at[k] - centre[k])).abs();
                let worst = &mut worst[i % 2];
                *worst = worst.max(off / inverse.room[0]);
            }
        }
        assert!(worst.iter().all(|&worst| worst < 1.0), "{worst:?}");
        // The bounds are tight: half of them would not be enough.
        assert!(worst.iter().all(|&worst| worst > 0.6), "{worst:?}");
    }

    /// Transforms rays that pass through world-space vertices back to mesh space. Each transformed
    /// ray must pass within its error bound of the original vertex. The matrix consists of small
    /// integers, so placing a vertex involves no rounding. Half of the rays start far away from a
    /// mesh at the origin: then nearly all of the bound is proportional to their distance.
    #[test]
    fn rays_in_the_frame_pass_within_their_room() {
        let mut random = random();
        let (mut compared, mut worst) = ([0; 2], [0.0_f64; 2]);
        for i in 0..600_000 {
            let is_far = i % 2;
            let mut whole = |most: f64| ((2.0 * f64::from(random()) - 1.0) * most).round();
            let size = whole(12.0).abs().exp2();
            let mut m: Matrix = [0.0; 12];
            for (i, m) in m.iter_mut().enumerate() {
                *m = match (i % 4, is_far) {
                    (3, 0) => whole(1e6),
                    (3, _) => 0.0,
                    _ => whole(size),
                };
            }
            // The ray runs from one vertex to another; mesh coordinates are multiples of 1/64.
            let [from, to] = [0; 2].map(|_| [0; 3].map(|_| whole(64.0) / 64.0));
            let away = if is_far == 1 { (10.0 + whole(8.0)).exp2() } else { 1.0 };
            let from = from.map(|x| x * away);
            let placed = |p| {
                let Vec3 { x, y, z } = placed(&m, Vec3::<f64>::splat(p));
                [x, y, z]
            };
            let (origin, end) = (placed(from), placed(to));
            let ray = Ray64::new(origin, [0, 1, 2].map(|k| end[k] - origin[k]));
            // A third of the trees have their own scale and centre.
            let mut extent = EXTENT;
            if i % 3 == 0 {
                (extent.scale, extent.centre) =
                    (whole(20.0).exp2(), [0; 3].map(|_| whole(64.0) / 64.0));
            }
            let Extent { scale, centre, .. } = extent;
            let inverse = Inverse::new(&m, &extent, scale as f32);
            let from = [ray.origin, ray.dir].map(Vec3::<f64>::splat);
            let (local, is_near) = inverse.tree_ray(from, scale as f32);
            if !is_near {
                continue;
            }
            compared[is_far] += 1;
            let (at, dir) = (local.origin, local.dir);
            let reached = [at.x + dir.x, at.y + dir.y, at.z + dir.z];
            let farthest = largest(at);
            for (k, reached) in reached.into_iter().enumerate() {
                let off = (reached - (to[k] - centre[k]) * scale).abs();
                // Subtract the rounding of the sum above.
                let off = off - 0.5 * f64::EPSILON * farthest;
                worst[is_far] = worst[is_far].max(off / local.room);
            }
        }
        assert!(compared.iter().all(|&count| count > 200_000), "{compared:?}");
        // Errors reach only a thirtieth of the bound, which adds up rounding errors of the residual
        // that hardly ever coincide. Without the part that grows with the distance, they exceed it.
        assert!(worst.iter().all(|&worst| worst < 1.0), "{worst:?}");
    }
}
