//! Finds the triangles to flip so that every connected piece of a mesh is oriented consistently and
//! outward.
//!
//! ```text
//!   ┌──▶──┬──◀──┐       If two triangles traverse their shared edge in the same direction, one of
//!   ▲     │▲▲   ▼       them is flipped. Pieces end at edges with one triangle or more than two.
//!   └──◀──┴──▶──┘
//! ```

use intertri::{Scalar, TriangleOf};

use super::Solid;
use super::edges::{Edges, is_finite};
use crate::build::BuildError;
use crate::scalar::BvhScalar;
use crate::util::memory::{NoMemory, filled, room};
use crate::util::stop;

/// The sign of a piece's volume is uncertain if the volume, relative to the cube around the piece,
/// is below this value times the number of triangles.
const FLAT: f64 = 64.0 * f64::EPSILON;

/// The pieces of a mesh and the triangles to flip, as found by [`Solid::orient`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Orientation {
    /// The triangles to flip, in ascending order.
    pub turned: Vec<usize>,
    /// The number of pieces. Triangles belong to the same piece if edges with exactly two triangles
    /// connect them.
    pub pieces: usize,
    /// The number of pieces with open edges. These pieces are oriented consistently, facing away
    /// from the centre of their bounding box.
    pub open: usize,
    /// The number of one-sided pieces, such as a Möbius strip. Their triangles are not flipped.
    pub one_sided: usize,
}

impl<S: BvhScalar> Solid<S> {
    /// Finds the triangles of a mesh to flip, by swapping two corners, so that each connected piece
    /// is oriented consistently and its corners run counter-clockwise as seen from outside. Each
    /// piece is considered separately, so the wall of a cavity is also turned outward. If a piece
    /// has no volume, the orientation that requires fewer flips is chosen.
    ///
    /// Triangles that are not finite are ignored.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    ///
    /// ```
    /// use intertri_trace::{Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// let mut faces = [[o, y, x], [x, o, z], [o, z, y], [x, z, y]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let orientation = Solid::orient(&faces)?;
    /// assert_eq!((orientation.turned.as_slice(), orientation.pieces), ([1, 3].as_slice(), 1));
    /// for triangle in orientation.turned {
    ///     faces[triangle].0.swap(1, 2);
    /// }
    /// assert!(Solid::new(&faces)?.classify([1.0; 3]).is_odd());
    /// # Ok::<(), intertri_trace::SolidError>(())
    /// ```
    pub fn orient(triangles: &[TriangleOf<S>]) -> Result<Orientation, BuildError> {
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count: triangles.len() };
        orient(triangles).map_err(out_of_memory)
    }
}

fn orient<S: Scalar>(triangles: &[TriangleOf<S>]) -> Result<Orientation, NoMemory> {
    let edges = Edges::of(triangles)?;
    let mut sets = Sets::of(triangles.len())?;
    for edge in edges.shared() {
        if let Some([(a, up), (b, other)]) = edge.pair() {
            sets.join(a, b, up == other);
        }
    }
    let mut pieces = filled(triangles.len(), Piece::default())?;
    for edge in edges.shared().filter(|edge| matches!(edge.counts(), [1, 0] | [0, 1])) {
        if let Some((triangle, ..)) = edge.first() {
            pieces[sets.root(triangle).0].is_open = true;
        }
    }
    drop(edges);
    let finite = || triangles.iter().enumerate().filter(|(_, triangle)| is_finite(triangle));
    for (i, triangle) in finite() {
        pieces[sets.root(i).0].hold(triangle);
    }
    for (i, triangle) in finite() {
        let (root, is_turned) = sets.root(i);
        pieces[root].add(triangle, is_turned);
    }
    let mut orientation = Orientation { turned: room(triangles.len())?, ..Orientation::default() };
    for (i, piece) in pieces.iter().enumerate().filter(|(_, piece)| piece.triangles > 0) {
        orientation.pieces += 1;
        orientation.open += usize::from(piece.is_open);
        orientation.one_sided += usize::from(sets.is_one_sided[i]);
    }
    for (i, _) in finite() {
        let (root, is_turned) = sets.root(i);
        if !sets.is_one_sided[root] && is_turned != pieces[root].is_inward() {
            orientation.turned.push(i);
        }
    }
    Ok(orientation)
}

