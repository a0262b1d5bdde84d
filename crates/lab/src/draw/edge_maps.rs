//! Draws edge maps. Each shows rays one f32 step apart around a shared edge or a shared vertex,
//! coloured by the triangles that they hit.

use intertri::simd::Level;
use intertri::{Ray, Triangle};
use intertri_reference::THRESHOLD;

use super::marks::{in_order, is_kernel};
use super::svg::{Anchor, Font, GREY, Svg, width};
use crate::methods::Method;
use crate::oracle;
use crate::rng::step;
use crate::test_batch::{Answer, TestBatch};

/// The number of steps on either side of the centre.
const REACH: i32 = 16;
const PIXEL: f64 = 4.0;
const COLUMNS: usize = 9;

/// Two triangles that share an edge, or six triangles around a vertex, and a square grid of rays.
/// The rays share their origin, and the directions of neighbouring rays differ by one step in x or
/// in y.
struct Square {
    triangles: Vec<Triangle>,
    rays: Vec<Ray>,
}

/// The distance between neighbouring rays of a square.
#[derive(Clone, Copy)]
enum Step {
    /// One f32 step.
    Single,
    /// One grid step of a direction in the `fixed` mode.
    Grid,
}

impl Square {
    fn new(by: Step, triangles: Vec<Triangle>, target: [f32; 3]) -> Self {
        // The coordinates of the origin have no special bit patterns. The direction's length is the
        // distance to the target.
        let origin = [0.137_f32, -0.291, -2.713];
        let dir = [0, 1, 2].map(|k| target[k] - origin[k]);
        let moved = |x: f32, steps: i32| match by {
            Step::Single => step(x, steps),
            // The longest component of the direction is between 2 and 4 and has 18 bits on the
            // grid, so one grid step is 2^-16.
            Step::Grid => x + steps as f32 / 65_536.0,
        };
        let at =
            |(i, j): (i32, i32)| Ray::new(origin, [moved(dir[0], i), moved(dir[1], -j), dir[2]]);
        let square = (-REACH..=REACH).flat_map(|j| (-REACH..=REACH).map(move |i| (i, j)));
        Self { triangles, rays: square.map(at).collect() }
    }

    /// Creates a square across a slanted edge.
    fn edge(by: Step) -> Self {
        let (a, b) = ([-0.731, -0.583, 0.217], [0.612, 0.877, 0.389]);
        let (left, right) = ([-0.893, 0.671, 0.118], [0.934, -0.428, 0.253]);
        let target = [0, 1, 2].map(|k| a[k] + 0.457 * (b[k] - a[k]));
        Self::new(by, vec![Triangle([a, b, left]), Triangle([b, a, right])], target)
    }

    /// Creates a square around a vertex of six triangles.
    fn vertex(by: Step) -> Self {
        let middle = [0.0713, 0.0519, 0.1937];
        let around = [
            [0.913, 0.127, 0.311],
            [0.417, 0.829, 0.253],
            [-0.457, 0.761, 0.157],
            [-0.871, -0.071, 0.283],
            [-0.389, -0.823, 0.331],
            [0.503, -0.751, 0.227],
        ];
        let triangle = |k: usize| Triangle([middle, around[k], around[(k + 1) % 6]]);
        Self::new(by, (0..6).map(triangle).collect(), middle)
    }

    /// Returns, for each ray, a bit mask of the triangles that it hits according to the oracle.
    fn by_oracle(&self) -> Vec<u32> {
        let hit = |ray: &Ray| {
            let bit = |(k, t): (usize, &Triangle)| u32::from(oracle::answer(t, ray).is_hit()) << k;
            self.triangles.iter().enumerate().map(bit).sum()
        };
        self.rays.iter().map(hit).collect()
    }

    /// Returns, for each ray, a bit mask of the triangles that it hits according to a method. For
    /// `fixed`, all inputs are snapped to one grid.
    fn by(&self, method: &Method) -> Vec<u32> {
        let mut sets = vec![0; self.rays.len()];
        for (k, triangle) in self.triangles.iter().enumerate() {
            if method.name == "fixed" {
                let batch =
                    TestBatch { rays: self.rays.clone(), triangles: self.triangles.clone() };
                let on_grid = crate::methods::on_grid(&batch).unwrap_or(batch);
                // The method snaps each pair to the finest grid for that pair, which gives the same
                // answer as the common grid.
                let to = ask(method, on_grid.triangles[k], &on_grid.rays);
                sets.iter_mut().zip(to).for_each(|(set, a)| *set |= u32::from(a.hit) << k);
            } else {
                let to = ask(method, *triangle, &self.rays);
                sets.iter_mut().zip(to).for_each(|(set, a)| *set |= u32::from(a.hit) << k);
            }
        }
        sets
    }
}

fn ask(method: &Method, triangle: Triangle, rays: &[Ray]) -> Vec<Answer> {
    let mut to = vec![Answer::default(); rays.len()];
    method.pairs(Level::best(), THRESHOLD, &vec![triangle; rays.len()], rays, &mut to);
    to
}

