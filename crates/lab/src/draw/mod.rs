//! Draws the charts of the lab crate, such as speed against accuracy, onset curves, and edge maps.
//! Also contains the drawing tools that the charts share.

mod axis;
mod chart;
mod crossover;
mod edge_maps;
mod heat;
mod labels;
mod marks;
mod offsets;
mod onsets;
mod page;
mod panel;
mod png;
mod svg;

pub use axis::{Log, power};
pub use chart::chart;
pub use crossover::{Race, crossover};
pub use edge_maps::edge_maps;
pub use heat::heat;
pub use offsets::offsets;
pub use onsets::onsets;
pub use page::{Section, page};
pub use png::png;
pub use svg::{Anchor, Font, Svg, width};
