//! Finds the points of a grid that lie on triangles, one triangle at a time.
//!
//! ```text
//!       ·     ·     ·     ·          A triangle is viewed along the axis closest to its normal. On each
//!             ┌───╱┐                 grid line along this axis, only points near the plane are tested.
//!       ·     │ ╱  │·     ·
//!             ╱────┘                 For a needle, only points near its longest edge are tested.
//!       ·     ·     ·     ·
//! ```

use std::cmp::Ordering;

use intertri::internal::exact::is_on;
use intertri::{LeafSlot, Scalar, TriangleOf};

use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::util::lane_ops::lanes_of;
use crate::util::memory::NoMemory;
use crate::util::{stop, threads};

/// The number of leaves that a thread processes per task.
const LEAVES: usize = 1 << 7;

/// A factor in the error bound of a plane: if M is the longest side of a triangle's box and N the
/// largest component of its normal, the error in the plane's height is less than this value times
/// `M³ / N`; see `docs/numerics/winding.md`, section 7.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// If N is less than `ROUNDING` times M², no point of the triangle is farther than this value times
/// M from the line through its longest edge.
const WIDTH: f64 = 8.0 * ROUNDING;

/// For boxes outside this range of sizes, all points are tested, because products of three side
/// lengths may underflow or overflow.
const SIZES: [f64; 2] = [1e-90, 1e90];

/// The ascending coordinates along each axis.
type Axes<'a, S> = [&'a [S]; 3];

/// Returns the indices of the points that lie on triangles. If several triangles contain a point,
/// its index may occur several times.
pub(super) fn points_on_triangles<S: BvhScalar>(
    bvh: &Bvh<S>,
    axes: Axes<'_, S>,
) -> Result<Vec<usize>, NoMemory> {
    let leaves = &bvh.tree.leaves;
    let mut pieces: Vec<Result<Vec<usize>, NoMemory>> = Vec::new();
    pieces.resize_with(leaves.len().div_ceil(LEAVES), || Ok(Vec::new()));
    threads::pieces(pieces.iter_mut(), |piece, found| {
        let first = piece * LEAVES;
        let mut on = Vec::new();
        for (i, leaf) in (first..).zip(leaves[first..].iter().take(LEAVES)) {
            for lane in lanes_of(leaf.block.live()) {
                let triangle = bvh.triangle_in(LeafSlot((8 * i + lane) as u32));
                if add_points(&triangle, axes, &mut on).is_err() {
                    *found = Err(NoMemory);
                    return;
                }
            }
        }
        *found = Ok(on);
    });
    let mut all = Vec::new();
    for piece in pieces {
        let piece = piece?;
        all.try_reserve(piece.len())?;
        all.extend_from_slice(&piece);
    }
    Ok(all)
}

/// Adds the indices of the points that lie on a triangle.
fn add_points<S: Scalar>(
    triangle: &TriangleOf<S>,
    axes: Axes<'_, S>,
    on: &mut Vec<usize>,
) -> Result<(), NoMemory> {
    // Find the range of grid points in the triangle's box.
    let mut ranges = [const { 0..0 }; 3];
    for k in 0..3 {
        let mut corners = triangle.0.map(|corner| corner[k]);
        corners.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
        let [low, _, high] = corners;
        ranges[k] = axes[k].partition_point(|x| *x < low)..axes[k].partition_point(|x| *x <= high);
        if ranges[k].is_empty() {
            return Ok(());
        }
    }
    let mut add = |point: [usize; 3]| -> Result<(), NoMemory> {
        if is_on(triangle, [0, 1, 2].map(|k| axes[k][point[k]])) {
            on.try_reserve(1)?;
            on.push((point[0] * axes[1].len() + point[1]) * axes[2].len() + point[2]);
        }
        Ok(())
    };
    let shape = Shape::of(triangle);
    let at = |k: usize, i: usize| Into::<f64>::into(axes[k][i]) - shape.origin[k];
    // Select the points on a line that are near a height, or all points if the height is NaN.
    let near = |k: usize, height: f64| {
        let (range, [low, high]) = (ranges[k].clone(), [height - shape.room, height + shape.room]);
        let lower = |x: &S| Into::<f64>::into(*x) - shape.origin[k] < low;
        let higher = |x: &S| Into::<f64>::into(*x) - shape.origin[k] > high;
        let line = &axes[k][range.clone()];
        let first = line.partition_point(lower);
        range.start + first..range.start + line.partition_point(|x| !higher(x)).max(first)
    };
    let [p, q, r] = [1, 2, 0].map(|k| (shape.axis + k) % 3);
    let [along_p, along_q, along_r] = [p, q, r].map(|k| shape.vector[k]);
    let mut point = [0; 3];
    if shape.is_needle {
        for i in ranges[r].clone() {
            point[r] = i;
            let part = at(r, i) / along_r;
            for j in near(p, along_p * part) {
                point[p] = j;
                for k in near(q, along_q * part) {
                    point[q] = k;
                    add(point)?;
                }
            }
        }
        return Ok(());
    }
    for i in ranges[p].clone() {
        stop::heed();
        point[p] = i;
        for j in ranges[q].clone() {
            point[q] = j;
            for k in near(r, -(along_p * at(p, i) + along_q * at(q, j)) / along_r) {
                point[r] = k;
                add(point)?;
            }
        }
    }
    Ok(())
}

