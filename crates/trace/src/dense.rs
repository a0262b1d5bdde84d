//! Triangles so small beside the packets of a tile that rays are faster one by one.
//!
//! ```text
//!   ┌─────────────┐
//!   │ ◿ ◿ ◿ ◿ ◿ ◿ │ H     where triangles of w by h cover the screen once, the window of a packet
//!   │ ◿ ◿ ◿ ◿ ◿ ◿ │       reaches two for each w h of (W + w) (H + h)
//!   └─────────────┘
//!          W
//! ```
//!
//! The first leaves of a tile tell what triangles are like there, and so whether it is worth going on,
//! before much is spent on it.

use intertri::Outlines;
use intertri::lanes::{Lanes, Mask, Simd};

use crate::screen::Screen;
use crate::spread::total;

/// Where a packet reaches more triangles, if they cover the screen once, its rays are faster one by one.
const DENSE: f32 = 56.0;

/// The packets of groups for which triangles like these are too many.
#[inline(always)]
pub(crate) fn dense<S: Simd>(screen: &Screen<S>, leaves: &[Outlines]) -> u64 {
    // What they are like. Some may reach to infinity: then they are not small.
    let (mut sum, mut triangles) = ([0.0; 2], 0);
    for outlines in leaves {
        let ([widths, heights], live) = outlines.sizes::<S::F32x16>();
        sum = [sum[0] + total(widths), sum[1] + total(heights)];
        triangles += live.count_ones();
    }
    let [w, h] = [sum[0] / triangles as f32, sum[1] / triangles as f32];

    // How many of them a packet reaches, on average over its group.
    let mut packets = 0;
    for (number, (lo, hi)) in screen.rectangles().enumerate() {
        let used = screen.used.saturating_sub(16 * number).min(16);
        let load = S::F32x16::load;
        let (x, y) = (load(&hi[0]) - load(&lo[0]), load(&hi[1]) - load(&lo[1]));
        let reached = (x + S::F32x16::splat(w)) * (y + S::F32x16::splat(h));
        let given = <S::F32x16 as Lanes>::Mask::from_bits((1 << used) - 1);
        let reached = total(S::F32x16::select(given, reached, S::F32x16::splat(0.0)));
        let too_many = 2.0 * reached > DENSE * used as f32 * w * h;
        packets |= u64::from(too_many) * ((1 << used) - 1) << (16 * number);
    }
    packets
}
