//! The rays of a bundle, stored in lanes and projected onto a frame.
//!
//! ```text
//!   four rays in memory      four registers      sixteen rays per packet,
//!   o t_min d t_max ───┐                         sixteen packets per group, four groups per bundle
//!   o t_min d t_max ───┼──►  x x x x             ┌──┬──┬──┬──┐  a window per packet and group,
//!   o t_min d t_max ───┤     y y y y   ──►       ├──┼──┼──┼──┤  aligned with the direction in
//!   o t_min d t_max ───┘     z z z z             └──┴──┴──┴──┘  which the rays spread most
//! ```

use intertri::Filter;
use intertri::internal::{Apex, Frame, Nearest, Points, Ranges, Starts, Windows};
use intertri::simd::{Lanes, Mask, Simd, Vec3};
use intertri::{Ray, Threshold};

use super::projection_frame::frame;
use super::rays::{BundleRays, Common, half};
use super::reversed_shadow::Reversal;
use crate::util::lane_ops::{fours, smallest};
use crate::util::prefetch::Prefetch;

/// The maximum number of rays in a bundle.
pub(crate) const RAYS: usize = 1024;

/// The maximum number of packets in a bundle. A packet has sixteen rays.
pub(crate) const PACKETS: usize = RAYS / 16;

/// The maximum number of groups in a bundle. A group has sixteen packets, and a triangle is tested
/// against all their windows at once.
pub(crate) const GROUPS: usize = PACKETS / 16;

/// At most one in this many rays of a bundle may be an outlier.
const OUTLIERS: usize = 2;

/// If a triangle exceeds this fraction of a group's window along x or y, its edges are also tested
/// against the windows of packets.
const LARGE: f32 = 0.5;

/// The rays of a bundle in lanes, as points of a projection, along with what they have hit so far.
/// A projection is reused for many bundles, because creating it takes longer than tracing some
/// bundles.
pub(crate) struct Projection<S: Simd> {
    pub(crate) frame: Frame,
    pub(crate) points: [Points<S::F32x16>; PACKETS],
    pub(crate) nearest: [Nearest<S::F32x16, 16>; PACKETS],
    rows: Rows,
    pub(crate) groups: [Group<S>; GROUPS],
    /// The number of packets in use.
    pub(crate) used: usize,
    /// A lower bound on the z of all rays. It is not used for parallel rays.
    pub(crate) slowest: f32,
    /// The combined near ends of all rays.
    pub(crate) ranges: Ranges<S::F32x16>,
    /// Bit i of `live[p]` is set if ray `16 p + i` is still searching for a hit.
    pub(crate) live: [u32; PACKETS],
    /// Bit i of `outliers[p]` is set if ray `16 p + i` misses the projection and must be traced
    /// elsewhere.
    outliers: [u32; PACKETS],
    pub(crate) has_outliers: bool,
}

/// The smallest and largest x and y of each packet, grouped so that sixteen packets share a cache
/// line.
#[repr(C, align(64))]
struct Rows {
    lo: [[[f32; 16]; 2]; GROUPS],
    hi: [[[f32; 16]; 2]; GROUPS],
}

/// A group of sixteen packets.
#[derive(Clone, Copy)]
pub(crate) struct Group<S: Simd> {
    /// One window per packet.
    pub(crate) windows: Windows<S::F32x16>,
    /// The window around the current packets.
    pub(crate) window: Windows<S::F32x16>,
    /// Triangles larger than this along x or y are likely to reach several packets.
    pub(crate) large: [f32; 2],
    /// The smallest inverse depth at which a hit still counts, for each packet.
    pub(crate) least: [f32; 16],
    /// The minimum of `least` over all current packets.
    pub(crate) least_of_all: f32,
    /// Bit p is set if packet p is current.
    pub(crate) asked: u32,
}

