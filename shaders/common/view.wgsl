// View and objects: bind group 0 of every scene pass.
// Host    src/render/gpu/bind_groups.rs, src/render/pools/gpu_types.rs
// Spaces  local
//         relative: world axes, origin at the eye, so that positions stay exact far from the world's origin
//         clip: reversed depth
#define_import_path antumbra::view

struct View {                       // mirror: render::pools::gpu_types::View
    ambient: vec4f,                 // linear RGB radiance; w unused
    relative_from_ndc: mat4x4f,     // from a pixel's NDC position and depth; divide by w
    size: vec4f,                    // width and height of the picture, pixels; their reciprocals
    origin: vec4f,                  // upper left corner of the picture in its targets, pixels; zw unused
    eye: vec4f,                     // w = 1: at the origin; w = 0: xyz points towards an orthographic view
}

struct Object {                     // mirror: render::pools::gpu_types::Object
    clip_from_local: mat4x4f,
    relative_from_local_x: vec4f,   // rows of the affine matrix
    relative_from_local_y: vec4f,
    relative_from_local_z: vec4f,
    handedness: vec4f,              // x: sign of the determinant; yzw: weights of ambient, diffuse, specular light
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> objects: array<Object>;

fn ndc_from_pixel(pixel: vec2f) -> vec2f {
    return vec2f(2.0, -2.0) * ((pixel - view.origin.xy) * view.size.zw) + vec2f(-1.0, 1.0);
}

// The point that a pixel shows. `pixel` is the fragment position (centres at +0.5, row 0 at the top of the
// targets); `depth` is the depth buffer's value, greater than 0.
fn relative_from_pixel(pixel: vec2f, depth: f32) -> vec3f {
    let p = view.relative_from_ndc * vec4f(ndc_from_pixel(pixel), depth, 1.0);
    return p.xyz / p.w;
}

// Unit vector from a point to the eye.
fn to_eye(position_relative: vec3f) -> vec3f {
    return normalize(view.eye.xyz - position_relative * view.eye.w);
}

// The only path from local to clip space, because passes must agree on depth to the last bit.
fn clip_position(object: u32, position_local: vec3f) -> vec4f {
    return objects[object].clip_from_local * vec4f(position_local, 1.0);
}

fn relative_position(object: u32, position_local: vec3f) -> vec3f {
    let p = vec4f(position_local, 1.0);
    return vec3f(
        dot(objects[object].relative_from_local_x, p),
        dot(objects[object].relative_from_local_y, p),
        dot(objects[object].relative_from_local_z, p),
    );
}

fn relative_vector(object: u32, vector_local: vec3f) -> vec3f {
    return vec3f(
        dot(objects[object].relative_from_local_x.xyz, vector_local),
        dot(objects[object].relative_from_local_y.xyz, vector_local),
        dot(objects[object].relative_from_local_z.xyz, vector_local),
    );
}

// Transforms a normal by the cofactor matrix, which is right for any scale and keeps normals of mirrored
// objects outward.
fn relative_normal(object: u32, normal_local: vec3f) -> vec3f {
    let x = objects[object].relative_from_local_x.xyz;
    let y = objects[object].relative_from_local_y.xyz;
    let z = objects[object].relative_from_local_z.xyz;
    let n = vec3f(
        dot(cross(y, z), normal_local),
        dot(cross(z, x), normal_local),
        dot(cross(x, y), normal_local),
    );
    // The length of n is that of an area, whose square may exceed the range of an f32.
    let largest = max(max(abs(n.x), abs(n.y)), max(abs(n.z), 1e-37));
    return n * (objects[object].handedness.x / largest);
}