/// Describes where the grid points that lie on a triangle can be: near a plane or near a line.
struct Shape {
    /// A corner of the triangle.
    origin: [f64; 3],
    /// The normal of the plane or the direction of the line.
    vector: [f64; 3],
    /// The axis of the vector's largest component.
    axis: usize,
    is_needle: bool,
    /// The largest distance of the points from the plane or line, measured along an axis.
    room: f64,
}

impl Shape {
    fn of<S: Scalar>(triangle: &TriangleOf<S>) -> Self {
        let corners = triangle.0.map(|corner| corner.map(Into::<f64>::into));
        let [a, b, c] = corners;
        let edges = [[a, b], [b, c], [c, a]].map(|[a, b]| [0, 1, 2].map(|k| b[k] - a[k]));
        let largest = |v: [f64; 3]| {
            let sizes = v.map(f64::abs);
            (0..3).max_by(|&i, &j| sizes[i].total_cmp(&sizes[j])).unwrap_or(0)
        };
        // Find the longest side of the box and the edge that spans it.
        let side = |i: usize| edges[i][largest(edges[i])].abs();
        let longest = (0..3).max_by(|&i, &j| side(i).total_cmp(&side(j))).unwrap_or(0);
        let size = side(longest);

        let [u, v] = [edges[0], edges[2]];
        let normal =
            [v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0]];
        let axis = largest(normal);
        let height = normal[axis].abs();
        let plane = Self { origin: a, vector: normal, axis, is_needle: false, room: f64::INFINITY };
        if !(SIZES[0]..SIZES[1]).contains(&size) {
            plane
        } else if height >= ROUNDING * size * size {
            Self { room: ROUNDING * size * size * size / height, ..plane }
        } else {
            let (origin, vector) = (corners[longest], edges[longest]);
            let (axis, room) = (largest(vector), WIDTH * size);
            Self { origin, vector, axis, is_needle: true, room }
        }
    }
}

#[cfg(test)]
mod tests {
    use intertri::TriangleOf;
    use intertri::internal::exact::is_on;

    use super::{Shape, add_points};
    use crate::util::test_numbers::random;

    /// Tests triangles of all widths, down to needles as thin as a rounding error, against grids
    /// that pass through points on them and next to them.
    #[test]
    fn all_points_on_needles_are_found() {
        let mut random = random();
        let mut number = move || f64::from(random());
        let (mut found_on_needles, mut found_on_others) = (0, 0);
        for round in 0..400 {
            let mut point = || [0; 3].map(|_| (number() * 64.0).round() / 8.0 - 4.0);
            let (a, b) = (point(), point());
            let mut c = [0, 1, 2].map(|k| 0.5 * a[k] + 0.5 * b[k]);
            // Make the triangle one ulp wide, or wider.
            let steps = if round % 2 == 0 { 1 } else { 1 << (round % 50) };
            c[round % 3] = f64::from_bits(c[round % 3].to_bits() + steps);
            let triangle = TriangleOf([a, b, c]);
            let mut axes = [const { Vec::new() }; 3];
            for i in 0..=8 {
                let (s, t) = (f64::from(i) / 8.0, if i % 3 == 0 { 0.0 } else { number() * 0.125 });
                for k in 0..3 {
                    let x = a[k] + s * (b[k] - a[k]) + t * (c[k] - b[k]);
                    axes[k].extend([x.next_down(), x, x.next_up()]);
                }
            }
            for axis in &mut axes {
                axis.sort_unstable_by(f64::total_cmp);
            }
            let [x, y, z] = &axes;
            let mut found = Vec::new();
            add_points(&triangle, [x, y, z], &mut found).unwrap();
            found.sort_unstable();
            let all = (0..x.len() * y.len() * z.len()).filter(|i| {
                let plane = i / z.len();
                is_on(&triangle, [x[plane / y.len()], y[plane % y.len()], z[i % z.len()]])
            });
            assert!(found.iter().copied().eq(all), "{triangle:?}");
            let is_needle = Shape::of(&triangle).is_needle;
            *(if is_needle { &mut found_on_needles } else { &mut found_on_others }) += found.len();
        }
        assert!(
            found_on_needles > 1000 && found_on_others > 1000,
            "{found_on_needles} {found_on_others}"
        );
    }
}
