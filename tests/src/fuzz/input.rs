//! Generates scenes from the bytes that a fuzzer provides. Most of the scenes are degenerate.

use arbitrary::Unstructured;
use intertri::{Ray, Triangle};

use crate::Scene;

/// A source of choices and coordinates, read from bytes. All coordinates are of the same kind.
pub(super) struct Input<'a> {
    bytes: Unstructured<'a>,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// Small integers times a scale, so that many edges, corners and planes coincide.
    Grid(f32),
    /// Small integers times a scale, moved by a few ulps.
    Ulps(f32),
    /// Arbitrary bit patterns, including NaNs and subnormal numbers.
    Bits,
}

impl<'a> Input<'a> {
    /// Creates an input. The first bytes select the kind of coordinates.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut input = Self { bytes: Unstructured::new(bytes), kind: Kind::Bits };
        let kind = input.below(8);
        let scale = input.scale();
        input.kind = match kind {
            0..3 => Kind::Grid(scale),
            3..6 => Kind::Ulps(scale),
            _ => Kind::Bits,
        };
        input
    }

    /// Creates an input that generates small integers only, so that results can be computed
    /// exactly.
    pub(super) fn on_a_grid(bytes: &'a [u8]) -> Self {
        Self { bytes: Unstructured::new(bytes), kind: Kind::Grid(1.0) }
    }

    /// Generates a scale: 1 half of the time, otherwise a power of two or an arbitrary number.
    fn scale(&mut self) -> f32 {
        match self.below(4) {
            0 | 1 => 1.0,
            2 => (self.below(256) as f32 - 149.0).exp2(),
            _ => self.bits(),
        }
    }

    /// Generates a number below `end`, or 0 once the bytes are used up.
    pub(super) fn below(&mut self, end: usize) -> usize {
        self.bytes.int_in_range(0..=end - 1).unwrap_or(0)
    }

    /// Generates a number in `-limit..=limit`.
    pub(super) fn within(&mut self, limit: i32) -> i32 {
        self.bytes.int_in_range(-limit..=limit).unwrap_or(0)
    }

    /// Picks an element of a slice.
    pub(super) fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// Generates an f32 with an arbitrary bit pattern.
    fn bits(&mut self) -> f32 {
        f32::from_bits(self.bytes.arbitrary().unwrap_or(0))
    }

    /// Generates an f64 with an arbitrary bit pattern.
    pub(super) fn double(&mut self) -> f64 {
        f64::from_bits(self.bytes.arbitrary().unwrap_or(0))
    }

    /// Generates a number of the selected kind. With [`Kind::Ulps`], one number in sixteen has an
    /// arbitrary bit pattern.
    pub(super) fn number(&mut self) -> f32 {
        match self.kind {
            Kind::Grid(scale) => self.within(4) as f32 * scale,
            Kind::Ulps(scale) => match self.below(16) {
                0 => self.bits(),
                _ => steps(self.within(4) as f32 * scale, self.within(2)),
            },
            Kind::Bits => self.bits(),
        }
    }

    /// Generates a point whose coordinates are numbers of the selected kind.
    pub(super) fn point(&mut self) -> [f32; 3] {
        [self.number(), self.number(), self.number()]
    }

    /// Generates triangles whose corners are taken from a few points, so that triangles share
    /// corners and edges, and some are identical.
    pub(super) fn triangles(&mut self, at_most: usize) -> Vec<Triangle> {
        let points: Vec<[f32; 3]> = (0..3 + self.below(6)).map(|_| self.point()).collect();
        let count = 1 + self.below(at_most);
        (0..count).map(|_| Triangle([(); 3].map(|()| self.one_of(&points)))).collect()
    }

    /// Generates an arbitrary ray, a ray along an edge or an axis, or a ray toward a corner, the
    /// midpoint of an edge, or a point inside a triangle.
    pub(super) fn ray(&mut self, triangles: &[Triangle]) -> Ray {
        let [c1, c2, c3] = self.one_of(triangles).0;
        let origin = if self.below(8) == 0 { c3 } else { self.point() };
        let each = |f: &dyn Fn(usize) -> f32| [f(0), f(1), f(2)];
        let dir = match self.below(6) {
            0 => each(&|i| c1[i] - origin[i]),
            1 => each(&|i| c1[i] * 0.5 + c2[i] * 0.5 - origin[i]),
            2 => each(&|i| c1[i] * 0.25 + c2[i] * 0.25 + c3[i] * 0.5 - origin[i]),
            3 => each(&|i| c2[i] - c1[i]),
            4 => {
                let axis = self.below(3);
                let step = self.one_of(&[1.0, -1.0]);
                each(&|i| if i == axis { step } else { 0.0 })
            }
            _ => self.point(),
        };
        // The target is at t = 1: the first interval ends there, the second begins there, and the
        // third ends just beyond it.
        let ray = Ray::new(origin, dir);
        match self.below(6) {
            0 => ray.between(0.0, 1.0),
            1 => ray.between(1.0, f32::INFINITY),
            2 => ray.between(0.0, 1.0_f32.next_up()),
            3 => ray.between(self.number(), self.number()),
            _ => ray,
        }
    }

    /// Generates a scene of a few triangles and rays, with a threshold.
    pub(super) fn scene(&mut self, triangles: usize, rays: usize) -> Scene {
        let threshold = match self.below(8) {
            0..4 => 1e-9,
            4 | 5 => 0.0,
            6 => 0.25,
            _ => Some(self.double().abs()).filter(|x| x.is_finite()).unwrap_or(0.5),
        };
        let triangles = self.triangles(triangles);
        let rays = (0..=self.below(rays)).map(|_| self.ray(&triangles)).collect();
        Scene { triangles, rays, threshold }
    }
}

/// Moves a number by `steps` ulps, possibly across zero. If `steps` is negative, the number
/// decreases.
fn steps(x: f32, steps: i32) -> f32 {
    (0..steps.abs()).fold(x, |x, _| if steps > 0 { x.next_up() } else { x.next_down() })
}
