//! A triangle as the eye sees it, and how far each arithmetic can be from the truth about it.

#![expect(clippy::neg_cmp_op_on_partial_ord, reason = "what is NaN is in doubt")]

use intertri::Triangle;

use super::{Arithmetic, V};

/// The rounding of f32 and of f64.
const U: f64 = 1.0 / (1_u64 << 24) as f64;
const W: f64 = 1.0 / (1_u64 << 53) as f64;

/// Corners from the eye, and what follows from them.
pub(super) struct Facet {
    pub(super) corners: [V; 3],
    normal: V,
    /// `B × C`, `C × A`, `A × B`: the planes through the eye and a side, and their lengths.
    planes: [V; 3],
    lengths: [f64; 3],
    /// How far the farthest end of each side is.
    reaches: [f64; 3],
    /// No point of a side is nearer.
    near: f64,
    /// The first corner's distance, the longest side, the normal's length.
    first: f64,
    pub(super) side: f64,
    area: f64,
    /// `h4 h5 / |n|`, document A's sensitivity.
    kappa: f64,
    /// The distances in the direction of sight between which the triangle lies.
    pub(super) depth: (f64, f64),
    /// `A · n`
    height: f64,
    /// How far the eye is from the origin of the axes.
    off: f64,
}

/// A ray from the eye.
#[derive(Clone, Copy)]
pub(super) struct Sight {
    pub(super) dir: V,
    pub(super) length: f64,
    /// The part of the direction that goes into the picture.
    pub(super) depth: f64,
}

/// A facet at a pixel: its edge values, all positive inside, and where the ray meets its plane.
pub(super) struct Meeting {
    edges: [f64; 3],
    slope: f64,
    pub(super) t: f64,
    /// How far inside of the nearest side the ray passes, at least; negative outside.
    margin: f64,
    /// The distance of the ray from each side, found where the margin does not decide.
    sides: Option<[f64; 3]>,
}

/// What an arithmetic can make of a facet at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// No hit.
    Out,
    /// A hit, with its t between these.
    In(f64, f64),
    /// A hit or not; if it is one, its t is between these.
    Doubt(f64, f64),
}

pub(super) fn vector(p: [f32; 3]) -> V {
    V::splat(p.map(f64::from))
}

pub(super) fn length(v: V) -> f64 {
    v.dot(v).sqrt()
}

impl Facet {
    pub(super) fn new(&Triangle(corners): &Triangle, eye: [f32; 3], forward: V) -> Self {
        let origin = vector(eye);
        let [a, b, c] = corners.map(|corner| vector(corner) - origin);
        let (h4, h5) = (b - a, c - a);
        let normal = h4.cross(h5);
        let sides = [(b, c), (c, a), (a, b)];
        let planes = sides.map(|(p, q)| p.cross(q));
        let depths = [a, b, c].map(|corner| corner.dot(forward));
        let far = [a, b, c].map(length);
        let (long4, long5, area) = (length(h4), length(h5), length(normal));
        Self {
            corners: [a, b, c],
            normal,
            planes,
            lengths: planes.map(length),
            reaches: [far[1].max(far[2]), far[2].max(far[0]), far[0].max(far[1])],
            near: sides.map(|(p, q)| distance(p, q)).into_iter().fold(f64::INFINITY, f64::min),
            first: far[0],
            side: long4.max(long5).max(length(c - b)),
            area,
            kappa: long4 * long5 / area,
            depth: (
                depths.into_iter().fold(f64::INFINITY, f64::min),
                depths.into_iter().fold(f64::NEG_INFINITY, f64::max),
            ),
            height: a.dot(normal),
            off: length(origin),
        }
    }

