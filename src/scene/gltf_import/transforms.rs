//! Transforms of nodes: from the file's matrices and factors to the transform of an entity.

use bevy_transform::prelude::Transform;
use glam::{Mat3, Mat4, Quat, Vec3};
use gltf::json::scene::Node;

/// The transform of a node, and a description of its fault if it has one.
pub(super) fn transform_of(node: &Node) -> (Transform, Option<&'static str>) {
    let (transform, mut problem) = match &node.matrix {
        Some(matrix) => decompose(&Mat4::from_cols_array(matrix)),
        None => {
            let rotation = node
                .rotation
                .map_or(Quat::IDENTITY, |rotation| Quat::from_array(rotation.0));
            let (rotation, problem) = match unit_rotation(rotation) {
                Some(rotation) => (rotation, None),
                None => (
                    Quat::IDENTITY,
                    Some("its rotation has no direction, none is used"),
                ),
            };
            let transform = Transform {
                translation: node.translation.map_or(Vec3::ZERO, Vec3::from),
                rotation,
                scale: node.scale.map_or(Vec3::ONE, Vec3::from),
            };
            (transform, problem)
        }
    };
    let affine = transform.compute_affine();
    let determinant = affine.matrix3.determinant();
    if !affine.is_finite() || !determinant.is_finite() {
        problem = Some("its transform is not finite");
    } else if determinant == 0.0 {
        problem = Some("its transform is singular");
    }
    (transform, problem)
}

/// `rotation` normalised to unit length. Input that is already normalised is kept bit for bit.
fn unit_rotation(rotation: Quat) -> Option<Quat> {
    if rotation.is_normalized() {
        return Some(rotation);
    }
    let unit = rotation.normalize();
    unit.is_finite().then_some(unit)
}

/// Translation, rotation and scale of a matrix. A flattened axis gets scale 0 and any direction that
/// completes the rotation. Shear, which no node may have, is lost, and the description says so.
fn decompose(matrix: &Mat4) -> (Transform, Option<&'static str>) {
    let linear = Mat3::from_mat4(*matrix);
    let translation = matrix.w_axis.truncate();
    if !linear.is_finite() {
        let scale = Vec3::NAN;
        return (
            Transform {
                translation,
                rotation: Quat::IDENTITY,
                scale,
            },
            None,
        );
    }
    let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
    let mut scale = Vec3::from(columns.map(Vec3::length));
    let axes = columns.map(Vec3::try_normalize);
    let axes = match axes {
        [Some(x), Some(y), Some(z)] => {
            // If the matrix mirrors, one axis is reversed, as in every node that mirrors.
            let mirror = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
            scale.x *= mirror;
            [x * mirror, y, z]
        }
        [None, Some(y), Some(z)] => [y.cross(z), y, z],
        [Some(x), None, Some(z)] => [x, z.cross(x), z],
        [Some(x), Some(y), None] => [x, y, x.cross(y)],
        [Some(x), None, None] => [x, x.any_orthonormal_pair().0, x.any_orthonormal_pair().1],
        [None, Some(y), None] => [y.any_orthonormal_pair().1, y, y.any_orthonormal_pair().0],
        [None, None, Some(z)] => [z.any_orthonormal_pair().0, z.any_orthonormal_pair().1, z],
        [None, None, None] => [Vec3::X, Vec3::Y, Vec3::Z],
    };
    let rotation = Quat::from_mat3(&Mat3::from_cols(axes[0], axes[1], axes[2]));
    let rotation = unit_rotation(rotation).unwrap_or(Quat::IDENTITY);
    let transform = Transform {
        translation,
        rotation,
        scale,
    };
    let largest = scale.abs().max_element();
    let again = Mat3::from(transform.compute_affine().matrix3);
    // The tolerance is 1e-3 of the largest axis: far above rounding, below what an eye sees.
    let is_kept = (again - linear)
        .to_cols_array()
        .iter()
        .all(|error| error.abs() <= largest * 1e-3);
    (
        transform,
        (!is_kept).then_some("its matrix has shear, which is lost"),
    )
}
