//! The pyramid around rays that share an origin, against the eight boxes of a node.
//!
//! ```text
//!            ╱│ far corner: inside of all four planes?
//!         ╱ ┌─┼──┐
//!   o  ◄────┤ │  │   near corner: before the farthest t that still counts?
//!         ╲ └────┘
//!            ╲
//! ```
//!
//! No ray is tested against any box. `docs/numerics/hierarchy.md` proves that nothing is lost.

use intertri::Frame;
use intertri::lanes::{Lanes, Mask};

use crate::ends::Ends;
use crate::node::Node;
use crate::spread::Spread;

/// The padding of a plane, relative to the largest coordinate of origin and scene: 2^-18.
const PAD: f32 = 1.0 / (1 << 18) as f32;

/// The sides stand this much further out than any ray, as slopes: 2^-18.
const MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// No coordinate may be larger: 2^30.
const LARGEST: f32 = (1 << 30) as f32;

/// A plane through the origin, by the side to which it looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    normal: [f32; 3],
    /// `normal · origin`
    at: f32,
    /// What rounding can take.
    pub(crate) pad: f32,
}

impl Plane {
    /// The plane of that normal through the origin of a frame, in a scene whose coordinates reach to ±`reach`.
    pub(crate) fn new(normal: [f32; 3], frame: &Frame, reach: f32) -> Self {
        let origin = frame.origin();
        let reach = origin.iter().fold(reach, |m, x| m.max(x.abs())) + frame.off() / PAD;
        let size = normal[0].abs() + normal[1].abs() + normal[2].abs();
        Self { normal, at: dot(normal, origin), pad: PAD * reach * size + f32::MIN_POSITIVE }
    }

    /// The signed distances of those corners of eight boxes that are farthest along the normal; with
    /// `low`, least far.
    #[inline(always)]
    pub(crate) fn of_boxes<F: Lanes<Scalar = f32>>(&self, node: &Node, low: bool) -> F {
        let Self { normal, at, .. } = *self;
        let x = node.sides(0, (normal[0] > 0.0) != low);
        let y = node.sides(1, (normal[1] > 0.0) != low);
        let z = node.sides(2, (normal[2] > 0.0) != low);
        let sum = F::load(x).mul_add(F::splat(normal[0]), F::splat(-at));
        let sum = F::load(y).mul_add(F::splat(normal[1]), sum);
        F::load(z).mul_add(F::splat(normal[2]), sum)
    }
}

/// Four planes around rays from one origin, and the axis along which they go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pyramid {
    sides: [Plane; 4],
    axis: Plane,
    /// Bit k: the axis is negative along coordinate k.
    pub(crate) octant: usize,
}

impl Pyramid {
    /// The pyramid around a rectangle of a frame's screen, in a scene whose coordinates reach to
    /// ±`reach`.
    pub(crate) fn new(frame: &Frame, (lo, hi): ([f32; 2], [f32; 2]), reach: f32) -> Self {
        let (depth, [right, up]) = (frame.depth(), frame.across());
        let side = |across: [f32; 3], slope: f32, sign: f32| {
            let slope = slope - sign * MARGIN;
            let normal = [0, 1, 2].map(|k| sign * (across[k] - slope * depth[k]));
            Plane::new(normal, frame, reach)
        };
        let sides = [
            side(right, lo[0], 1.0),
            side(right, hi[0], -1.0),
            side(up, lo[1], 1.0),
            side(up, hi[1], -1.0),
        ];
        let octant = (0..3).map(|k| usize::from(depth[k] < 0.0) << k).sum();
        Self { sides, axis: Plane::new(depth, frame, reach), octant }
    }

    /// Which of a node's boxes a ray may meet before the depth `far` and, where they are known, before rays end;
    /// and from which depth on.
    #[inline(always)]
    pub(crate) fn meet<F: Lanes<Scalar = f32>>(
        &self,
        node: &Node,
        far: f32,
        ends: Option<&Ends>,
    ) -> (u32, F) {
        let near = self.axis.of_boxes::<F>(node, true) - F::splat(self.axis.pad);
        let mut met = near.le(F::splat(far));
        if let Some(ends) = ends {
            met = met & ends.may_meet::<F>(node);
        }
        for side in &self.sides {
            met = met & side.of_boxes::<F>(node, false).ge(F::splat(-side.pad));
        }
        (met.bits(), near)
    }
}

/// A frame that looks along `sum`, level with the way in which rays spread most or, if none stands out, with
/// `step`. `None` where there is no direction, or coordinates are too large.
#[inline(always)]
pub(crate) fn frame<F: Lanes<Scalar = f32>>(
    origin: [f32; 3],
    sum: [f32; 3],
    step: [f32; 3],
    spread: &Spread<F>,
    reach: f32,
) -> Option<Frame> {
    if reach >= LARGEST || origin.iter().any(|x| x.abs() >= LARGEST) {
        return None;
    }
    let depth = unit(sum)?;
    let mut across = across(depth, step)?;
    if let Some(axis) = spread.main_axis(across) {
        across = self::across(depth, axis)?;
    }
    Some(Frame::new(origin, depth, across[0], across[1]))
}

/// Two axes at right angles to `depth`, the first level with `step`.
fn across(depth: [f32; 3], step: [f32; 3]) -> Option<[[f32; 3]; 2]> {
    let along = dot(step, depth);
    let right = unit([0, 1, 2].map(|k| step[k] - along * depth[k]))
        .filter(|right| dot(*right, depth).abs() < 1e-6)
        .or_else(|| unit(cross(depth, [1.0, 0.0, 0.0])))
        .or_else(|| unit(cross(depth, [0.0, 1.0, 0.0])))?;
    Some([right, cross(depth, right)])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector of length 1, or `None` where the length is nearly nothing or not finite.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let square = dot(v, v);
    let sane = square > f32::MIN_POSITIVE * LARGEST && square < f32::MAX;
    sane.then(|| v.map(|x| x / square.sqrt()))
}