    /// Whether all is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.corners.iter().all(|c| c.dot(*c).is_finite())
    }

    /// The farthest corner.
    pub(super) fn reach(&self) -> f64 {
        self.reaches[0].max(self.reaches[1])
    }

    /// What an f32 test can be off by in an edge value, for directions of unit length.
    pub(super) fn single(&self) -> f64 {
        let (small, large) = (2.0_f64.powi(-30), 2.0_f64.powi(30));
        if self.side.min(self.first) < small || self.side.max(self.reach()) > large {
            return f64::INFINITY;
        }
        U * self.side * (22.6 * self.first + 28.0 * self.side)
    }

    /// What the reference can be off by in an edge value, for directions of unit length, where the
    /// ray meets the plane at this `rho = h4 h5 |d| / |n · d|`.
    fn double(&self, rho: f64) -> f64 {
        // Beyond, the roundings of the derivation are no longer small.
        if rho > 2.0_f64.powi(40) {
            return f64::INFINITY;
        }
        let Self { side, first, kappa, off, .. } = *self;
        2.0 * W * side * ((30.0 * kappa + 68.0 * rho) * first + off + 34.0 * kappa * side)
    }

    /// Where its plane is seen edge-on, so that rounding can put hits beside the triangle: how far, in
    /// lengths of its side.
    pub(super) fn spill(&self) -> f64 {
        let slope = self.height.abs() / self.reach();
        let rho = self.side * self.side / slope;
        8.0 * (self.single() + self.double(rho)) / slope
    }

    /// The planes through the eye and its sides.
    pub(super) fn planes(&self) -> [V; 3] {
        self.planes
    }

    /// How the ray of a pixel passes.
    pub(super) fn meet(&self, sight: &Sight) -> Meeting {
        let slope = self.normal.dot(sight.dir);
        let sign = if slope < 0.0 { -1.0 } else { 1.0 };
        let edges = self.planes.map(|plane| sign * plane.dot(sight.dir));
        let mut margin = f64::INFINITY;
        for (edge, length) in edges.iter().zip(self.lengths) {
            let sine = edge / (length * sight.length);
            margin = margin.min(if sine.is_nan() { 0.0 } else { sine });
        }
        Meeting { edges, slope, t: self.height / slope, margin: margin * self.near, sides: None }
    }

    /// Whether the ray surely passes outside, even of an exact test of these edge values.
    pub(super) fn is_outside(&self, meeting: &Meeting, sight: &Sight) -> bool {
        let own = 1e-10 * self.reach() * self.reach() * sight.length;
        let most = meeting.edges.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        let least = meeting.edges.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        most > own && least < -own
    }

    /// How far the computed t can be from the exact one.
    fn blur(&self, meeting: &Meeting, sight: &Sight) -> f64 {
        let rho = self.side * self.side * sight.length / meeting.slope.abs();
        if rho < 1e10 {
            1e-14 * rho * (self.first / sight.length + meeting.t.abs())
        } else {
            f64::INFINITY
        }
    }

    /// A t that is not less than the exact one.
    pub(super) fn latest(&self, meeting: &Meeting, sight: &Sight) -> f64 {
        let t = meeting.t + self.blur(meeting, sight);
        if t.is_nan() { f64::INFINITY } else { t }
    }

    /// Whether the ray surely meets its plane after this t.
    pub(super) fn is_behind(&self, meeting: &Meeting, sight: &Sight, t: f64) -> bool {
        meeting.t - self.blur(meeting, sight) > t
    }

    /// What an arithmetic can make of it.
    pub(super) fn verdict(
        &self,
        arithmetic: Arithmetic,
        meeting: &mut Meeting,
        sight: &Sight,
    ) -> Verdict {
        let verdict = match arithmetic {
            Arithmetic::Grid { step, q } => self.on_grid(step, q, meeting, sight),
            Arithmetic::Single => {
                let (side, steep) = (self.side, meeting.slope.abs());
                let near = 8.1 * U * side * side * sight.length;
                let t = meeting.t;
                let off = (12.2 * U * side * side * self.first + t.abs() * near) / (steep - near);
                let off = if steep > near { off + 2.0 * U * t.abs() } else { f64::INFINITY };
                self.by_edges(self.single(), off, meeting, sight)
            }
            Arithmetic::Double { threshold } => {
                // The computed normal of a triangle without area is NaN.
                if self.area == 0.0 {
                    return Verdict::Out;
                }
                let noise = 12.0 * W * self.kappa * sight.length;
                let slope = meeting.slope.abs() / self.area;
                if slope + noise < threshold {
                    return Verdict::Out;
                }
                let rho = self.kappa * sight.length / slope;
                let (t, far) = (meeting.t.abs(), sight.length);
                let off = 13.0 * W * rho * (self.first + t * far) / far + 2.0 * W * t;
                let verdict = self.by_edges(self.double(rho), off, meeting, sight);
                match verdict {
                    Verdict::In(lo, hi) if slope < threshold + noise || lo <= threshold => {
                        Verdict::Doubt(lo, hi)
                    }
                    verdict => verdict,
                }
            }
        };
        // What starts behind or at the eye.
        match verdict {
            Verdict::In(_, hi) | Verdict::Doubt(_, hi) if hi < 0.0 => Verdict::Out,
            Verdict::In(lo, hi) if lo <= 0.0 => Verdict::Doubt(lo, hi),
            verdict => verdict,
        }
    }

    /// Edge values off by up to `bound`, for a direction of unit length, and t by up to `off`.
    fn by_edges(&self, bound: f64, off: f64, meeting: &Meeting, sight: &Sight) -> Verdict {
        // What is computed here is itself rounded.
        let bound = (bound + 32.0 * W * self.reach() * self.reach()) * sight.length;
        let (lo, hi) = if (meeting.t - off).is_nan() {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (meeting.t - off, meeting.t + off)
        };
        if meeting.edges.iter().any(|&e| e < -bound) {
            Verdict::Out
        } else if meeting.edges.iter().all(|&e| e > bound) {
            Verdict::In(lo, hi)
        } else {
            Verdict::Doubt(lo, hi)
        }
    }

    /// Corners and ray moved by snapping. As long as no side crosses the ray on the way, the ray stays
    /// inside or outside.
    fn on_grid(&self, step: f64, q: u32, meeting: &mut Meeting, sight: &Sight) -> Verdict {
        let (snap, turn) = (snap(step), turn(q));
        let most = snap + turn * self.reach();

        // The distances in the direction of sight stay within the triangle's.
        let (front, back) = (self.depth.0 - snap, self.depth.1 + snap);
        let off = turn * sight.length;
        let lo = front / (sight.depth + if front > 0.0 { off } else { -off });
        let hi = back / (sight.depth - off);
        let doubt = Verdict::Doubt(lo, hi);

        if meeting.margin < -most {
            return Verdict::Out;
        }
        if !(meeting.margin > most) {
            let sides = meeting.sides.get_or_insert_with(|| self.sides(sight));
            for (distance, reach) in sides.iter().zip(self.reaches) {
                if !(*distance > snap + turn * reach) {
                    return doubt;
                }
            }
            if meeting.margin < 0.0 {
                return Verdict::Out;
            }
        }

        // Inside: the point moves with its corners, and the plane tilts.
        let apart = 2.0 * snap_of_one(step);
        let tilt = apart * (2.0 * self.side + apart) / self.area;
        let cosine = meeting.slope.abs() / (self.area * sight.length);
        let cosine = (cosine - tilt - turn) / (1.0 + tilt);
        let off = (snap / sight.length + turn * meeting.t.abs()) / cosine;
        if cosine > 0.0 {
            Verdict::In(lo.max(meeting.t - off), hi.min(meeting.t + off))
        } else {
            Verdict::In(lo, hi)
        }
    }

    /// The distance of the ray's line from each side.
    fn sides(&self, sight: &Sight) -> [f64; 3] {
        // Seen along the ray the line is a point.
        let unit = sight.dir * (1.0 / sight.length);
        let [a, b, c] = self.corners.map(|p| p - unit * p.dot(unit));
        [(b, c), (c, a), (a, b)].map(|(p, q)| distance(p, q) * (1.0 - 1e-9))
    }

    /// How far the seen triangle moves at this pixel, as an angle, at most.
    pub(super) fn shift(&self, arithmetic: Arithmetic, meeting: &Meeting, sight: &Sight) -> f64 {
        let bound = match arithmetic {
            Arithmetic::Grid { step, q } => {
                return snap(step) / (meeting.t.abs() * sight.length) + turn(q);
            }
            Arithmetic::Single => self.single(),
            Arithmetic::Double { .. } => {
                self.double(self.side * self.side * sight.length / meeting.slope.abs())
            }
        };
        bound / self.lengths.iter().fold(f64::INFINITY, |a, &b| a.min(b))
    }
}

/// How far a side and a ray, together, may move.
pub(super) fn moves(arithmetic: Arithmetic, reach: f64) -> f64 {
    match arithmetic {
        Arithmetic::Grid { step, q } => snap(step) + turn(q) * reach,
        _ => 0.0,
    }
}

/// How far a point moves when it is snapped: half a step along each axis.
fn snap_of_one(step: f64) -> f64 {
    0.75_f64.sqrt() * step
}

/// How far a corner moves as seen from the eye, which moves, too.
fn snap(step: f64) -> f64 {
    2.0 * snap_of_one(step)
}

/// The angle by which a direction turns when it is snapped.
fn turn(q: u32) -> f64 {
    1.01 * 3.0_f64.sqrt() / f64::from(1_u32 << q)
}

/// The distance of a segment from the origin.
fn distance(p: V, q: V) -> f64 {
    let along = q - p;
    let square = along.dot(along);
    let s = if square > 0.0 { (-p.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    length(p + along * s).min(length(p)).min(length(q))
}
