//! The constants of a light's textures in shaders.

use glam::{DVec2, DVec3, Vec3};

use crate::render::pools::gpu_types;
use crate::scene::light_model::cookie::cube::light_from_cube;
use crate::scene::light_model::cookie::placing::{CookiePlacing, Projection};
use crate::scene::light_model::profile::table::UniformTable;
use crate::scene::{Cookie, TextureWrap};
use crate::sets::FrameLight;

/// Makes the shader's constants of a light's cookie and profile.
pub fn texture_constants(
    light: &FrameLight,
    profile: Option<&UniformTable>,
    eye_world: DVec3,
) -> gpu_types::LightTexture {
    let axes = light.shining.axes;
    let place = light.world_from_light.translation().as_dvec3();
    let offset = axes.map(|axis| axis.dot(eye_world - place));
    let mut constants = gpu_types::LightTexture::default();
    let mut rows = [0, 1, 2].map(|at| axes[at].as_vec3().extend(offset[at] as f32).to_array());
    if let Some(cookie) = &light.textures.cookie {
        let placing = CookiePlacing::of(cookie);
        let mut origin = placing.origin;
        match Projection::of(light.light.kind, &cookie.image) {
            Projection::Parallel => {
                // Far from the light's place an f32 would not hold the offset: its whole tiles are left out.
                origin = whole_tiles_left_out(placing.uv(DVec2::new(offset[0], offset[1])), cookie);
                rows.iter_mut().for_each(|row| row[3] = 0.0);
            }
            Projection::Cube => {
                let [x, y, z] = light_from_cube(cookie).as_mat3().to_cols_array_2d();
                let column = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
                constants.light_from_cube_x = column(x);
                constants.light_from_cube_y = column(y);
                constants.light_from_cube_z = column(z);
            }
            Projection::Plane | Projection::Around => {}
        }
        constants.uv_matrix = placing.matrix.as_mat2().to_cols_array();
        constants.uv_origin = origin.as_vec2().to_array();
        constants.density = cookie.density;
    }
    [
        constants.light_from_relative_x,
        constants.light_from_relative_y,
        constants.light_from_relative_z,
    ] = rows;
    if let Some(table) = profile {
        // The light's local space has z behind it, light space before it.
        let [pole, zero, quarter] = table.axes.map(|axis| axis * Vec3::new(1.0, 1.0, -1.0));
        constants.profile_axes_pole = pole.extend(table.first[0]).to_array();
        constants.profile_axes_zero = zero.extend(table.first[1]).to_array();
        constants.profile_axes_quarter = quarter.extend(0.0).to_array();
        constants.profile_steps = table.steps;
        constants.profile_last = [table.width, table.height].map(|count| (count - 1) as f32);
    }
    constants
}

/// Moves texture coordinates by whole tiles to near the origin, along the axes on which the picture repeats.
fn whole_tiles_left_out(uv: DVec2, cookie: &Cookie) -> DVec2 {
    let reduced = |at: f64, wrap| match wrap {
        TextureWrap::Repeat => at.rem_euclid(1.0),
        TextureWrap::Mirror => at.rem_euclid(2.0),
        TextureWrap::Clamp => at,
    };
    DVec2::new(reduced(uv.x, cookie.wrap[0]), reduced(uv.y, cookie.wrap[1]))
}
