//! Warnings about scenes that are too small, too distant or lit from too far away for the default
//! tolerances or for f32. They are printed before the scene is drawn.

use intertri::{Threshold, Triangle};
use intertri_scene::{Coordinate, Light, Mesh, Scene};

use crate::io::numbers::Decimal;

/// If the sine of the angle between a light ray and a surface is below this value, the surface is
/// hardly lit, so a missing shadow is not visible.
const FLAT: f64 = 0.01;

/// If a light is farther away than this many times a model's size, shadows visibly begin some
/// distance behind the objects that cast them. That distance is a ten-thousandth of the distance
/// from the light, because of [`Light::REACH`].
const FAR: f64 = 100.0;

/// Returns a warning if a scene is so small that the default threshold hides triangles from its
/// rays.
///
/// The threshold limits `|normal . direction|` and t. A shadow ray's direction is as long as the
/// segment that the ray covers, and a camera ray's t is a distance.
pub(crate) fn small(scene: &Scene, triangles: &[Triangle]) -> Option<String> {
    let (middle, radius) = middle_and_radius(scene)?;
    let threshold = Threshold::DEFAULT.get();
    let ends = [scene.camera.eye(), scene.light.origin(middle)];
    let [eye, light] = ends.map(|end| span(end.map(f64::from), middle).max(radius));
    let length = eye.min(light);
    if length <= 0.0 || threshold <= FLAT * length {
        return None;
    }
    let hidden = triangles.iter().filter(|triangle| is_hidden(scene, triangle, threshold)).count();
    // Relative to rays of this length, the recommended threshold is at most as large as the default
    // is relative to rays of length 1.
    let power = (length * threshold).log10().floor();
    (hidden > 0).then(|| {
        format!(
            "the model is so small that the threshold of {threshold:e} hides {hidden} of its {} \
             triangles, or their shadows; set --threshold 1e{power}",
            triangles.len()
        )
    })
}

/// Returns whether the threshold hides a triangle from the camera or the light. The light counts
/// only if the sine of the angle between its rays and the triangle is above [`FLAT`].
fn is_hidden(scene: &Scene, triangle: &Triangle, threshold: f64) -> bool {
    let middle = [0, 1, 2].map(|k| triangle.0.iter().map(|p| f64::from(p[k])).sum::<f64>() / 3.0);
    let normal = triangle.normal();
    let dir = scene.light.shadow_ray(middle).dir.map(f64::from);
    let across = (0..3).map(|k| normal[k] * dir[k]).sum::<f64>().abs() / span(normal, [0.0; 3]);
    let slant = across / span(dir, [0.0; 3]);
    span(scene.camera.eye().map(f64::from), middle) <= threshold
        || (across <= threshold && slant > FLAT)
}

/// Rounding becomes visible if adjacent f32 values are farther apart than this fraction of a
/// model's size.
const COARSE: f64 = 1e-5;

/// Returns a warning if a model loses most of its digits in f32, because it is far from the origin
/// or as small as the smallest f32.
pub(crate) fn coarse(mesh: &Mesh) -> Option<String> {
    let bounds = mesh.bounds()?;
    let ends = [bounds.min, bounds.max];
    let farthest = ends.as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    let apart = f64::from(farthest) - f64::from(farthest.next_down());
    let size = span(bounds.min.map(f64::from), bounds.max.map(f64::from));
    // The f32 values below this limit are equally spaced.
    let why =
        if farthest < f32::MIN_POSITIVE { "is so small" } else { "is so far from the origin" };
    (size > 0.0 && apart > COARSE * size).then(|| {
        format!(
            "the model {why} that coordinates in f32 are {} apart there; add --scalar f64 to read and \
             trace it in f64",
            Decimal(apart)
        )
    })
}

/// Returns a warning if the light of a scene is too far away.
pub(crate) fn far<S: Coordinate>(scene: &Scene<S>) -> Option<String> {
    let Light::Point { position } = scene.light else { return None };
    let (middle, radius) = middle_and_radius(scene)?;
    (span(position.map(Into::into), middle) > FAR * radius).then(|| {
        "the light is so far away that shadows begin some distance behind the objects that cast \
         them; give its direction with --sun X,Y,Z"
            .to_owned()
    })
}

/// Returns the centre of a scene's bounding box and half the length of its diagonal.
fn middle_and_radius<S: Coordinate>(scene: &Scene<S>) -> Option<([f64; 3], f64)> {
    let bounds = scene.mesh.bounds()?;
    let [min, max]: [[f64; 3]; 2] = [bounds.min, bounds.max].map(|corner| corner.map(Into::into));
    let middle = [0, 1, 2].map(|k| (min[k] + max[k]) * 0.5);
    Some((middle, span(min, max) * 0.5))
}

fn span(from: [f64; 3], to: [f64; 3]) -> f64 {
    (0..3).map(|k| (to[k] - from[k]).powi(2)).sum::<f64>().sqrt()
}
