//! The sweeps: families and the ranges of their parameters, from harmless to adversarial.

/// A family and a range of its parameter, starting at the harmless end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// The name of the parameter, for a heading.
    pub name: &'static str,
    /// The quantity that the parameter measures, for the label of an axis.
    pub axis: &'static str,
    /// The family.
    pub family: &'static str,
    /// The harmless end of the range.
    pub from: f64,
    /// The other end of the range.
    pub to: f64,
    /// Whether to count only rays that pass clear of all sides. False if closeness to a side is the
    /// parameter.
    pub clear: bool,
}

/// All sweeps. A family that is harmful at both ends of its range is swept twice, outward from the
/// middle.
pub const SWEEPS: &[Sweep] = &[
    sweep("needle, ratio", "short side / long side", "needle", 1.0, 1e-12),
    sweep("cap, ratio", "height / long side", "cap", 1.0, 1e-12),
    sweep("sliver, ratio", "height / long side", "sliver", 1.0, 1e-12),
    sweep("grazing angle", "angle in radians", "grazing", 1.0, 1e-12),
    sweep("distance / size", "distance in sizes", "far", 1.0, 1e9),
    sweep("size at distance 1", "size of the triangle", "tiny", 1.0, 1e-7),
    sweep("offset, size 1", "distance from zero", "offset", 1.0, 1e9),
    sweep("offset, size in step", "distance from zero", "offset-large", 1.0, 1e9),
    sweep("scale, down", "factor on coordinates", "scale", 1.0, 1e-30),
    sweep("scale, up", "factor on coordinates", "scale", 1.0, 1e30),
    sweep("|dir|, short", "length of the direction", "direction", 1.0, 1e-30),
    sweep("|dir|, long", "length of the direction", "direction", 1.0, 1e30),
    sweep("near overflow", "size of coordinates", "overflow", 1e12, 3e38),
    sweep("near underflow", "size of coordinates", "underflow", 1e-12, 1e-44),
    sweep("threshold met by |vd|", "the threshold", "threshold-vd", 1e-15, 0.5),
    sweep("threshold met by t", "the threshold", "threshold-t", 1e-15, 1e3),
    Sweep {
        clear: false,
        ..sweep("f32 steps off an edge", "f32 steps", "edge-steps", 1_048_576.0, 1.0)
    },
];

const fn sweep(
    name: &'static str,
    axis: &'static str,
    family: &'static str,
    from: f64,
    to: f64,
) -> Sweep {
    Sweep { name, axis, family, from, to, clear: true }
}

/// Returns the value at a fraction of the sweep's range, on a logarithmic scale.
pub(super) fn parameter(sweep: &Sweep, share: f64) -> f64 {
    between(sweep.from, sweep.to, share)
}

/// Interpolates between two positive numbers on a logarithmic scale. Bisects the range sixteen
/// times with square roots, so the result has the same bits on every machine.
pub(super) fn between(mut from: f64, mut to: f64, share: f64) -> f64 {
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..16 {
        if share <= lo {
            return from;
        }
        if share >= hi {
            return to;
        }
        let middle = f64::midpoint(lo, hi);
        let value = from.sqrt() * to.sqrt();
        if share < middle {
            (hi, to) = (middle, value);
        } else {
            (lo, from) = (middle, value);
        }
    }
    from
}

#[cfg(test)]
mod tests {
    use super::{SWEEPS, parameter};
    use crate::families::find;

    #[test]
    fn sweeps_go_from_end_to_end_within_their_families() {
        for sweep in SWEEPS {
            let param = find(sweep.family).unwrap().param.unwrap();
            let (lo, hi) = (param.from.min(param.to), param.from.max(param.to));
            assert!(sweep.from >= lo && sweep.from <= hi && sweep.to >= lo && sweep.to <= hi);
            assert_eq!(parameter(sweep, 0.0), sweep.from);
            assert_eq!(parameter(sweep, 1.0), sweep.to);
            let middle = sweep.from.sqrt() * sweep.to.sqrt();
            assert!((parameter(sweep, 0.5) / middle - 1.0).abs() < 1e-12);
        }
    }
}
