//! Computes the transforms of nodes and instances.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::scene;

/// Returns the transform from a node's space to its parent's.
pub(super) fn transform(node: &scene::Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, or: f64| v.map_or([or; 3], |v| v.map(f64::from));
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    of_parts(vector(node.scale, 1.0), rotation, vector(node.translation, 0.0))
}

/// Returns the transform that scales, then rotates, then translates.
pub(super) fn of_parts(scale: [f64; 3], rotation: [f64; 4], translation: [f64; 3]) -> DMat4 {
    let rotation = DQuat::from_array(rotation);
    // The rotation should have unit length, but f32 rounding may change its length slightly.
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(DVec3::from(scale), rotation, DVec3::from(translation))
}

/// Returns whether a transform mirrors and therefore makes counter-clockwise triangles clockwise.
pub(super) fn mirrors(transform: &DMat4) -> bool {
    let axes = [transform.x_axis, transform.y_axis, transform.z_axis];
    let [x, y, z] = axes.map(|axis| axis.truncate().normalize_or_zero());
    x.cross(y).dot(z) < 0.0
}
