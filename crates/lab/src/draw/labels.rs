//! Places labels next to their points. Each label tries positions all around its point and takes
//! the one with the least overlap, preferring positions close to the point. A label that has to
//! move farther away gets a leader line to its point.

use super::svg::width;

/// A point that needs a label.
#[derive(Clone, Debug)]
pub(super) struct PointLabel {
    pub(super) text: String,
    pub(super) at: [f64; 2],
    pub(super) bold: bool,
}

/// A placed label: the left end of its baseline, and the end of its leader line, if it needs one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) left: [f64; 2],
    pub(super) leader: Option<[f64; 2]>,
}

/// A rectangle, given by two corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub(super) lo: [f64; 2],
    pub(super) hi: [f64; 2],
}

impl Area {
    fn around([x, y]: [f64; 2], r: f64) -> Self {
        Self { lo: [x - r, y - r], hi: [x + r, y + r] }
    }

    /// Returns the area that two rectangles have in common.
    fn overlap(&self, other: &Self) -> f64 {
        let side = |k: usize| self.hi[k].min(other.hi[k]) - self.lo[k].max(other.lo[k]);
        side(0).max(0.0) * side(1).max(0.0)
    }

    /// Returns how far this rectangle extends beyond another one, as a sum over both axes.
    fn outside(&self, of: &Self) -> f64 {
        let side = |k: usize| (of.lo[k] - self.lo[k]).max(0.0) + (self.hi[k] - of.hi[k]).max(0.0);
        side(0) + side(1)
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (0..2).all(|k| self.lo[k] < p[k] && p[k] < self.hi[k])
    }
}

/// Places labels in one font size within bounds. `obstacles` are points that no label should cover.
pub(super) fn place(
    wanted: &[PointLabel],
    size: f64,
    bounds: Area,
    obstacles: &[[f64; 2]],
) -> Vec<Placed> {
    let marks: Vec<Area> = obstacles.iter().map(|&p| Area::around(p, 3.5)).collect();
    let candidates: Vec<Vec<Area>> = wanted.iter().map(|label| around(label, size)).collect();
    // Initially, every label is to the right of its point.
    let mut chosen = vec![0_usize; wanted.len()];

    for _ in 0..12 {
        for i in 0..wanted.len() {
            let cost = |k: usize| {
                let area = candidates[i][k];
                let from = wanted[i].at;
                let end = nearest(&area, from);
                let mut cost = 0.02 * distance(from, end) * distance(from, end).sqrt();
                cost += 1e4 * area.outside(&bounds);
                for mark in &marks {
                    cost += 2.0 * area.overlap(mark);
                }
                for (j, places) in candidates.iter().enumerate().filter(|(j, _)| *j != i) {
                    let other = places[chosen[j]];
                    let other_end = nearest(&other, wanted[j].at);
                    cost += 20.0 * area.overlap(&other);
                    cost += 60.0 * along(wanted[j].at, other_end, &area);
                    cost += 60.0 * along(from, end, &other);
                    if cross(from, end, wanted[j].at, other_end) {
                        cost += 80.0;
                    }
                }
                cost
            };
            let best = (0..candidates[i].len()).min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
            chosen[i] = best.unwrap_or(0);
        }
    }

    let placed = |(i, label): (usize, &PointLabel)| {
        let area = candidates[i][chosen[i]];
        let end = nearest(&area, label.at);
        Placed {
            left: [area.lo[0] + 1.5, area.hi[1] - 0.26 * size],
            leader: (distance(label.at, end) > 9.0).then_some(end),
        }
    };
    wanted.iter().enumerate().map(placed).collect()
}

/// Returns the candidate positions of a label around its point.
fn around(label: &PointLabel, size: f64) -> Vec<Area> {
    let (w, h) =
        (width(&label.text, size) * if label.bold { 1.08 } else { 1.0 } + 3.0, 1.12 * size);
    let [x, y] = label.at;
    let mut places = Vec::new();
    for reach in [7.0, 13.0, 22.0, 34.0, 48.0, 64.0, 84.0, 108.0, 136.0, 170.0] {
        for step in 0..24 {
            let angle = f64::from(step) * std::f64::consts::TAU / 24.0;
            let (cx, cy) = (x + reach * angle.cos(), y + reach * angle.sin());
            // A label beside the point starts or ends at the point; a label above or below the
            // point is centred on it.
            let left = match step {
                0..=4 | 20.. => cx,
                8..=16 => cx - w,
                _ => cx - w / 2.0,
            };
            let top = match step {
                4..=8 => cy,
                16..=20 => cy - h,
                _ => cy - h / 2.0,
            };
            places.push(Area { lo: [left, top], hi: [left + w, top + h] });
        }
    }
    places
}

/// Returns the point of an area that is nearest to another point.
fn nearest(area: &Area, p: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| p[k].clamp(area.lo[k], area.hi[k]))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Estimates the share of a line that is inside an area by testing a point at every eighth of the
/// line.
fn along(a: [f64; 2], b: [f64; 2], area: &Area) -> f64 {
    let at = |k: i32| [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * f64::from(k) / 8.0);
    (0..=8).filter(|&k| area.holds(at(k))).count() as f64 / 8.0
}

/// Returns whether two line segments cross.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::width;
    use super::{Area, PointLabel, place};

    #[test]
    fn labels_of_a_crowd_stay_apart_and_inside() {
        // Twelve points within a few units of each other, near the right edge of a panel.
        let wanted: Vec<_> = (0..12)
            .map(|k| {
                let at = [440.0 + f64::from(k % 4) * 6.0, 150.0 + f64::from(k / 4) * 5.0];
                PointLabel { text: format!("method number {k}"), at, bold: false }
            })
            .collect();
        let bounds = Area { lo: [0.0, 0.0], hi: [500.0, 300.0] };
        let points: Vec<_> = wanted.iter().map(|label| label.at).collect();
        let placed = place(&wanted, 11.0, bounds, &points);
        let area = |k: usize| {
            let [x, y] = placed[k].left;
            Area { lo: [x, y - 9.0], hi: [x + width(&wanted[k].text, 11.0), y + 2.5] }
        };
        for k in 0..12 {
            assert!(area(k).outside(&bounds) < 2.0, "{k}: {:?}", placed[k]);
            for j in 0..k {
                assert!(area(k).overlap(&area(j)) < 1.0, "{j} {k}: {placed:?}");
            }
        }
    }
}
