//! The rays of a tile side by side, as points of a screen.
//!
//! ```text
//!   four rays in memory      four registers      sixteen rays a packet,
//!   o t_min d t_max ───┐                         sixteen packets a group, four groups a tile
//!   o t_min d t_max ───┼──►  x x x x             ┌──┬──┬──┬──┐  a window a packet and a group;
//!   o t_min d t_max ───┤     y y y y   ──►       ├──┼──┼──┼──┤  level with the way in
//!   o t_min d t_max ───┘     z z z z             └──┴──┴──┴──┘  which the rays spread most
//! ```

use intertri::lanes::{Lanes, Mask, Simd};
use intertri::{Certified, Frame, Nearest, Points, Ranges, Ray, Starts, Threshold, Vec3, Windows};

use crate::ahead::Ahead;
use crate::pyramid;
use crate::spread::{Spread, total};
use crate::tile::Pencil;
use crate::toward::Turning;

/// Rays of a tile, at most.
pub(crate) const RAYS: usize = 1024;

/// Sixteen rays each.
pub(crate) const PACKETS: usize = RAYS / 16;

/// Sixteen packets each, so that a triangle is held against the windows of a group at once.
pub(crate) const GROUPS: usize = PACKETS / 16;

/// Where rays go is told by so many of them, or fewer.
const SAMPLE: usize = 64;

/// One ray in so many may be left out of a tile.
const STRAYS: usize = 2;

/// Triangles larger than this share of a group's window, along x or y, are held against the windows of
/// packets by their edges, too.
const LARGE: f32 = 0.5;

/// Whether all rays start at the same point, to the bit.
#[inline(always)]
pub(crate) fn shares_origin<R: AsRef<Ray>>(rays: &[R]) -> bool {
    let [first, second, .., last] = rays else { return false };
    let origin = bits(first);
    let mut other = [0; 4];
    differ(origin, bits(second), &mut other);
    differ(origin, bits(last), &mut other);
    if other[..3] == [0; 3] {
        for ray in rays {
            differ(origin, bits(ray), &mut other);
        }
    }
    other[..3] == [0; 3]
}

/// The numbers of a ray as bits.
#[inline(always)]
fn bits(ray: &impl AsRef<Ray>) -> &[u32; 8] {
    bytemuck::cast_ref(ray.as_ref())
}

/// Notes in which bits the first four numbers of two rays differ.
#[inline(always)]
fn differ(a: &[u32; 8], b: &[u32; 8], other: &mut [u32; 4]) {
    for k in 0..4 {
        other[k] |= a[k] ^ b[k];
    }
}

/// Origin and `t_min` of a ray, or its direction and `t_max`.
#[inline(always)]
fn half(ray: &impl AsRef<Ray>, half: usize) -> &[f32; 4] {
    let halves: &[[f32; 4]; 2] = bytemuck::cast_ref(ray.as_ref());
    &halves[half]
}

/// The rays of a tile side by side, as points of a screen, and what they have hit so far. Made once for
/// many tiles: making it takes longer than some tiles do.
pub(crate) struct Screen<S: Simd> {
    pub(crate) frame: Frame,
    pub(crate) points: [Points<S::F32x16>; PACKETS],
    pub(crate) nearest: [Nearest<S::F32x16, 16>; PACKETS],
    rows: Rows,
    pub(crate) groups: [Group<S>; GROUPS],
    /// How many packets there are.
    pub(crate) used: usize,
    /// No z is smaller.
    pub(crate) slowest: f32,
    /// The near ends of the rays of all packets.
    pub(crate) ranges: Ranges<S::F32x16>,
    /// Bit i of `live[p]`: ray `16 p + i` looks for a hit.
    pub(crate) live: [u32; PACKETS],
    /// Bit i of `strays[p]`: ray `16 p + i` does not meet the screen, and is not asked.
    strays: [u32; PACKETS],
    pub(crate) has_strays: bool,
}

/// The smallest and largest x and y of each packet, by group: sixteen a cache line.
#[repr(C, align(64))]
struct Rows {
    lo: [[[f32; 16]; 2]; GROUPS],
    hi: [[[f32; 16]; 2]; GROUPS],
}

/// Sixteen packets.
#[derive(Clone, Copy)]
pub(crate) struct Group<S: Simd> {
    /// A window a packet.
    pub(crate) windows: Windows<S::F32x16>,
    /// The one around those that are asked now.
    pub(crate) window: Windows<S::F32x16>,
    /// Triangles that are larger than this, along x or y, reach several packets.
    pub(crate) large: [f32; 2],
    /// The least inverse depth at which a hit still counts, of each packet and of those asked now.
    pub(crate) least: [f32; 16],
    pub(crate) least_of_all: f32,
    /// Bit p is set where packet p is asked now.
    pub(crate) asked: u32,
}

