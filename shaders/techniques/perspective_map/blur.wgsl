// One pass of a Gaussian over the colours of a map's face, along one direction in the plane of each ground.
// Host    src/techniques/perspective_map/gpu/passes.rs
// Groups  1 grounds, 2 map, 3 picture
// Spaces  as in common/map.wgsl
//
// The taps are points of the plane at equal distances, projected into the map. The Gaussian is thus round and equally
// wide in metres everywhere, however the map is warped, and two passes at right angles make all of it.
// Source: Kozlov 2004, GPU Gems ch. 14, §14.3.2, for the two passes; he blurs in texels.
#import antumbra::map::map_light
#import antumbra::map_matrix::{NO_FACE, clip_in_face, plane_in_face, showing}

struct Grounds {                    // mirror: techniques::perspective_map::gpu::gpu_types::Grounds
    planes: array<vec4f, 4>,        // unit normal and offset of each ground, relative
    along: array<vec4f, 4>,         // a unit vector in the plane; standard deviation of the Gaussian, metres, 0: no ground
    across: array<vec4f, 4>,        // the one at right angles to it; half the size of the ground along it, metres
    middle: array<vec4f, 4>,        // of the ground, relative; half its size along `along`
}

@group(1) @binding(0) var<uniform> grounds: Grounds;
@group(3) @binding(0) var picture: texture_2d_array<f32>;
@group(3) @binding(1) var bilinear: sampler;

// Direction of the pass: 0 along the vector of the ground, 1 at right angles to it.
override AXIS: u32 = 0u;

// Standard deviations to each side of the middle at which the weights end.
const REACH: f32 = 2.5;             // mirror: techniques::perspective_map::grounds::BLUR_REACH

// Most taps to one side. More would smooth edges that run along the other axis, whose steps are 1/41 of the change.
const MOST_TAPS: f32 = 20.0;

struct Corner {
    @builtin(position) position_clip: vec4f,
    @location(0) @interpolate(flat) face: u32,
}

fn uv_of(ndc: vec2f) -> vec2f {
    return ndc * vec2f(0.5, -0.5) + 0.5;
}

fn ndc_in(face: u32, position: vec3f) -> vec2f {
    let clip = clip_in_face(face, position);
    return clip.xy / max(clip.w, 1e-30);
}

fn channel_at(uv: vec2f, face: u32, channel: u32) -> f32 {
    return textureSampleLevel(picture, bilinear, uv, face, 0.0)[channel];
}

// Whether a point of the plane is of the ground. What lies behind a wall that stands on it is not: it would darken the
// ground before the wall.
fn is_of_ground(channel: u32, position: vec3f) -> bool {
    let offset = position - grounds.middle[channel].xyz;
    let along = abs(dot(offset, grounds.along[channel].xyz));
    let across = abs(dot(offset, grounds.across[channel].xyz));
    return along <= grounds.middle[channel].w && across <= grounds.across[channel].w;
}

// The blurred value of one channel at a place of a face.
fn blurred(channel: u32, face: u32, ndc: vec2f) -> f32 {
    let here = channel_at(uv_of(ndc), face, channel);
    let deviation = grounds.along[channel].w;
    let plane = grounds.planes[channel];
    let in_clip = plane_in_face(face, plane.xyz, plane.w);
    // Where the ray of light that falls on this place meets the plane.
    let depth = -dot(in_clip.xyw, vec3f(ndc, 1.0)) / select(in_clip.z, 1e-30, in_clip.z == 0.0);
    let met = map_light.faces[face].relative_from_clip * vec4f(ndc, depth, 1.0);
    if deviation <= 0.0 || met.w <= 0.0 {
        return here;                // the ray does not meet the plane
    }
    let middle = met.xyz / met.w;
    var along = grounds.along[channel].xyz;
    if AXIS == 1u {
        along = grounds.across[channel].xyz;
    }
    let reach = along * (REACH * deviation);
    // What rounding moves the middle by, it moves its neighbours by as well.
    let rounding = ndc - ndc_in(face, middle);
    let ends = max(
        length(ndc_in(face, middle + reach) + rounding - ndc),
        length(ndc_in(face, middle - reach) + rounding - ndc),
    );
    let count = clamp(ceil(ends * 0.5 * map_light.size.x), 1.0, MOST_TAPS);
    var sum = 0.0;
    var weights = 0.0;
    for (var tap = -count; tap <= count; tap += 1.0) {
        let share = tap / count;
        let position = middle + reach * share;
        let shown = showing(position);
        if shown == NO_FACE || !is_of_ground(channel, position) {
            continue;
        }
        let at = ndc_in(shown, position) + select(vec2f(0.0), rounding, shown == face);
        let weight = exp(-0.5 * REACH * REACH * share * share);
        sum += weight * channel_at(uv_of(at), shown, channel);
        weights += weight;
    }
    return select(here, sum / max(weights, 1e-6), weights > 0.0);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4f {
    let ndc = in.position_clip.xy * map_light.size.y * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    var out = vec4f(1.0);
    for (var channel = 0u; channel < 4u; channel++) {
        if grounds.along[channel].w > 0.0 {
            out[channel] = blurred(channel, in.face, ndc);
        }
    }
    return out;
}
