//! Cuts polygons into triangles.
//!
//! A fan from the first corner works if that corner sees the whole polygon, as in every convex
//! polygon. Otherwise, triangles of the fan reach outside and overlap:
//!
//! ```text
//!   3 ·────· 2          The fan is (0,1,2), (0,2,3). It turns the wrong way at (0,1,2),
//!      \  /             which is outside the polygon. The cut 1-3 stays inside.
//!    0  \·  1
//! ```
//!
//! The `earcut` crate cuts the other polygons in the plane that fits them best, which is
//! perpendicular to Newell's normal, the sum of the cross products of the fan.

use earcut::Earcut;
use glam::{DVec2, DVec3};

use super::error::Fault;

/// Concave polygons with more corners than this are not cut, because the running time of `earcut`
/// may grow with the square of the number of corners.
const MOST: usize = 1 << 14;

/// A bound on the rounding error in a sum of a few products, relative to their sizes.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The result of cutting a polygon into triangles.
pub(super) enum Cut<'a> {
    /// A fan around the first corner.
    Fan,
    /// These triangles, each with three indices into the polygon's corners. A polygon with n
    /// corners has n - 2 triangles.
    Ears(&'a [u32]),
    /// The polygon cannot be cut reliably, because it crosses itself or has too many corners.
    Unclear,
}

/// A polygon cutter, which reuses its memory.
#[derive(Default)]
pub(super) struct Cutter {
    /// The corners relative to the first one.
    ring: Vec<DVec3>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    edges: Vec<[u32; 2]>,
    earcut: Earcut<f64>,
}

impl Cutter {
    /// Determines how to cut the polygon with these corners.
    pub(super) fn cut(
        &mut self,
        corners: impl ExactSizeIterator<Item = DVec3> + Clone,
    ) -> Result<Cut<'_>, Fault> {
        self.ring.clear();
        self.ring.try_reserve(corners.len())?;
        Ok(if self.place(corners) { self.cut_ring() } else { Cut::Fan })
    }

    /// Determines how to cut the ring.
    fn cut_ring(&mut self) -> Cut<'_> {
        let triangles = || self.ring.windows(2).skip(1).map(|pair| (pair[0], pair[1]));
        let normal: DVec3 = triangles().map(|(a, b)| a.cross(b)).sum();
        let length = normal.length();
        let sizes: f64 = triangles().map(|(a, b)| a.length() * b.length()).sum();
        if length <= self.ring.len() as f64 * ROUNDING * sizes {
            // The polygon has no orientation if it is a line or has loops that cancel.
            let is_flat =
                |(a, b): (DVec3, DVec3)| a.cross(b).length() <= ROUNDING * a.length() * b.length();
            return if triangles().all(is_flat) { Cut::Fan } else { Cut::Unclear };
        }
        let normal = normal / length;
        let is_inside =
            |(a, b): (DVec3, DVec3)| a.cross(b).dot(normal) >= -ROUNDING * a.length() * b.length();
        if triangles().all(is_inside) {
            return Cut::Fan;
        }
        if self.ring.len() > MOST {
            return Cut::Unclear;
        }
        self.clip_ears(normal);
        if self.close() && self.is_cut() { Cut::Ears(&self.ears) } else { Cut::Unclear }
    }

    /// Stores the corners relative to the first one, scaled so that the polygon's size is about
    /// one. Returns false if the corners are all the same point or are not finite. Both scaling
    /// factors are powers of two, so scaling does not round.
    fn place(&mut self, corners: impl Iterator<Item = DVec3> + Clone) -> bool {
        let largest = |points: &mut dyn Iterator<Item = DVec3>| {
            points.fold(0.0, |most: f64, p| most.max(p.abs().max_element()))
        };
        let is_finite = corners.clone().all(DVec3::is_finite);
        let scale = unit(largest(&mut corners.clone()));
        self.ring.extend(corners.map(|p| p * scale));
        let Some(&first) = self.ring.first().filter(|_| is_finite) else { return false };
        self.ring.iter_mut().for_each(|p| *p -= first);
        let size = largest(&mut self.ring.iter().copied());
        let scale = unit(size);
        self.ring.iter_mut().for_each(|p| *p *= scale);
        size > 0.0
    }

    /// Cuts the ring with `earcut` in the plane perpendicular to `normal`. All triangles get the
    /// orientation of the ring.
    fn clip_ears(&mut self, normal: DVec3) {
        // If the normal is along an axis, `across` and `up` are axes too, and the corners keep
        // their coordinates.
        let least = normal.abs();
        let axis = match least.min_element() {
            x if x == least.x => DVec3::X,
            y if y == least.y => DVec3::Y,
            _ => DVec3::Z,
        };
        let across = axis.cross(normal).normalize();
        let up = normal.cross(across);
        self.flat.clear();
        self.flat.extend(self.ring.iter().map(|p| [p.dot(across), p.dot(up)]));
        self.ears.clear();
        self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.ears);
        let area: f64 = self.ears.as_chunks::<3>().0.iter().map(|ear| self.area(ear).0).sum();
        if area < 0.0 {
            self.ears.as_chunks_mut::<3>().0.iter_mut().for_each(|ear| ear.swap(1, 2));
        }
    }

    /// Returns twice a triangle's area in the plane, and a bound on its error.
    fn area(&self, ear: &[u32; 3]) -> (f64, f64) {
        let [a, b, c] = ear.map(|place| DVec2::from(self.flat[place as usize]));
        let (ab, ac) = (b - a, c - a);
        (ab.perp_dot(ac), 4.0 * ROUNDING * (ab.length() + ac.length()))
    }

    /// Adds the corners that `earcut` skips because they are on a straight edge, as degenerate
    /// triangles. Otherwise, a neighbour that has these corners would have open edges there.
    /// Returns false if the boundary of the triangles is not the polygon's ring.
    fn close(&mut self) -> bool {
        let count = self.ring.len() as u32;
        self.edges.clear();
        for &[a, b, c] in self.ears.as_chunks::<3>().0 {
            self.edges.extend([[a, b], [b, c], [c, a]]);
        }
        self.edges.sort_unstable();
        if self.edges.windows(2).any(|pair| pair[0] == pair[1]) {
            return false;
        }
        let is_free = |&&[a, b]: &&[u32; 2]| self.edges.binary_search(&[b, a]).is_err();
        let free: Vec<[u32; 2]> = self.edges.iter().filter(is_free).copied().collect();
        for (i, &[from, to]) in free.iter().enumerate() {
            if to != free[(i + 1) % free.len()][0] {
                return false;
            }
            let steps = (to + count - from) % count;
            for step in 1..steps {
                self.ears.extend([from, (from + step) % count, (from + step + 1) % count]);
            }
        }
        self.ears.len() == 3 * (self.ring.len() - 2)
    }

    /// Returns whether all triangles have the same orientation. If so, they fill the polygon
    /// without overlap, because their areas add up to the polygon's area.
    fn is_cut(&self) -> bool {
        self.ears.as_chunks::<3>().0.iter().all(|ear| {
            let (area, error) = self.area(ear);
            area >= -error
        })
    }
}

/// Returns the power of two that scales a size to between 1 and 2, if possible.
fn unit(size: f64) -> f64 {
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    2.0_f64.powi(-exponent.clamp(-1000, 1000))
}