/// A connected piece; its orientation follows its first triangle.
#[derive(Clone, Copy)]
struct Piece {
    lo: [f64; 3],
    hi: [f64; 3],
    /// Six times the signed volume between the centre of the piece's box and its triangles.
    volume: f64,
    triangles: usize,
    turned: usize,
    is_open: bool,
}

impl Default for Piece {
    fn default() -> Self {
        let (lo, hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        Self { lo, hi, volume: 0.0, triangles: 0, turned: 0, is_open: false }
    }
}

impl Piece {
    /// Extends the box to include a triangle.
    fn hold<S: Scalar>(&mut self, triangle: &TriangleOf<S>) {
        for corner in triangle.0 {
            for (k, x) in corner.map(Into::<f64>::into).into_iter().enumerate() {
                (self.lo[k], self.hi[k]) = (self.lo[k].min(x), self.hi[k].max(x));
            }
        }
    }

    fn size(&self) -> f64 {
        [0, 1, 2].map(|k| self.hi[k] - self.lo[k]).into_iter().fold(0.0, f64::max)
    }

    /// Adds a triangle, in coordinates relative to the box's centre and size.
    fn add<S: Scalar>(&mut self, triangle: &TriangleOf<S>, is_turned: bool) {
        let size = self.size();
        let [a, b, c] = triangle.0.map(|corner| {
            [0, 1, 2].map(|k| {
                let x: f64 = corner[k].into();
                (x - 0.5 * self.lo[k] - 0.5 * self.hi[k]) / size
            })
        });
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let volume = a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2];
        self.volume += if is_turned { -volume } else { volume };
        self.triangles += 1;
        self.turned += usize::from(is_turned);
    }

    fn is_inward(&self) -> bool {
        if self.volume.abs() > FLAT * self.triangles as f64 {
            self.volume < 0.0
        } else {
            2 * self.turned > self.triangles
        }
    }
}

/// A union-find structure over triangles that also tracks whether each is flipped relative to the
/// first triangle of its set.
struct Sets {
    /// For each triangle, another triangle in its set and whether the two have opposite
    /// orientations. The first triangle of a set refers to itself.
    to: Vec<(usize, bool)>,
    is_one_sided: Vec<bool>,
}

impl Sets {
    fn of(count: usize) -> Result<Self, NoMemory> {
        let mut to = room(count)?;
        to.extend((0..count).map(|i| (i, false)));
        Ok(Self { to, is_one_sided: filled(count, false)? })
    }

    /// Returns the first triangle of a triangle's set, and whether the two have opposite
    /// orientations.
    fn root(&mut self, triangle: usize) -> (usize, bool) {
        let (mut i, mut is_turned) = (triangle, false);
        while self.to[i].0 != i {
            let (next, turned) = self.to[i];
            // Path halving shortens future lookups.
            let (after, more) = self.to[next];
            self.to[i] = (after, turned != more);
            is_turned ^= turned != more;
            i = after;
        }
        (i, is_turned)
    }

    /// Connects two triangles. `is_turned` means that one of them must be flipped.
    fn join(&mut self, a: usize, b: usize, is_turned: bool) {
        stop::heed();
        let ((a, a_turned), (b, b_turned)) = (self.root(a), self.root(b));
        let is_turned = is_turned ^ a_turned ^ b_turned;
        if a == b {
            self.is_one_sided[a] |= is_turned;
            return;
        }
        let (first, second) = (a.min(b), a.max(b));
        self.to[second] = (first, is_turned);
        self.is_one_sided[first] |= self.is_one_sided[second];
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Triangle, TriangleOf};

    use super::{Orientation, Solid};
    use crate::util::test_numbers::random;