impl<S: Simd> Screen<S> {
    /// A screen without rays.
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
            nearest: [Nearest::new(&points, zero); PACKETS],
            rows: Rows { lo: [[sixteen; 2]; GROUPS], hi: [[sixteen; 2]; GROUPS] },
            groups: [group; GROUPS],
            used: 0,
            slowest: 0.0,
            ranges: Starts::none().ranges(),
            live: [0; PACKETS],
            strays: [0; PACKETS],
            has_strays: false,
        }
    }

    /// Whether a ray does not meet the screen.
    pub(crate) fn is_stray(&self, ray: usize) -> bool {
        self.strays[ray / 16] >> (ray % 16) & 1 != 0
    }

    /// Lays rays on the screen, and asks all of them; some of those ahead are asked for from memory meanwhile.
    /// Gives the window around them; `None` where too many go too far apart, or numbers are too large or too small.
    #[inline(always)]
    pub(crate) fn lay<R: AsRef<Ray> + Copy>(
        &mut self,
        mode: &Certified,
        pencil: &Pencil<'_, R>,
        reach: f32,
        ahead: &mut Ahead<'_, R>,
    ) -> Option<Rectangle> {
        let Pencil { rays, toward, .. } = *pencil;
        self.frame = look::<S, R>(pencil, reach)?;
        self.used = rays.len().div_ceil(16);

        // Turned round, they have the threshold at their far ends.
        let (mut turning, mut starts_by) = (None, *mode);
        if let Some(toward) = toward {
            turning = Some(Turning::<S::F32x16>::new(toward));
            starts_by = Certified::new(Threshold::ZERO);
        }

        // The last packet is filled with the last ray.
        let (full, rest) = rays.as_chunks::<16>();
        let mut filled = [rays[rays.len() - 1]; 16];
        filled[..rest.len()].copy_from_slice(rest);

        let endless = rays[0].as_ref().t_max >= f32::INFINITY;
        let (mut slowest, mut starts) = (S::F32x16::splat(f32::INFINITY), Starts::none());
        let mut strays = 0;
        for packet in 0..self.used {
            ahead.ask(4);

            // Side by side.
            let sixteen_rays = full.get(packet).unwrap_or(&filled);
            let mut columns = side_by_side::<S, R>(sixteen_rays);
            if let Some(turning) = &mut turning {
                columns = turning.turn(columns);
            }
            let [[.., near], [x, y, z, far]] = columns;

            // Where they meet the screen. Those that do not are left out.
            let mut met = self.frame.points(Vec3 { x, y, z });
            let on_screen = met.on_screen();
            let stray = !on_screen.bits() & 0xffff;
            if stray != 0 {
                met = instead::<S>(met, on_screen);
                strays += stray.count_ones() as usize;
            }
            self.strays[packet] = stray;
            self.points[packet] = met;
            slowest = slowest.min(met.z);
            let [x, y, left, down] = extremes::<S>(met.x, met.y);
            let (group, place) = (packet / 16, packet % 16);
            let Rows { lo, hi } = &mut self.rows;
            (lo[group][0][place], lo[group][1][place]) = (x, y);
            (hi[group][0][place], hi[group][1][place]) = (-left, -down);

            // Nothing is hit yet.
            let given = (1 << (rays.len() - 16 * packet).min(16)) - 1;
            let asked = sixteen_bits::<S>(given) & on_screen;
            let live = near.lt(far) & far.gt(S::F32x16::splat(0.0)) & asked;
            self.live[packet] = live.bits();
            starts = starts_by.starts_in(&starts, &met, near, live);
            let nearest = Nearest::new(&met, far);
            self.nearest[packet] = nearest;
            self.groups[group].least[place] =
                if endless { 0.0 } else { least::<S>(&nearest, live.bits()) };
        }
        self.has_strays = strays > 0;
        if strays > rays.len() / STRAYS {
            return None;
        }
        self.slowest = smallest::<S>(slowest) * (1.0 - 1e-6);
        self.ranges = starts.ranges();

        for number in 0..self.used.div_ceil(16) {
            self.window_packets(number);
        }
        let (lo, hi) = self.ask(self.all());

        // Turned round, they may pass the origin.
        if let Some(turning) = &turning {
            let most = [(-lo[0]).max(hi[0]), (-lo[1]).max(hi[1])];
            self.frame = self.frame.passed_within(turning.off()?, most);
        }
        Some((lo, hi))
    }

    /// The rectangles of packets, by group: the smallest x and y of each, and the largest.
    pub(crate) fn rectangles(&self) -> impl Iterator<Item = (&[[f32; 16]; 2], &[[f32; 16]; 2])> {
        self.rows.lo.iter().zip(&self.rows.hi)
    }

    /// The windows of a group; where it has fewer packets, windows that nothing reaches.
    #[inline(always)]
    fn window_packets(&mut self, group: usize) {
        let used = (self.used - 16 * group).min(16);
        let (mut lo, mut hi) = (self.rows.lo[group], self.rows.hi[group]);
        for k in 0..2 {
            lo[k][used..].fill(f32::INFINITY);
            hi[k][used..].fill(f32::NEG_INFINITY);
        }
        let (left, right) = (S::F32x16::load(&lo[0]), S::F32x16::load(&hi[0]));
        let (down, up) = (S::F32x16::load(&lo[1]), S::F32x16::load(&hi[1]));
        self.groups[group].windows = Windows::new([left, down], [right, up]);
        let (lo, hi) = self.window(group, (1 << used) - 1);
        self.groups[group].large = [0, 1].map(|k| LARGE * (hi[k] - lo[k]));
    }

    /// All packets, a bit each.
    #[inline(always)]
    pub(crate) fn all(&self) -> u64 {
        u64::MAX >> (PACKETS - self.used)
    }

    /// Asks only these packets from now on. Gives the window around them.
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

    /// The least inverse depth at which a hit of those asked now still counts.
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

    /// The smallest and largest x and y of some packets of a group.
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

