//! Renders SVG images as PNG files.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::svg::Svg;

/// The number of pixels per SVG unit.
const SCALE: f32 = 2.0;

/// Renders an SVG as a PNG file.
///
/// # Errors
/// Returns a one-line message if no fonts are installed, or if the image's size is invalid for a
/// PNG.
pub fn png(svg: &Svg) -> Result<Vec<u8>, String> {
    let mut fonts = fontdb::Database::new();
    fonts.load_system_fonts();
    if fonts.is_empty() {
        return Err("no fonts are installed, so a PNG would have no text; use the SVG".into());
    }
    // Render sans-serif text in the first of these fonts that is installed, or else in any font.
    let any = ["DejaVu Sans", "Verdana", "Arial", "Helvetica", "Liberation Sans", "Noto Sans"];
    let has = |name: &&&str| fonts.faces().any(|face| face.families.iter().any(|f| f.0 == **name));
    let family = any.iter().find(has).map_or_else(
        || fonts.faces().next().and_then(|face| face.families.first()).map(|f| f.0.clone()),
        |name| Some((*name).to_owned()),
    );
    if let Some(family) = &family {
        fonts.set_sans_serif_family(family.clone());
    }
    let options = Options { fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(&svg.to_string(), &options).map_err(|error| error.to_string())?;

    let size = tree.size();
    let (width, height) = ((size.width() * SCALE) as u32, (size.height() * SCALE) as u32);
    let mut pixels = Pixmap::new(width, height)
        .ok_or_else(|| format!("cannot create an image of {width}×{height} pixels"))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| error.to_string())
}
