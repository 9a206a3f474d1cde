//! Skins and morph targets. Meshes are posed on the CPU, so that silhouettes, bounds, shadow volumes and the
//! picture all use the same vertices.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{Mat3, Mat4};

use super::placement::placed;
use super::{MeshData, MorphWeights, PosedMesh, SceneMesh, Skin};

/// Poses meshes with a [`Skin`] or [`MorphWeights`] into their [`PosedMesh`]: morph targets first, then
/// joints.
///
/// Set: `UpdateBounds`, after transform propagation, before
/// [`update_local_bounds`](super::update_local_bounds).
///
/// Vertices that are equal in all streams are posed to equal bits, and equal input gives equal output. A mesh
/// keeps its last pose while its own transform is not finite or while a joint is missing or not finite; if it
/// has no pose yet, it gets its rest pose. The joints alone decide where a skinned mesh is, so the scale of its
/// own transform has no effect. Cost: the vertices of the meshes that moved. Nothing is allocated after the
/// first frame of a mesh.
#[allow(clippy::type_complexity, reason = "a query says what the system reads")]
pub fn pose_meshes(
    mut meshes: Query<(
        Entity,
        Ref<SceneMesh>,
        Option<Ref<Skin>>,
        Option<Ref<MorphWeights>>,
        Option<Ref<GlobalTransform>>,
        &mut PosedMesh,
    )>,
    transforms: Query<Ref<GlobalTransform>>,
    mut removed_skins: RemovedComponents<Skin>,
    mut removed_weights: RemovedComponents<MorphWeights>,
    mut relaxed: Local<Vec<Entity>>,
    mut local_from_bind: Local<Vec<Mat4>>,
) {
    relaxed.clear();
    relaxed.extend(removed_skins.read().chain(removed_weights.read()));

    for (entity, mesh, skin, weights, own_transform, mut posed) in &mut meshes {
        let data = &*mesh.0;
        let skin = skin.filter(|_| !data.joints.is_empty());
        let is_moved = |joint: &Entity| transforms.get(*joint).is_ok_and(|joint| joint.is_changed());
        let needs_pose = mesh.is_changed()
            || weights.as_ref().is_some_and(|weights| weights.is_changed())
            || skin.as_ref().is_some_and(|skin| {
                let own_moved = own_transform.as_ref().is_some_and(|own| own.is_changed());
                skin.is_changed() || own_moved || skin.joints.iter().any(is_moved)
            })
            || !posed.is_whole(data.positions.len())
            || relaxed.contains(&entity);
        if !needs_pose {
            continue;
        }
        if let Some(skin) = &skin {
            let own = own_transform.as_deref().copied().unwrap_or_default();
            let joint_transform = |joint: Entity| transforms.get(joint).ok().map(|joint| *joint);
            if !collect_joint_matrices(skin, &own, joint_transform, &mut local_from_bind) {
                if !posed.is_whole(data.positions.len()) {
                    copy_rest_pose(data, &mut posed);
                }
                continue;
            }
        }
        copy_rest_pose(data, &mut posed);
        if let Some(weights) = &weights {
            morph(data, &weights.0, &mut posed);
        }
        if skin.is_some() {
            apply_skin(data, &local_from_bind, &mut posed);
        }
    }
}

/// Collects for each joint the matrix from bind space to the entity's local space. Returns `false` if one of
/// them does not exist.
///
/// The product is computed in `f64`, because the two world transforms nearly cancel and far from the origin
/// an `f32` would lose the remainder.
fn collect_joint_matrices(
    skin: &Skin,
    world_from_local: &GlobalTransform,
    joint_transform: impl Fn(Entity) -> Option<GlobalTransform>,
    local_from_bind: &mut Vec<Mat4>,
) -> bool {
    local_from_bind.clear();
    let Some(world_from_local) = placed(world_from_local, true) else {
        return false;
    };
    let world_from_local = Mat4::from(world_from_local).as_dmat4();
    let local_from_world = world_from_local.inverse();
    for (index, &joint) in skin.joints.iter().enumerate() {
        let Some(world_from_joint) = joint_transform(joint) else {
            return false;
        };
        let world_from_joint = Mat4::from(world_from_joint.affine()).as_dmat4();
        let joint_from_bind = skin
            .inverse_bind
            .get(index)
            .copied()
            .unwrap_or(Mat4::IDENTITY)
            .as_dmat4();
        let matrix = (local_from_world * world_from_joint * joint_from_bind).as_mat4();
        if !matrix.is_finite() {
            return false;
        }
        local_from_bind.push(matrix);
    }
    true
}

