// Cookies and luminaire profiles: the textures that scale what a light gives.
// Host    src/render/light_model/textures, src/render/pools/gpu_types.rs
// Twins   scene::light_model::{cookie::placing, profile::table}, held equal by tests/gpu/light_textures
// Spaces  relative: world axes, origin at the eye
//         light: x to the right, y upwards, z the depth before the light
#define_import_path antumbra::light_texture

#import antumbra::angles::{angle, TAU}

struct LightTexture {               // mirror: render::pools::gpu_types::LightTexture
    light_from_relative_x: vec4f,   // rows of the affine matrix
    light_from_relative_y: vec4f,
    light_from_relative_z: vec4f,
    uv_matrix: vec4f,               // columns; from coordinates on the picture's surface
    uv_origin: vec2f,
    density: f32,
    unused: f32,
    light_from_cube_x: vec4f,       // columns of the turn of a cube's picture; w unused
    light_from_cube_y: vec4f,
    light_from_cube_z: vec4f,
    profile_axes_pole: vec4f,       // axes of the profile's angles in light space; w: first polar angle
    profile_axes_zero: vec4f,       // w: first azimuth
    profile_axes_quarter: vec4f,
    profile_steps: vec2f,           // in a radian: of the polar angle, of the azimuth
    profile_last: vec2f,            // last index: of polar angles, of azimuths
}

// Where the picture of a cookie lies. The values are those of `Projection` in Rust.
const PLANE: u32 = 1u;              // on the plane one metre before the light
const AROUND: u32 = 2u;             // around the light, by longitude and latitude
const PARALLEL: u32 = 3u;           // on a plane across parallel light
const CUBE: u32 = 4u;               // on a cube around the light

// Texture coordinates beyond these repeat inexactly, and infinity would be no colour.
const FARTHEST_UV: f32 = 1e6;

fn light_point(position_relative: vec3f, light: LightTexture) -> vec3f {
    let p = vec4f(position_relative, 1.0);
    return vec3f(
        dot(light.light_from_relative_x, p),
        dot(light.light_from_relative_y, p),
        dot(light.light_from_relative_z, p),
    );
}

// Coordinates on the surface on which the picture lies, metres or radians.
fn picture_coordinates(point: vec3f, projection: u32) -> vec2f {
    if projection == PLANE {
        // Behind the plane there is no light; the bound keeps the numbers finite.
        return point.xy / max(max(point.z, 1e-6 * length(point)), 1e-20);
    }
    if projection == AROUND {
        return vec2f(angle(point.z, point.x), angle(length(point.xz), point.y));
    }
    return point.xy;
}

struct PicturePlace {
    uv: vec2f,
    uv_dx: vec2f,                   // change from one pixel to the next
    uv_dy: vec2f,
}

// The place of the picture that the light shines through. `step_x` and `step_y` lead to the surface at the
// neighbouring pixels.
fn picture_place(
    position_relative: vec3f,
    step_x: vec3f,
    step_y: vec3f,
    light: LightTexture,
    projection: u32,
) -> PicturePlace {
    let at = picture_coordinates(light_point(position_relative, light), projection);
    var dx = picture_coordinates(light_point(position_relative + step_x, light), projection) - at;
    var dy = picture_coordinates(light_point(position_relative + step_y, light), projection) - at;
    if projection == AROUND {
        // The short way around: longitude jumps by a whole turn behind the light.
        dx.x -= TAU * round(dx.x / TAU);
        dy.x -= TAU * round(dy.x / TAU);
    }
    let matrix = mat2x2f(light.uv_matrix.xy, light.uv_matrix.zw);
    let far = vec2f(FARTHEST_UV);
    return PicturePlace(
        clamp(matrix * at + light.uv_origin, -far, far),
        clamp(matrix * dx, -far, far),
        clamp(matrix * dy, -far, far),
    );
}

struct CubePlace {
    direction: vec3f,               // unit, in the directions of the picture
    direction_dx: vec3f,            // change from one pixel to the next
    direction_dy: vec3f,
}

fn cube_direction(position_relative: vec3f, light: LightTexture) -> vec3f {
    let point = light_point(position_relative, light);
    let direction = vec3f(
        dot(light.light_from_cube_x.xyz, point),
        dot(light.light_from_cube_y.xyz, point),
        dot(light.light_from_cube_z.xyz, point),
    );
    return direction / max(length(direction), 1e-20);
}

// The direction in which the light shines through a cube's picture. `step_x` and `step_y` lead to the surface at the
// neighbouring pixels.
fn cube_place(position_relative: vec3f, step_x: vec3f, step_y: vec3f, light: LightTexture) -> CubePlace {
    let direction = cube_direction(position_relative, light);
    return CubePlace(
        direction,
        cube_direction(position_relative + step_x, light) - direction,
        cube_direction(position_relative + step_y, light) - direction,
    );
}

// Place in a profile's table, in steps: along the polar angle, along the azimuth.
struct ProfilePlace {
    texel: vec2f,
    is_inside: bool,                // else the light is dark in this direction
}

fn profile_place(position_relative: vec3f, light: LightTexture) -> ProfilePlace {
    // Angles this near to the end of the table, in radians, belong to it.
    let slack = 1e-5;
    let point = light_point(position_relative, light);
    let pole = dot(light.profile_axes_pole.xyz, point);
    let zero = dot(light.profile_axes_zero.xyz, point);
    let quarter = dot(light.profile_axes_quarter.xyz, point);
    let polar = angle(pole, length(vec2f(zero, quarter))) - light.profile_axes_pole.w;
    var azimuth = angle(zero, quarter) - light.profile_axes_zero.w;
    azimuth -= TAU * floor(azimuth / TAU);
    let texel = vec2f(polar, azimuth) * light.profile_steps;
    let beyond = slack * light.profile_steps;
    let is_inside = all(texel >= -beyond) && all(texel <= light.profile_last + beyond);
    return ProfilePlace(clamp(texel, vec2f(0.0), light.profile_last), is_inside);
}
