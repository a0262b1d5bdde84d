//! Traverses the node tree, which determines where meshes are placed.

use glam::DMat4;
use gltf::json::accessor::Type;
use gltf::json::{Index, Root, scene, skin};

use super::extensions::{copies, is_hidden};
use super::primitive::Primitives;
use super::shared::SharedMeshes;
use super::transform::transform;
use crate::load::error::{Fault, fault};

/// Adds the meshes of all visible nodes, parents before children.
pub(super) fn walk(shared: &mut SharedMeshes<'_>) -> Result<(), Fault> {
    let root = shared.primitives.tables.root;
    let joints = if root.skins.is_empty() { vec![] } else { all_transforms(root)? };
    let mut reached = vec![false; root.nodes.len()];
    let mut next: Vec<(usize, DMat4)> = Vec::new();
    next.extend(roots(root)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)));
    while let Some((index, above)) = next.pop() {
        let Some(node) = root.nodes.get(index) else {
            return fault(format!("node {index} does not exist; there are {}", root.nodes.len()));
        };
        if std::mem::replace(&mut reached[index], true) {
            return fault(format!("node {index} is reached twice; nodes must form a tree"));
        }
        if is_hidden(node) {
            continue;
        }
        let transform = above * transform(node);
        add(shared, node, transform, &joints).map_err(|fault| match node.skin {
            // Errors about a mesh already contain its index.
            None => fault,
            Some(skin) => Fault { cause: format!("skin {skin}: {}", fault.cause), ..fault },
        })?;
        let children = node.children.iter().flatten().rev();
        next.extend(children.map(|child| (child.value(), transform)));
    }
    Ok(())
}

/// Adds a node's mesh, if the node has one.
fn add<'a>(
    shared: &mut SharedMeshes<'a>,
    node: &'a scene::Node,
    transform: DMat4,
    joints: &[DMat4],
) -> Result<(), Fault> {
    let Some(mesh) = node.mesh else { return Ok(()) };
    let primitives = &mut shared.primitives;
    let weights = primitives.weights(mesh.value(), node.weights.as_deref())?;
    let copies = copies(primitives.tables, node)?;
    // Count the copies before adding them: a table of zeros takes up no bytes, so it can have any
    // number of rows.
    primitives.spend(copies.as_ref().map_or(0, |copies| copies.count))?;
    if let Some(skin) = node.skin {
        // A skinned mesh is placed by its joints, not by its node or by instances, so it is added
        // only once.
        if copies.is_some_and(|copies| copies.count != 1) {
            primitives.notes.add("skinned meshes with instances, read once", 1, None);
        }
        let joints = skin_of(primitives, skin, joints)?;
        return shared.add_skinned(mesh.value(), weights.values, &joints, transform);
    }
    let Some(copies) = copies else { return shared.add(mesh.value(), weights, [transform]) };
    let transforms = (0..copies.count).map(|i| transform * copies.transform(i));
    shared.add(mesh.value(), weights, transforms)
}

/// Returns a skin's joint matrices, which move vertices from the bind pose to the joints' current
/// pose.
fn skin_of(
    primitives: &mut Primitives<'_>,
    index: Index<skin::Skin>,
    transforms: &[DMat4],
) -> Result<Vec<DMat4>, Fault> {
    let tables = primitives.tables;
    let Some(skin) = tables.root.skins.get(index.value()) else { return fault("does not exist") };
    primitives.spend(skin.joints.len())?;
    let inverse = skin.inverse_bind_matrices;
    let inverse = inverse.map(|i| tables.get(i, ("joints", Type::Mat4))).transpose()?;
    if inverse.as_ref().is_some_and(|inverse| inverse.count < skin.joints.len()) {
        return fault("has fewer inverse bind matrices than joints");
    }
    let joint = |(i, joint): (usize, &Index<scene::Node>)| {
        let Some(transform) = transforms.get(joint.value()) else {
            return fault(format!("joint {joint} does not exist"));
        };
        let inverse = inverse.as_ref();
        let inverse =
            inverse.map_or(DMat4::IDENTITY, |inverse| DMat4::from_cols_array(&inverse.row(i)));
        Ok(*transform * inverse)
    };
    skin.joints.iter().enumerate().map(joint).collect()
}

/// Returns the transform from each node's space to the scene's, or NaN for nodes in a cycle.
fn all_transforms(root: &Root) -> Result<Vec<DMat4>, Fault> {
    let mut transforms = vec![DMat4::NAN; root.nodes.len()];
    let mut reached = vec![false; root.nodes.len()];
    let mut next: Vec<(usize, DMat4)> =
        tops(root).into_iter().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, above)) = next.pop() {
        let Some(node) = root.nodes.get(index) else {
            return fault(format!("node {index} does not exist; there are {}", root.nodes.len()));
        };
        if std::mem::replace(&mut reached[index], true) {
            return fault(format!("node {index} is reached twice; nodes must form a tree"));
        }
        transforms[index] = above * transform(node);
        next.extend(node.children.iter().flatten().map(|child| (child.value(), transforms[index])));
    }
    Ok(transforms)
}

/// Returns the root nodes of the default scene, which is scene 0 unless the file names another, or
/// all nodes without a parent if there are no scenes.
fn roots(root: &Root) -> Result<Vec<usize>, Fault> {
    let index = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(index) {
        Some(scene) => Ok(scene.nodes.iter().map(Index::value).collect()),
        None if root.scene.is_some() => {
            fault(format!("scene {index} does not exist; there are {}", root.scenes.len()))
        }
        None => Ok(tops(root)),
    }
}

/// Returns the nodes without a parent.
fn tops(root: &Root) -> Vec<usize> {
    let mut top = vec![true; root.nodes.len()];
    for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
        if let Some(top) = top.get_mut(child.value()) {
            *top = false;
        }
    }
    (0..top.len()).filter(|&node| top[node]).collect()
}
