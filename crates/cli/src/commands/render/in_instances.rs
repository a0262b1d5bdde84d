//! `intertri render` for models with instances, in f64 with the `exact` engine. The image is the
//! same as for the flattened model, but takes less memory to draw.

use std::time::Instant;

use intertri_scene::{InstancedMesh, shade};

use super::cover::cover;
use super::options::Options;
use super::outcome::report;
use crate::engine::frame::{Frame, Shadows};
use crate::engine::instances::Instances;
use crate::engine::model::ModelNotes;
use crate::error::Result;
use crate::io::progress::timed;
use crate::report::print::print;
use crate::report::render::{InstanceCounts, RenderReport, RenderSeconds};
use crate::report::rounding::Rounded;

/// Draws the image of a model that took `load` seconds to load.
pub(super) fn run(
    options: &Options,
    (model, notes): (InstancedMesh, ModelNotes),
    load: f64,
    start: Instant,
) -> Result<()> {
    let mut seconds = RenderSeconds { load, ..RenderSeconds::default() };
    let (width, height) = options.size;
    let scene = timed(&mut seconds.load, || {
        let mut scene = options.camera.scene_of(model, f64::from(width) / f64::from(height))?;
        cover(options, &mut scene)?;
        Ok::<_, crate::error::Error>(scene)
    })?;
    let engine = timed(&mut seconds.build, || Instances::new(&scene.mesh))?;
    let frame = Frame::traced(&scene, options.size, &engine, options.shadows == Shadows::Rays)?;
    (seconds.trace, seconds.shadow) = (frame.trace_seconds, frame.shadow_seconds);

    let image =
        timed(&mut seconds.shade, || shade(&scene, width, height, &frame.hits, &frame.lit))?;
    timed(&mut seconds.write, || image.write_png(&options.output))?;
    seconds.total = start.elapsed().as_secs_f64();
    let instances = Some(counts(&scene.mesh));
    let report = report(options, (&scene, notes), &frame, Rounded::default(), None, seconds, None);
    print(&RenderReport { instances, ..report }, options.json)
}

/// Counts the instances, the meshes, and the triangles of the meshes.
fn counts(InstancedMesh { meshes, instances }: &InstancedMesh) -> InstanceCounts {
    let mesh_triangles = meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum();
    InstanceCounts { instances: instances.len(), meshes: meshes.len(), mesh_triangles }
}