impl<S: Simd> Projection<S> {
    /// Creates a projection without rays.
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let zero = S::F32x16::splat(0.0);
        let points = Points { x: zero, y: zero, z: zero };
        let (none, sixteen) = ([0.0; 2], [0.0; 16]);
        let group = Group {
            windows: Windows::new([zero; 2], [zero; 2]),
            window: around::<S>((none, none)),
            large: none,
            least: sixteen,
            least_of_all: 0.0,
            asked: 0,
        };
        Self {
            frame: Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            points: [points; PACKETS],
            nearest: [Nearest::new(Apex::Finite, &points, zero); PACKETS],
            rows: Rows { lo: [[sixteen; 2]; GROUPS], hi: [[sixteen; 2]; GROUPS] },
            groups: [group; GROUPS],
            used: 0,
            slowest: 0.0,
            ranges: Starts::none(Apex::Finite).ranges(),
            live: [0; PACKETS],
            outliers: [0; PACKETS],
            has_outliers: false,
        }
    }

    /// Returns whether a ray misses the projection.
    pub(crate) fn is_outlier(&self, ray: usize) -> bool {
        self.outliers[ray / 16] >> (ray % 16) & 1 != 0
    }

    /// Projects rays and marks all of them as live, while prefetching some of the next rays.
    /// Returns the window around the projected rays, or `None` if too many rays diverge or values
    /// are too large or too small.
    #[inline(always)]
    pub(crate) fn project(
        &mut self,
        filter: &Filter<'_>,
        rays: &BundleRays<'_>,
        reach: f32,
        prefetch: &mut Prefetch<'_>,
    ) -> Option<Rectangle> {
        self.frame = frame::<S>(filter, rays, reach)?;
        let count = rays.rays.len();
        self.used = count.div_ceil(16);

        // For reversed rays, the threshold applies to the far ends.
        let (mut reversal, mut starts_by) = (None, *filter);
        if let Common::End(end) = rays.common {
            reversal = Some(Reversal::<S::F32x16>::new(end, filter.is_of_copies()));
            starts_by = Filter::certified(Threshold::ZERO, S::LEVEL);
        }

        let (full, rest) = rays.rays.as_chunks::<16>();
        let filled = padded(rest, rays.rays[count - 1]);

        // Camera rays have no far end: their smallest inverse depth need not be computed for each
        // packet.
        let (apex, backward) = (self.frame.apex(), rays.common.is_reversed());
        let is_endless = rays.rays[0].t_max >= f32::INFINITY;
        let horizon = match apex {
            Apex::Finite => is_endless.then_some(0.0),
            Apex::AtInfinity { .. } => (is_endless && !backward).then_some(f32::NEG_INFINITY),
        };
        let (mut slowest, mut starts) = (S::F32x16::splat(f32::INFINITY), Starts::none(apex));
        for packet in 0..self.used {
            prefetch.lines(4);

            // Load sixteen rays into lanes.
            let mut columns = side_by_side::<S>(full.get(packet).unwrap_or(&filled));
            let mut sure = None;
            if let Some(reversal) = &mut reversal {
                let (reversed, beyond) = reversal.reverse(columns);
                (columns, sure) = (reversed, Some(beyond));
            }
            // The comparisons are false if either end is NaN, so the lane is then dead.
            let [[.., near], [.., far]] = columns;
            let alive = near.lt(far) & far.gt(S::F32x16::splat(0.0));
            let (points, [near, far]) = self.points_of(columns, backward);
            let (met, on_screen) = self.place(packet, points);
            slowest = slowest.min(met.z);

            // Nothing has been hit yet.
            let given = (1 << (count - 16 * packet).min(16)) - 1;
            let live = alive & sixteen_bits::<S>(given) & on_screen;
            self.live[packet] = live.bits();
            starts = starts_by.starts_in(&starts, &met, [near, sure.unwrap_or(near)], live);
            let nearest = Nearest::new(apex, &met, far);
            self.nearest[packet] = nearest;
            self.groups[packet / 16].least[packet % 16] = match horizon {
                Some(horizon) => horizon,
                None => least::<S>(&nearest, live.bits()),
            };
        }
        let outliers: u32 = self.outliers[..self.used].iter().map(|rays| rays.count_ones()).sum();
        self.has_outliers = outliers > 0;
        // If many rays miss the projection, a narrower bundle may work.
        if outliers as usize > count / OUTLIERS {
            return None;
        }
        // Round down. With this z, a threshold is converted to an inverse depth.
        self.slowest = smallest::<S>(slowest) * (1.0 - 1e-6);
        self.ranges = starts.ranges();

        for number in 0..self.used.div_ceil(16) {
            self.window_packets(number);
        }
        let (lo, hi) = self.ask(self.all());

        // Reversed rays and the f64 originals of copies may miss the origin.
        let off = if let Some(reversal) = &reversal { reversal.off()? } else { 0.0 };
        let most = [(-lo[0]).max(hi[0]), (-lo[1]).max(hi[1])];
        self.frame = filter.frame(self.frame, off, most);
        Some((lo, hi))
    }

    /// Projects sixteen rays, given as lanes of origins with `t_min` and directions with `t_max`. Also
    /// returns the ends of their intervals.
    #[inline(always)]
    fn points_of(
        &self,
        [[from_x, from_y, from_z, near], [x, y, z, far]]: [[S::F32x16; 4]; 2],
        backward: bool,
    ) -> (Points<S::F32x16>, [S::F32x16; 2]) {
        if let Apex::Finite = self.frame.apex() {
            return (self.frame.points(Vec3 { x, y, z }), [near, far]);
        }
        // Hits at a negative t do not count.
        let near = near.max(S::F32x16::splat(0.0));
        let ends = if backward { [-far, -near] } else { [near, far] };
        (self.frame.origins(Vec3 { x: from_x, y: from_y, z: from_z }), ends)
    }

    /// Stores the points of a packet. Also returns a mask of the rays that meet the projection; the
    /// others are outliers.
    #[inline(always)]
    fn place(
        &mut self,
        packet: usize,
        mut met: Points<S::F32x16>,
    ) -> (Points<S::F32x16>, <S::F32x16 as Lanes>::Mask) {
        let on_screen = self.frame.on_screen(&met);
        let outliers = !on_screen.bits() & 0xffff;
        if outliers != 0 {
            // Give outliers the point of another ray, so that they do not widen their packet's
            // window.
            met = instead::<S>(met, on_screen);
        }
        self.outliers[packet] = outliers;
        self.points[packet] = met;
        let [x, y, left, down] = extremes::<S>(met.x, met.y);
        let (group, place) = (packet / 16, packet % 16);
        let Rows { lo, hi } = &mut self.rows;
        (lo[group][0][place], lo[group][1][place]) = (x, y);
        (hi[group][0][place], hi[group][1][place]) = (-left, -down);
        (met, on_screen)
    }

    /// Returns the bounding rectangles of packets, by group: the smallest x and y of each packet,
    /// and the largest.
    pub(crate) fn rectangles(&self) -> impl Iterator<Item = (&[[f32; 16]; 2], &[[f32; 16]; 2])> {
        self.rows.lo.iter().zip(&self.rows.hi)
    }

    /// Returns whether the rays of some packets are in random order, in which case the rectangle of
    /// each packet is about as large as the rectangle around all of them.
    pub(crate) fn is_scattered(&self, packets: u64) -> bool {
        let area = |lo: [f32; 2], hi: [f32; 2]| (hi[0] - lo[0]) * (hi[1] - lo[1]);
        let (mut sum, mut lo, mut hi) = (0.0, [f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for packet in (0..self.used).filter(|packet| packets >> packet & 1 != 0) {
            let (group, place) = (packet / 16, packet % 16);
            let least = self.rows.lo[group].map(|row| row[place]);
            let most = self.rows.hi[group].map(|row| row[place]);
            sum += area(least, most);
            for k in 0..2 {
                (lo[k], hi[k]) = (lo[k].min(least[k]), hi[k].max(most[k]));
            }
        }
        // Sixteen random points span about four fifths of the area.
        2.0 * sum > packets.count_ones() as f32 * area(lo, hi)
    }

    /// Sets the windows of a group.
    #[inline(always)]
    fn window_packets(&mut self, group: usize) {
        let used = (self.used - 16 * group).min(16);
        let (mut lo, mut hi) = (self.rows.lo[group], self.rows.hi[group]);
        for k in 0..2 {
            // Unused packets get an empty window, which no triangle reaches.
            lo[k][used..].fill(f32::INFINITY);
            hi[k][used..].fill(f32::NEG_INFINITY);
        }
        let (left, right) = (S::F32x16::load(&lo[0]), S::F32x16::load(&hi[0]));
        let (down, up) = (S::F32x16::load(&lo[1]), S::F32x16::load(&hi[1]));
        self.groups[group].windows = Windows::new([left, down], [right, up]);
        let (lo, hi) = self.window(group, (1 << used) - 1);
        self.groups[group].large = [0, 1].map(|k| LARGE * (hi[k] - lo[k]));
    }

    /// Returns a mask of all packets.
    #[inline(always)]
    pub(crate) fn all(&self) -> u64 {
        u64::MAX >> (PACKETS - self.used)
    }

    /// Makes the given packets the current ones. Returns the window around them.
    #[inline(always)]
    pub(crate) fn ask(&mut self, packets: u64) -> Rectangle {
        let (mut lo, mut hi) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for number in 0..GROUPS {
            let asked = (packets >> (16 * number)) as u32 & 0xffff;
            self.groups[number].asked = asked;
            if asked != 0 {
                let window = self.window(number, asked);
                self.groups[number].window = around::<S>(window);
                for k in 0..2 {
                    (lo[k], hi[k]) = (lo[k].min(window.0[k]), hi[k].max(window.1[k]));
                }
            }
        }
        (lo, hi)
    }

    /// Returns the smallest inverse depth at which a hit of the current packets still counts.
    #[inline(always)]
    pub(crate) fn least(&mut self) -> f32 {
        let mut of_all = f32::INFINITY;
        for group in &mut self.groups {
            if group.asked != 0 {
                let least = chosen::<S>(group.asked, &group.least, f32::INFINITY);
                group.least_of_all = smallest::<S>(least);
                of_all = of_all.min(group.least_of_all);
            }
        }
        of_all
    }

    /// Returns the smallest and largest x and y of the given packets of a group.
    #[inline(always)]
    fn window(&self, group: usize, packets: u32) -> Rectangle {
        let ([x_lo, y_lo], [x_hi, y_hi]) = (&self.rows.lo[group], &self.rows.hi[group]);
        let (least, most) = (f32::INFINITY, f32::NEG_INFINITY);
        let (x, y) = (chosen::<S>(packets, x_lo, least), chosen::<S>(packets, y_lo, least));
        let [x_lo, y_lo, ..] = extremes::<S>(x, y);
        let (x, y) = (chosen::<S>(packets, x_hi, most), chosen::<S>(packets, y_hi, most));
        let [.., left, down] = extremes::<S>(x, y);
        ([x_lo, y_lo], [-left, -down])
    }
}

/// Returns the smallest inverse depth at which a hit of any live ray still counts.
#[inline(always)]
pub(crate) fn least<S: Simd>(nearest: &Nearest<S::F32x16, 16>, live: u32) -> f32 {
    let none = S::F32x16::splat(f32::INFINITY);
    smallest::<S>(S::F32x16::select(sixteen_bits::<S>(live), nearest.least(), none))
}

/// The smallest and the largest x and y.
pub(crate) type Rectangle = ([f32; 2], [f32; 2]);

/// Returns sixteen copies of a window, for testing triangles in lanes.
#[inline(always)]
fn around<S: Simd>((lo, hi): Rectangle) -> Windows<S::F32x16> {
    let splat = S::F32x16::splat;
    Windows::new([splat(lo[0]), splat(lo[1])], [splat(hi[0]), splat(hi[1])])
}

/// Returns sixteen values, with `none` in place of each value whose bit is not set.
#[inline(always)]
fn chosen<S: Simd>(bits: u32, numbers: &[f32; 16], none: f32) -> S::F32x16 {
    S::F32x16::select(sixteen_bits::<S>(bits), Lanes::load(numbers), S::F32x16::splat(none))
}

#[inline(always)]
fn sixteen_bits<S: Simd>(bits: u32) -> <S::F32x16 as Lanes>::Mask {
    Mask::from_bits(bits)
}

/// Returns the rays of the last packet, followed by copies of the last ray.
#[inline(always)]
fn padded(rest: &[Ray], last: Ray) -> [Ray; 16] {
    let mut filled = [last; 16];
    filled[..rest.len()].copy_from_slice(rest);
    filled
}

/// Transposes sixteen rays into columns: the origin and `t_min`, and the direction and `t_max`.
#[inline(always)]
fn side_by_side<S: Simd>(rays: &[Ray; 16]) -> [[S::F32x16; 4]; 2] {
    [S::columns(|i| half(&rays[i], 0)), S::columns(|i| half(&rays[i], 1))]
}

/// Replaces each point that misses the projection with the first point that does not, or with the
/// centre of the projection if all points miss it.
#[inline(always)]
fn instead<S: Simd>(
    mut met: Points<S::F32x16>,
    on_screen: <S::F32x16 as Lanes>::Mask,
) -> Points<S::F32x16> {
    let lane = on_screen.bits().trailing_zeros() as usize;
    for (lanes, middle) in [(&mut met.x, 0.0), (&mut met.y, 0.0), (&mut met.z, 1.0)] {
        let mut numbers = [middle; 16];
        if lane < 16 {
            lanes.store(&mut numbers);
        }
        *lanes = S::F32x16::select(on_screen, *lanes, S::F32x16::splat(numbers[lane % 16]));
    }
    met
}

/// Returns the smallest x and y, and the smallest -x and -y.
#[inline(always)]
fn extremes<S: Simd>(x: S::F32x16, y: S::F32x16) -> [f32; 4] {
    let ([a, b, c, d], [e, f, g, h]) = (fours::<S>(x), fours::<S>(y));
    let (left, right) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
    let (down, up) = (e.min(f).min(g.min(h)), e.max(f).max(g.max(h)));
    // Combine four reductions into one: with the signs flipped, all four are minima.
    let [a, b, c, d] = S::transpose([left, down, -right, -up]);
    let mut least = [0.0; 4];
    a.min(b).min(c.min(d)).store(&mut least);
    least
}