fn copy_rest_pose(data: &MeshData, posed: &mut PosedMesh) {
    posed.positions.clone_from(&data.positions);
    posed.normals.clone_from(&data.normals);
    posed.tangents.clone_from(&data.tangents);
}

/// Adds the weighted morph targets to the rest pose.
fn morph(data: &MeshData, weights: &[f32], posed: &mut PosedMesh) {
    let mut turns = false;
    for (target, &weight) in data.morph_targets.iter().zip(weights) {
        if weight == 0.0 || !weight.is_finite() {
            continue;
        }
        for (position, &delta) in posed.positions.iter_mut().zip(&target.positions) {
            *position += delta * weight;
        }
        for (normal, &delta) in posed.normals.iter_mut().zip(&target.normals) {
            *normal += delta * weight;
        }
        for (tangent, &delta) in posed.tangents.iter_mut().zip(&target.tangents) {
            *tangent += (delta * weight).extend(0.0);
        }
        turns |= !target.normals.is_empty() || !target.tangents.is_empty();
    }
    for (position, &rest) in posed.positions.iter_mut().zip(&data.positions) {
        if !position.is_finite() {
            *position = rest;
        }
    }
    if !turns {
        return;
    }
    for (normal, &rest) in posed.normals.iter_mut().zip(&data.normals) {
        *normal = normal.try_normalize().unwrap_or(rest);
    }
    for (tangent, &rest) in posed.tangents.iter_mut().zip(&data.tangents) {
        *tangent = tangent
            .truncate()
            .try_normalize()
            .map_or(rest, |unit| unit.extend(rest.w));
    }
}

/// Applies linear blend skinning to the vertices in `posed`.
fn apply_skin(data: &MeshData, local_from_bind: &[Mat4], posed: &mut PosedMesh) {
    for (vertex, (joints, weights)) in data.joints.iter().zip(&data.joint_weights).enumerate() {
        let mut blend = Mat4::ZERO;
        for (&joint, weight) in joints.iter().zip(weights.to_array()) {
            // Exporters often leave any index in joints of weight 0.
            if weight != 0.0
                && let Some(matrix) = local_from_bind.get(usize::from(joint))
            {
                blend += *matrix * weight;
            }
        }
        if let Some(position) = posed.positions.get_mut(vertex) {
            let moved = blend.transform_point3(*position);
            if moved.is_finite() {
                *position = moved;
            }
        }
        let linear = Mat3::from_mat4(blend);
        let (cofactors, mirror) = normal_matrix(&linear);
        if let Some(normal) = posed.normals.get_mut(vertex) {
            *normal = (cofactors * *normal * mirror).try_normalize().unwrap_or(*normal);
        }
        if let Some(tangent) = posed.tangents.get_mut(vertex)
            && let Some(unit) = (linear * tangent.truncate()).try_normalize()
        {
            *tangent = unit.extend(tangent.w * mirror);
        }
    }
}

/// The matrix that turns normals, up to a positive factor, and −1 where `linear` mirrors (else 1). It
/// consists of cofactors instead of the inverse transpose, because cofactors also exist for a flattened
/// joint.
fn normal_matrix(linear: &Mat3) -> (Mat3, f32) {
    let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
    let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let mirror = if x.dot(cofactors.x_axis) < 0.0 { -1.0 } else { 1.0 };
    (cofactors, mirror)
}