    /// Returns a sphere with the given centre.
    fn globe(at: [f32; 3]) -> Vec<Triangle> {
        let corner = |ring: usize, i: usize| {
            let (a, b) = (ring as f32 / 6.0, (i % 12) as f32 / 12.0);
            let (a, b) = (a * std::f32::consts::PI, b * std::f32::consts::TAU);
            let r = if ring.is_multiple_of(6) { 0.0 } else { a.sin() };
            [at[0] + r * b.cos(), at[1] + a.cos(), at[2] + r * b.sin()]
        };
        let squares = (0..72).map(|k| (k / 12, k % 12));
        let halves = |(ring, i)| {
            let [a, b] = [corner(ring, i), corner(ring, i + 1)];
            let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
            [TriangleOf([a, b, c]), TriangleOf([d, c, b])]
        };
        let has_area = |t: &Triangle| t.0[0] != t.0[1] && t.0[1] != t.0[2] && t.0[2] != t.0[0];
        squares.flat_map(halves).filter(has_area).collect()
    }

    fn turn(mesh: &mut [Triangle], triangles: &[usize]) {
        for &triangle in triangles {
            mesh[triangle].0.swap(0, 1);
        }
    }

    /// Flips random triangles of two spheres, one with a hole; `orient` must find exactly those.
    #[test]
    fn turned_triangles_are_turned_back() {
        let (near, far) = (globe([0.0; 3]), globe([5.0, 1.0, 0.3]));
        assert!(Solid::new(&near).unwrap().classify([0.0; 3]) == crate::Containment::Inside(1));
        let whole = [&near[..], &far[3..]].concat();
        let mut random = random();
        for share in [0.0, 0.1, 0.5, 1.0] {
            let mut mesh = whole.clone();
            let turned: Vec<usize> = (0..mesh.len()).filter(|_| random() < share).collect();
            turn(&mut mesh, &turned);
            let found = Solid::orient(&mesh).unwrap();
            assert_eq!(found, Orientation { turned, pieces: 2, open: 1, one_sided: 0 });
        }
    }

    /// Tests a band whose ends are joined with a half twist, which makes it one-sided. The band
    /// must stay unchanged, while other pieces are still oriented.
    #[test]
    fn a_twisted_band_has_one_side() {
        for (twist, one_sided) in [(false, 0), (true, 1)] {
            let corner = |i: usize, up: bool| {
                let angle = (i % 8) as f32 * std::f32::consts::FRAC_PI_4;
                let is_up = up != (twist && i == 8);
                [angle.cos(), if is_up { 0.2 } else { -0.2 }, angle.sin()]
            };
            let band = (0..8).flat_map(|i| {
                let [a, b] = [corner(i, false), corner(i, true)];
                let [c, d] = [corner(i + 1, false), corner(i + 1, true)];
                [TriangleOf([a, b, c]), TriangleOf([d, c, b])]
            });
            let mut mesh: Vec<Triangle> = band.collect();
            let count = mesh.len();
            mesh.extend(globe([4.0; 3]));
            turn(&mut mesh, &[2, count + 3]);
            let found = Solid::orient(&mesh).unwrap();
            assert_eq!((found.pieces, found.open, found.one_sided), (2, 1, one_sided));
            assert!(found.turned.contains(&(count + 3)));
            assert_eq!(found.turned.iter().any(|&i| i < count), !twist, "{found:?}");
        }
    }

    /// Checks that pieces end at edges with more than two triangles. Also tests flat pieces and
    /// extreme coordinates.
    #[test]
    fn any_triangles_have_pieces() {
        let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let pieces = |corners: &[[[f32; 3]; 3]]| {
            let mesh: Vec<Triangle> = corners.iter().map(|corners| TriangleOf(*corners)).collect();
            let found = Solid::orient(&mesh).unwrap();
            (found.turned, found.pieces, found.open)
        };
        assert_eq!(pieces(&[]), (vec![], 0, 0));
        assert_eq!(pieces(&[[o, x, y], [o, x, z], [x, o, y], [o, z, y]]).1, 2);
        assert_eq!(pieces(&[[o, x, y], [x, o, [1.0, -1.0, 0.0]]]), (vec![], 1, 1));
        assert_eq!(pieces(&[[o, x, [f32::NAN; 3]], [o, o, x]]).1, 1);
        let far = [[f32::MAX, 0.0, 0.0], [-f32::MAX, 1.0, 0.0], [0.0, f32::MAX, f32::MAX]];
        assert_eq!(pieces(&[far, [far[1], far[0], [0.0; 3]]]).1, 1);
    }
}
