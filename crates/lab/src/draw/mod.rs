//! Draws the charts (speed against accuracy, onset curves, the table of onsets, walls far from
//! zero, and edge maps) and provides the drawing tools.

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
pub use svg::{Anchor, Font, Svg};

#[cfg(test)]
mod tests;