/// Returns the colour for a set of triangles: alternating pale colours for a single triangle, black
/// for none, and orange for two or more.
fn colour(set: u32) -> &'static str {
    match set.count_ones() {
        0 => "#000000",
        1 if set.trailing_zeros().is_multiple_of(2) => "#A6CEE8",
        1 => "#F6DFA0",
        _ => "#D55E00",
    }
}

/// Draws two maps, one of the edge and one of the vertex, for the oracle and for each method.
pub fn edge_maps(caption: &str) -> Svg {
    let (edge, vertex) = (Square::edge(Step::Single), Square::vertex(Step::Single));
    let mut columns = vec![("the oracle", edge.by_oracle(), vertex.by_oracle())];
    for method in in_order() {
        columns.push((method.name, edge.by(method), vertex.by(method)));
        if method.name == "fixed" {
            // On the grid, rays one f32 step apart would all coincide, so use grid steps instead.
            let (edge, vertex) = (Square::edge(Step::Grid), Square::vertex(Step::Grid));
            columns.push(("fixed, in grid steps", edge.by(method), vertex.by(method)));
        }
    }

    let side = PIXEL * f64::from(2 * REACH + 1);
    let [w, h] = [side + 26.0, 2.0 * side + 66.0];
    let bands = columns.len().div_ceil(COLUMNS);
    let mut svg = Svg::new(COLUMNS as f64 * w + 30.0, bands as f64 * h + 130.0);
    let title = "Around a shared edge and a shared vertex, in single f32 steps of the direction";
    svg.text([18.0, 30.0], title, Font::new(18.0, Anchor::Start).bold());
    let mut x = 18.0;
    for (set, text) in
        [(1, "one triangle"), (2, "its neighbour"), (3, "both: counted twice"), (0, "none: a leak")]
    {
        svg.rect([x, 44.0], [13.0, 13.0], colour(set));
        svg.frame([x, 44.0], [13.0, 13.0], "#888888");
        svg.text([x + 19.0, 55.0], text, Font::new(12.5, Anchor::Start));
        x += 50.0 + width(text, 12.5);
    }
    let numbers =
        "top: the edge; bottom: the vertex; under each: leaks / counted twice, of 1,089 rays";
    svg.text([x, 55.0], numbers, Font::new(12.5, Anchor::Start).fill(GREY));

    for (k, (name, edge, vertex)) in columns.iter().enumerate() {
        let [x, y] = [20.0 + w * (k % COLUMNS) as f64, 74.0 + h * (k / COLUMNS) as f64];
        let bold = is_kernel(name) || k == 0;
        let font = Font { bold, ..Font::new(12.0, Anchor::Start) };
        svg.text([x, y + 12.0], name, font);
        for (row, sets) in [edge, vertex].into_iter().enumerate() {
            let top = y + 18.0 + row as f64 * (side + 20.0);
            picture(&mut svg, [x, top], sets);
            let count = |of: fn(u32) -> bool| sets.iter().filter(|s| of(s.count_ones())).count();
            let text = format!("{} / {}", count(|n| n == 0), count(|n| n > 1));
            let font = Font::new(10.5, Anchor::Middle).fill(GREY);
            svg.text([x + side / 2.0, top + side + 13.0], &text, font);
        }
    }
    let font = Font::new(11.0, Anchor::Start).fill(GREY);
    for (k, line) in caption.lines().enumerate() {
        svg.text([18.0, 74.0 + bands as f64 * h + 18.0 + 14.0 * k as f64], line, font);
    }
    svg
}

/// Draws a map. Neighbouring pixels of the same colour in a row form one rectangle.
fn picture(svg: &mut Svg, [x, y]: [f64; 2], sets: &[u32]) {
    let side = (2 * REACH + 1) as usize;
    for (j, row) in sets.chunks(side).enumerate() {
        let mut start = 0;
        for run in row.chunk_by(|&a, &b| colour(a) == colour(b)) {
            let at = [x + PIXEL * start as f64, y + PIXEL * j as f64];
            // Overlap the next row to hide the seam between rows.
            let high = if j + 1 < side { 1.5 * PIXEL } else { PIXEL };
            svg.rect(at, [PIXEL * run.len() as f64, high], colour(run[0]));
            start += run.len();
        }
    }
    let side = PIXEL * side as f64;
    svg.frame([x, y], [side, side], "#888888");
}

#[cfg(test)]
mod tests {
    use super::{Square, Step};
    use crate::methods::FIXED;

    #[test]
    fn the_squares_lie_across_an_edge_and_a_vertex() {
        for by in [Step::Single, Step::Grid] {
            let (edge, vertex) = (Square::edge(by).by_oracle(), Square::vertex(by).by_oracle());
            let seen = |sets: &[u32], k: u32| sets.iter().filter(|&&set| set & 1 << k != 0).count();
            assert!((0..2).all(|k| seen(&edge, k) > 200));
            assert!((0..6).all(|k| seen(&vertex, k) > 20));
            assert!(edge.iter().chain(&vertex).all(|&set| set != 0), "the oracle must see no leak");
            for sets in [Square::edge(by).by(&FIXED), Square::vertex(by).by(&FIXED)] {
                assert!(sets.iter().all(|set| set.is_power_of_two()), "each ray hits one triangle");
            }
        }
    }
}
