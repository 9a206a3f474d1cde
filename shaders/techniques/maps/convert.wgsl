// One face in the format that is looked up, made from the depths of its first and second surface.
// Host    src/techniques/maps/gpu/pipelines.rs
// Groups  1 surfaces, 2 map
#import antumbra::map::{map_light, pack_two_bytes, pack_four_bytes, NOTHING}
#import antumbra::map::{FORMAT_FLOAT, FORMAT_TWO_BYTES, FORMAT_FOUR_BYTES}

@group(1) @binding(0) var first_depth: texture_depth_2d;
@group(1) @binding(1) var second_depth: texture_depth_2d;

override FORMAT: u32 = 1u;
override SURFACE: u32 = 0u;
override PARALLEL: bool = false;

const NEAREST: u32 = 0u;            // mirror: techniques::maps::MapSurface::Nearest
const MIDPOINT: u32 = 2u;           // mirror: techniques::maps::MapSurface::Midpoint

struct Corner {
    @builtin(position) position_clip: vec4f,
    @location(0) @interpolate(flat) face: u32,
}

// Depth of the chosen surface; 0: none. Where there is no second one, the first stands for it.
fn chosen(in: Corner) -> f32 {
    let texel = vec2u(in.position_clip.xy);
    let first = textureLoad(first_depth, texel, 0);
    var second = textureLoad(second_depth, texel, 0);
    second = select(second, first, second == 0.0);
    // Halfway in distance: perspective depth is the reciprocal of distance, parallel depth is linear in it.
    let halfway = select(2.0 / (1.0 / max(first, 1e-30) + 1.0 / max(second, 1e-30)), 0.5 * (first + second), PARALLEL);
    let beyond = select(second, halfway, SURFACE == MIDPOINT);
    return select(select(beyond, first, SURFACE == NEAREST), 0.0, first == 0.0);
}

@fragment
fn depth(in: Corner) -> @builtin(frag_depth) f32 {
    return chosen(in);
}

// Squared distance from the light as a share of the squared reach.
@fragment
fn squared_distance(in: Corner) -> @location(0) vec4f {
    let z = chosen(in);
    let projection = map_light.faces[in.face].projection;
    let ndc = vec2f(2.0, -2.0) * (in.position_clip.xy * map_light.size.y) + vec2f(-1.0, 1.0);
    let along = projection.y / max(z, 1e-30);
    let direction = vec3f(ndc * projection.x, 1.0);
    let share = along * along * dot(direction, direction) * map_light.limits.z;
    let stored = select(min(share, NOTHING), NOTHING, z == 0.0);
    if FORMAT == FORMAT_TWO_BYTES {
        return pack_two_bytes(stored);
    }
    if FORMAT == FORMAT_FOUR_BYTES {
        return pack_four_bytes(stored);
    }
    return vec4f(stored, 0.0, 0.0, 1.0);
}
