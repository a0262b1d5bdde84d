//! Tests exactly whether a point on an integer grid is on a triangle.

/// Returns whether a point is on a triangle. The triangle may be degenerate, that is, a segment or
/// a point.
pub fn is_on(point: [i32; 3], corners: [[i32; 3]; 3]) -> bool {
    let sub = |a: [i32; 3], b: [i32; 3]| [0, 1, 2].map(|i| i128::from(a[i]) - i128::from(b[i]));
    let [a, b, c] = corners.map(|p| sub(p, point));
    let dot = |a: [i128; 3], b: [i128; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [i128; 3], b: [i128; 3]| {
        let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
        [minor(1, 2), minor(2, 0), minor(0, 1)]
    };
    let sides = [cross(b, c), cross(c, a), cross(a, b)];
    let normal = [0, 1, 2].map(|i| sides[0][i] + sides[1][i] + sides[2][i]);
    if normal == [0; 3] {
        // The corners are collinear, so the point must be on the segment between two of them.
        sides == [[0; 3]; 3] && (dot(a, b) <= 0 || dot(b, c) <= 0 || dot(c, a) <= 0)
    } else {
        dot(a, normal) == 0 && sides.iter().all(|&side| dot(side, normal) >= 0)
    }
}
