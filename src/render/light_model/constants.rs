//! The constants of each light's model in shaders.

use glam::{DMat3, DVec3, Vec2};

use crate::render::pools::gpu_types;
use crate::scene::{LightDistance, LightShape};
use crate::sets::FrameLight;

/// Makes the shader's constants of a light's shape and distances. A light without them gets a factor of 1.
pub fn shape_constants(light: &FrameLight, eye_world: DVec3) -> gpu_types::LightShape {
    let [x, y, z] = light_axes(light).map(|axis| {
        let offset = axis.dot(eye_world - light.point_world.truncate());
        axis.as_vec3().extend(offset as f32).to_array()
    });
    let shape = light.model.shape.unwrap_or_default();
    let distance = light.model.distance.unwrap_or_default();
    gpu_types::LightShape {
        light_from_relative_x: x,
        light_from_relative_y: y,
        light_from_relative_z: z,
        semi_axes: semi_axes(&shape),
        distance: edges(light, &distance),
        form: [
            shape.exponent(),
            shape.exponent().recip(),
            f32::from(light.model.shape.is_some()),
            f32::from(shape.inner().min_element() > 0.0),
        ],
    }
}

fn semi_axes(shape: &LightShape) -> [f32; 4] {
    let [inner, outer]: [Vec2; 2] = [shape.inner(), shape.outer()];
    [inner.x, inner.y, outer.x, outer.y]
}

/// Distances of directional lights bound nothing, and their depth has no meaning.
fn edges(light: &FrameLight, distance: &LightDistance) -> [f32; 4] {
    let bounded = light.point_world.w != 0.0;
    if bounded {
        *distance
    } else {
        LightDistance::default()
    }
    .edges()
}

/// The axes of light space in world space: local X and Y, and the direction in which the light shines. They are
/// orthonormal, whatever the scale of the light's transform.
pub fn light_axes(light: &FrameLight) -> [DVec3; 3] {
    let affine = light.world_from_light.affine();
    let along = light.direction.as_dvec3().normalize();
    let across = |axis: glam::Vec3A| {
        let axis = glam::Vec3::from(axis).as_dvec3();
        (axis - along * axis.dot(along)).try_normalize()
    };
    let up = across(affine.matrix3.y_axis);
    let right = across(affine.matrix3.x_axis)
        .or_else(|| up.map(|up| along.cross(up)))
        .unwrap_or_else(|| along.any_orthonormal_vector());
    let axes = DMat3::from_cols(right, right.cross(along), along);
    // A mirrored transform mirrors the doors; the sign of an axis does not change a superellipse.
    [axes.x_axis, up.unwrap_or(axes.y_axis), axes.z_axis]
}
