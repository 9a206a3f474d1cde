//! Transforms of nodes: from the file's matrices and factors to the transform of an entity.

use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DMat3, DVec3, Mat3, Mat4, Quat, Vec3};
use gltf::json::scene::Node;

/// The transform of a node relative to its parent.
pub(super) struct NodeTransform {
    /// The inner part, or the whole transform if there is no `stretch`.
    pub transform: Transform,
    /// The part between the parent and `transform`, if the node's matrix shears.
    pub stretch: Option<Transform>,
    /// A description of the transform's fault, if it has one.
    pub problem: Option<&'static str>,
}

/// The transform of a node, and a description of its fault if it has one.
pub(super) fn transform_of(node: &Node) -> NodeTransform {
    let mut stretch = None;
    let mut problem = None;
    let transform = match &node.matrix {
        Some(matrix) => {
            let (outer, inner) = decompose(&Mat4::from_cols_array(matrix));
            stretch = outer;
            inner
        }
        None => {
            let rotation = node
                .rotation
                .map_or(Quat::IDENTITY, |rotation| Quat::from_array(rotation.0));
            let unit = unit_rotation(rotation);
            if unit.is_none() {
                problem = Some("its rotation has no direction, none is used");
            }
            Transform {
                translation: node.translation.map_or(Vec3::ZERO, Vec3::from),
                rotation: unit.unwrap_or(Quat::IDENTITY),
                scale: node.scale.map_or(Vec3::ONE, Vec3::from),
            }
        }
    };
    let placed_from_local = GlobalTransform::from(stretch.unwrap_or_default()) * transform;
    if !placed_from_local.affine().is_finite()
        || !placed_from_local.affine().matrix3.determinant().is_finite()
    {
        problem = Some("its transform is not finite");
    }
    NodeTransform {
        transform,
        stretch,
        problem,
    }
}

/// `rotation` normalised to unit length. Input that is already normalised is kept bit for bit.
pub(super) fn unit_rotation(rotation: Quat) -> Option<Quat> {
    if rotation.is_normalized() {
        return Some(rotation);
    }
    let unit = rotation.normalize();
    unit.is_finite().then_some(unit)
}

/// Largest error of a matrix that is kept as one translation, rotation and scale, as a share of its longest axis.
/// It is several times the rounding of exporters that multiply matrices in `f32`, and less than a pixel of an object
/// that fills the picture.
const NO_SHEAR: f32 = 1e-5;

/// Translation, rotation and scale of a matrix. A matrix that shears gives two such transforms, of which the first
/// is the parent of the second. A flattened axis gets scale 0 and any direction that completes the rotation.
fn decompose(matrix: &Mat4) -> (Option<Transform>, Transform) {
    let linear = Mat3::from_mat4(*matrix);
    let translation = matrix.w_axis.truncate();
    if !linear.is_finite() {
        let broken = Transform {
            translation,
            rotation: Quat::IDENTITY,
            scale: Vec3::NAN,
        };
        return (None, broken);
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
    let is_kept = (again - linear)
        .to_cols_array()
        .iter()
        .all(|error| error.abs() <= largest * NO_SHEAR);
    if is_kept {
        return (None, transform);
    }
    let (outward, stretch, inward) = singular_values(&linear.as_dmat3());
    let outer = Transform {
        translation,
        rotation: outward,
        scale: stretch,
    };
    (Some(outer), Transform::from_rotation(inward))
}

/// Rotation, scale and rotation whose product is the matrix; of a mirroring one, one scale is negative.
///
/// `MᵀM = V Σ² Vᵀ` by Jacobi's rotations, then `M V = U Σ`. A direction that is lost gets whatever completes `U`.
/// Source: Golub & Van Loan 2013, "Matrix Computations", section 8.6 (one-sided Jacobi).
fn singular_values(m: &DMat3) -> (Quat, Vec3, Quat) {
    let mut columns = [m.x_axis, m.y_axis, m.z_axis];
    let mut v = [DVec3::X, DVec3::Y, DVec3::Z];
    // It converges quadratically: six sweeps are more than 3 × 3 numbers in f64 ever need.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b, c) = (
                columns[p].length_squared(),
                columns[q].length_squared(),
                columns[p].dot(columns[q]),
            );
            if c == 0.0 || c.abs() <= 1e-16 * (a * b).sqrt() {
                continue;
            }
            let zeta = (b - a) / (2.0 * c);
            let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let cos = 1.0 / (1.0 + t * t).sqrt();
            let sin = cos * t;
            for pair in [&mut columns, &mut v] {
                let (x, y) = (pair[p], pair[q]);
                pair[p] = x * cos - y * sin;
                pair[q] = x * sin + y * cos;
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| {
        columns[b]
            .length_squared()
            .total_cmp(&columns[a].length_squared())
    });
    let [first, second, third] = order.map(|i| columns[i]);
    let [v0, v1, _] = order.map(|i| v[i]);
    let v2 = v0.cross(v1); // the third up to its sign
    let sign = v2.dot(v[order[2]]).signum();
    let u0 = first.normalize_or(DVec3::X);
    let u1 = (second - u0 * u0.dot(second)).try_normalize();
    let u1 = u1.unwrap_or_else(|| u0.any_orthonormal_vector());
    let u2 = u0.cross(u1);
    let scale = DVec3::new(first.length(), second.length(), u2.dot(third) * sign);
    let rotation = |m: DMat3| Quat::from_mat3(&m.as_mat3()).normalize();
    let outward = rotation(DMat3::from_cols(u0, u1, u2));
    let inward = rotation(DMat3::from_cols(v0, v1, v2).transpose());
    (outward, scale.as_vec3(), inward)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_matrix_comes_back() {
        let columns = [
            [1.0, 0.0, 0.0, 1.2, 1.0, 0.5, 0.0, 0.0, 1.0],
            [0.5, 0.0, 0.4, 0.0, 1.0, 0.0, 0.4, 0.0, 0.5],
            [-1.0, 0.3, 0.0, 0.0, 2.0, 0.1, 0.7, 0.0, 1.0],
            [1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            [1.0, 2e-5, 0.0, 2e-5, 1.0, 0.0, 0.0, 0.0, 1.0],
            [1e3, 1e2, 0.0, 0.0, 1e-2, 0.0, 0.0, 0.0, 1.0],
        ];
        for columns in columns {
            let linear = Mat3::from_cols_array(&columns);
            let matrix = Mat4::from_mat3(linear);
            let (outer, inner) = decompose(&matrix);
            let again = Mat4::from(outer.unwrap().compute_affine()) * Mat4::from(inner.compute_affine());
            let largest = columns.iter().fold(0.0f32, |largest, x| largest.max(x.abs()));
            let error = (again - matrix)
                .to_cols_array()
                .into_iter()
                .fold(0.0f32, |e, x| e.max(x.abs()));
            assert!(error <= 2e-6 * largest, "{columns:?}: {error}");
        }
    }
}
