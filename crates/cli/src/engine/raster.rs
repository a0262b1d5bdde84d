//! The independent rasterizer: the z-buffer and the shadow volumes for one image of a scene.

use std::cell::OnceCell;

use clap::ValueEnum;
use intertri::{Hit, Threshold, Triangle};
use intertri_raster::{Adjacency, Light, View, Volume, facing, lit, silhouette, triangles, wire};
use intertri_scene::{Image, Light as Lamp, Scene};
use serde::Serialize;

use crate::error::{Error, Result};

/// The largest number of triangles that the shadow volumes can count.
const MAX_TRIANGLES: usize = (1 << 30) - 1;

/// The colour of edges.
const INK: [u8; 3] = [24, 26, 32];

/// The edges to draw.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Wire {
    /// The edges of all triangles
    Mesh,
    /// Only the silhouette: edges where the mesh turns away from the eye or ends
    Silhouette,
}

/// One image of a scene. All of its data is computed on demand.
pub(crate) struct Raster<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) triangles: &'a [Triangle],
    /// The image's width and height.
    pub(crate) size: (u32, u32),
    threshold: Threshold,
    /// The triangles that share each edge.
    adjacency: OnceCell<Adjacency>,
}

impl<'a> Raster<'a> {
    /// Prepares an image of the given size from the scene's camera.
    pub(crate) fn new(
        scene: &'a Scene,
        triangles: &'a [Triangle],
        size: (u32, u32),
        threshold: Threshold,
    ) -> Self {
        Self { scene, triangles, size, threshold, adjacency: OnceCell::new() }
    }

    /// Converts the camera to the rasterizer's type.
    pub(crate) fn view(&self) -> Result<View> {
        let count = self.triangles.len();
        if count > MAX_TRIANGLES {
            return Err(Error::new(format!(
                "raster: {count} triangles are too many; the limit is {MAX_TRIANGLES}"
            )));
        }
        let (camera, (width, height)) = (&self.scene.camera, self.size);
        Ok(View::new(camera.eye(), camera.axes(), camera.half_height(), width, height)?)
    }

    /// Computes the hit at each pixel.
    pub(crate) fn hits(&self) -> Result<Vec<Hit>> {
        Ok(triangles(&self.view()?, self.triangles, self.threshold.get()))
    }

    /// Computes whether the light reaches the point that each pixel shows.
    pub(crate) fn lit(&self, hits: &[Hit]) -> Result<Vec<bool>> {
        Ok(lit(&self.view()?, hits, &self.volume()?))
    }

    /// Returns the shadow volumes, with the same reach as shadow rays.
    pub(crate) fn volume(&self) -> Result<Volume<'_>> {
        let reach = f64::from(Lamp::REACH);
        let light = match self.scene.light {
            Lamp::Point { position } => Light::Point { position, reach },
            Lamp::Directional { toward } => Light::Directional { toward, reach },
        };
        Ok(Volume::new(self.adjacency(), light)?)
    }

    fn adjacency(&self) -> &Adjacency {
        self.adjacency.get_or_init(|| Adjacency::new(self.triangles))
    }

    /// Draws edges over an image. Edges behind the hit at a pixel are hidden.
    pub(crate) fn draw_wire(&self, image: &mut Image, hits: &[Hit], edges: Wire) -> Result<()> {
        let view = self.view()?;
        let adjacency = self.adjacency();
        let edges: Vec<[u32; 2]> = match edges {
            Wire::Mesh => adjacency.edges().map(|edge| edge.ends).collect(),
            Wire::Silhouette => {
                // The outline is the silhouette as seen from a light at the eye.
                let eye = self.scene.camera.eye();
                let facing = facing(adjacency, &Light::Point { position: eye, reach: 1.0 });
                silhouette(adjacency, &facing).iter().map(|edge| edge.ends).collect()
            }
        };
        let drawn = wire(&view, hits, adjacency, edges);
        for (pixel, _) in image.pixels_mut().iter_mut().zip(drawn).filter(|(_, drawn)| *drawn) {
            *pixel = INK;
        }
        Ok(())
    }
}