/// The least inverse depth at which a hit of some live ray still counts.
#[inline(always)]
pub(crate) fn least<S: Simd>(nearest: &Nearest<S::F32x16, 16>, live: u32) -> f32 {
    let none = S::F32x16::splat(f32::INFINITY);
    smallest::<S>(S::F32x16::select(sixteen_bits::<S>(live), nearest.least(), none))
}

/// The lowest and the highest x and y.
pub(crate) type Rectangle = ([f32; 2], [f32; 2]);

/// A window for sixteen triangles at once.
#[inline(always)]
fn around<S: Simd>((lo, hi): Rectangle) -> Windows<S::F32x16> {
    let splat = S::F32x16::splat;
    Windows::new([splat(lo[0]), splat(lo[1])], [splat(hi[0]), splat(hi[1])])
}

/// Sixteen numbers, or `none` where their bit is not set.
#[inline(always)]
fn chosen<S: Simd>(bits: u32, numbers: &[f32; 16], none: f32) -> S::F32x16 {
    S::F32x16::select(sixteen_bits::<S>(bits), Lanes::load(numbers), S::F32x16::splat(none))
}

#[inline(always)]
fn sixteen_bits<S: Simd>(bits: u32) -> <S::F32x16 as Lanes>::Mask {
    Mask::from_bits(bits)
}

/// Sixteen lanes as four times four.
#[inline(always)]
fn fours<S: Simd>(lanes: S::F32x16) -> [S::F32x4; 4] {
    let mut n = [0.0; 16];
    lanes.store(&mut n);
    [Lanes::load(&n), Lanes::load(&n[4..]), Lanes::load(&n[8..]), Lanes::load(&n[12..])]
}

/// The smallest lane.
#[inline(always)]
pub(crate) fn smallest<S: Simd>(lanes: S::F32x16) -> f32 {
    let [a, b, c, d] = fours::<S>(lanes);
    let mut numbers = [0.0; 4];
    a.min(b).min(c.min(d)).store(&mut numbers);
    let less = |a: f32, b: f32| if a < b { a } else { b };
    less(less(numbers[0], numbers[1]), less(numbers[2], numbers[3]))
}

/// A frame that looks where a sample of the rays goes.
#[inline(always)]
fn look<S: Simd, R: AsRef<Ray> + Copy>(pencil: &Pencil<'_, R>, reach: f32) -> Option<Frame> {
    let rays = pencil.rays;
    let [first, second] = [rays[0].as_ref().dir, rays[1].as_ref().dir];
    let (apart, mut sum) = (rays.len().div_ceil(SAMPLE), [S::F32x16::splat(0.0); 3]);
    let mut spread = Spread::about(first);
    for begin in (0..rays.len()).step_by(16 * apart) {
        let some = |i: usize| half(&rays[(begin + i * apart).min(rays.len() - 1)], 1);
        let [x, y, z, _] = S::columns(some);
        sum = [sum[0] + x, sum[1] + y, sum[2] + z];
        spread.add([x, y, z]);
    }
    let sign = if pencil.toward.is_some() { -1.0 } else { 1.0 };
    let sum = [sign * total(sum[0]), sign * total(sum[1]), sign * total(sum[2])];
    let step = [0, 1, 2].map(|k| second[k] - first[k]);
    pyramid::frame(pencil.origin(), sum, step, &spread, reach)
}

/// The numbers of sixteen rays by column: of origin and `t_min`, and of direction and `t_max`.
#[inline(always)]
fn side_by_side<S: Simd, R: AsRef<Ray>>(rays: &[R; 16]) -> [[S::F32x16; 4]; 2] {
    [S::columns(|i| half(&rays[i], 0)), S::columns(|i| half(&rays[i], 1))]
}

/// Points with the first of those on the screen in the place of those that are not; the screen's middle if
/// all are not.
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

/// The smallest x and y, and the smallest -x and -y.
#[inline(always)]
fn extremes<S: Simd>(x: S::F32x16, y: S::F32x16) -> [f32; 4] {
    let ([a, b, c, d], [e, f, g, h]) = (fours::<S>(x), fours::<S>(y));
    let (left, right) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
    let (down, up) = (e.min(f).min(g.min(h)), e.max(f).max(g.max(h)));
    let [a, b, c, d] = S::transpose([left, down, -right, -up]);
    let mut least = [0.0; 4];
    a.min(b).min(c.min(d)).store(&mut least);
    least
}
