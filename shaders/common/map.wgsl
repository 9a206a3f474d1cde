// One light's map: bind group 2 of the passes that convert it and look it up.
// Host    src/techniques/maps/gpu/constants.rs, src/render/pools/gpu_types.rs
// Spaces  relative: world axes, origin at the eye
//         face: origin at the light, x right, y up, z away from the light
//         NDC of a face: y up; texel: row 0 at the top
// Twin    techniques::maps::packing, for the packings
#define_import_path antumbra::map

struct MapFace {                    // mirror: render::pools::gpu_types::MapFace
    row_x: vec4f,                   // rows of the transform from relative to face
    row_y: vec4f,
    row_z: vec4f,
    projection: vec4f,              // half side at distance 1, near, texel at distance 1; parallel: half side, length, texel
    clip_from_relative: mat4x4f,    // of a face with a matrix; 0 for other faces
    relative_from_clip: mat4x4f,    // its inverse
}

struct MapLight {                   // mirror: render::pools::gpu_types::MapLight
    faces: array<MapFace, 6>,
    size: vec4f,                    // texels along a side, 1 / texels, filter radius (at distance 1; parallel: metres), number of faces
    bias: vec4f,                    // share of a texel along the normal, relative and absolute slack, metres to the light
    limits: vec4f,                  // nearest and farthest depth, 1 / reach² (Beside::drop), share of a cascade that passes into the next
    ending: vec4f,                  // share of the shadow that is left at a relative position: w − dot(xyz, position), clamped
}

@group(2) @binding(0) var<uniform> map_light: MapLight;

// Values of FORMAT: techniques::maps::MapFormat in its order.
const FORMAT_DEPTH: u32 = 0u;       // mirror: techniques::maps::MapFormat::Depth
const FORMAT_FLOAT: u32 = 1u;       // mirror: techniques::maps::MapFormat::R32Float
const FORMAT_TWO_BYTES: u32 = 2u;   // mirror: techniques::maps::MapFormat::Rgba8TwoBytes
const FORMAT_FOUR_BYTES: u32 = 3u;  // mirror: techniques::maps::MapFormat::Rgba8FourBytes

// A share of the squared reach that is beyond all casters.
const NOTHING: f32 = 1e30;

// Source: Gerasimov 2004, GPU Gems ch. 12, §12.3.3.
fn pack_four_bytes(share: f32) -> vec4f {
    let scaled = clamp(share, 0.0, 1.0) * 255.0;
    let r = floor(scaled);
    let after_r = (scaled - r) * 256.0;
    let g = floor(after_r);
    let after_g = (after_r - g) * 256.0;
    let b = floor(after_g);
    let a = floor((after_g - b) * 256.0);
    return vec4f(r, g, b, a) / 255.0;
}

fn pack_two_bytes(share: f32) -> vec4f {
    return vec4f(pack_four_bytes(share).rg, 0.0, 1.0);
}

// Source: Gerasimov 2004, GPU Gems ch. 12, §12.3.6.
fn unpack_four_bytes(texel: vec4f) -> f32 {
    return dot(texel, vec4f(1.0, 1.0 / 256.0, 1.0 / 65536.0, 1.0 / 16777216.0));
}

fn unpack_two_bytes(texel: vec4f) -> f32 {
    return texel.r + texel.g / 256.0;
}
