//! Creates the report of `intertri render`, and the error for a check that failed.

use intertri::Threshold;
use intertri_scene::{Coordinate, Scene, SceneGeometry};

use super::options::Options;
use crate::engine::fixed::GridReport;
use crate::engine::frame::Frame;
use crate::engine::model::ModelNotes;
use crate::engine::scalar_name::ScalarName;
use crate::error::{Error, Result};
use crate::report::render::{CheckReport, RenderReport, RenderSeconds};
use crate::report::rounding::Rounded;

/// Creates the report.
pub(super) fn report<S: Coordinate, M: SceneGeometry<S>>(
    options: &Options,
    (scene, notes): (&Scene<S, M>, ModelNotes),
    frame: &Frame,
    rounded: Rounded,
    grid: Option<GridReport>,
    seconds: RenderSeconds,
    check: Option<CheckReport>,
) -> RenderReport {
    let (up, up_given) = options.camera.up(&scene.camera);
    let threshold = options.engine.has_threshold().then(|| options.threshold.unwrap_or_default());
    RenderReport {
        model: options.model.clone(),
        output: options.output.clone(),
        triangles: scene.mesh.triangle_count(),
        instances: None,
        notes,
        size: options.size.into(),
        engine: options.engine,
        scalar: ScalarName::of::<S>(),
        rounded,
        shadows: options.shadows,
        threshold: threshold.map(Threshold::get),
        up,
        up_given,
        rays: frame.hits.len() as u64,
        hits: frame.seen(),
        dark: frame.dark(),
        shadow_rays: frame.shadow_rays,
        tests: frame.counts.tests,
        undecided: frame.counts.undecided,
        grid,
        seconds,
        check,
    }
}

/// Returns an error if there are differences that are not excused.
pub(super) fn refuse_differences(check: &CheckReport) -> Result<()> {
    if check.differing_pixels > check.excused_pixels {
        return Err(Error::at(
            check.picture.display(),
            format!(
                "{} pixels differ between the two engines",
                check.differing_pixels - check.excused_pixels
            ),
        ));
    }
    Ok(())
}
