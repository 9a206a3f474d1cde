// Visibility of each pixel, looked up in a map: into the mask.
// Host    src/techniques/maps/map_pipelines.rs
// Groups  0 view, 1 receiver, 2 map and jitter, 3 textures
// Spaces  as in common/map.wgsl
//
// A pixel is compared with the plane of its own triangle, traced along each texel's ray: on a flat surface the texel's
// depth and the plane's are of one point. The plane is raised by a share of a texel for what is not flat.
#import antumbra::receiver::{Receiver, receiver_at}
#import antumbra::map::{map_light, unpack_two_bytes, unpack_four_bytes}
#import antumbra::map::{FORMAT_DEPTH, FORMAT_FLOAT, FORMAT_TWO_BYTES}

@group(2) @binding(1) var compare: sampler_comparison;
@group(2) @binding(2) var jitter: texture_3d<f32>;
@group(3) @binding(0) var depth_map: texture_depth_2d_array;
@group(3) @binding(1) var distance_map: texture_2d_array<f32>;

// techniques::maps::MapFilter in its order; the adaptive one last.
const BILINEAR: u32 = 0u;
const BRUTE: u32 = 1u;
const DITHERED: u32 = 2u;
const JITTERED: u32 = 3u;
const SOFT: u32 = 4u;
const ADAPTIVE: u32 = 5u;

// techniques::maps::request::MapShape in its order.
const SPOT: u32 = 0u;
const CUBE: u32 = 1u;
const CASCADES: u32 = 2u;

override FILTER: u32 = 0u;
override SHAPE: u32 = 0u;
override FORMAT: u32 = 0u;
override CASCADE_COUNT: u32 = 1u;
override SHOW_TAPS: bool = false;

// Pixels along a side of the jitter's tile, and its texels of two samples each: techniques::maps::jitter.
const TILE: u32 = 16u;
const RIM_TEXELS: i32 = 4;
const JITTER_TEXELS: i32 = 32;

// Texels of depth, for each texel sideways, that a plane may lead away from the light; by eye: beyond, it is seen edge-on.
const STEEPEST: f32 = 32.0;

// What f32 loses of positions and planes, as a share of their distance from eye and light.
const ROUNDING: f32 = 2e-6;

var<private> taps: f32 = 0.0;

// A pixel before a face.
struct Site {
    face: u32,
    ndc: vec2f,
    along: f32,                     // z of the face's space
    normal: vec3f,                  // of the receiver's plane, relative
    offset: f32,                    // of the raised plane, from the light (parallel: from the face's origin)
}

fn in_face(face: u32, v: vec3f) -> vec3f {
    let f = map_light.faces[face];
    return vec3f(dot(f.row_x.xyz, v), dot(f.row_y.xyz, v), dot(f.row_z.xyz, v));
}

fn position_in_face(face: u32, p: vec3f) -> vec3f {
    let f = map_light.faces[face];
    return in_face(face, p) + vec3f(f.row_x.w, f.row_y.w, f.row_z.w);
}

// The face of a cube that a direction leads to: techniques::omni_map::cube::DIRECTIONS.
fn cube_face(v: vec3f) -> u32 {
    let a = abs(v);
    let z_face = select(4u, 5u, v.z < 0.0);
    let y_face = select(2u, 3u, v.y < 0.0);
    let x_face = select(0u, 1u, v.x < 0.0);
    let yz = select(z_face, y_face, a.y >= a.z);
    return select(yz, x_face, a.x >= a.y && a.x >= a.z);
}

fn unpacked(texel: vec4f) -> f32 {
    if FORMAT == FORMAT_FLOAT {
        return texel.r;
    }
    // The largest value stands for nothing.
    let share = select(unpack_four_bytes(texel), unpack_two_bytes(texel), FORMAT == FORMAT_TWO_BYTES);
    return select(share, 1e30, texel.r >= 1.0);
}

// 1 where the plane is nearer than what a texel of squared distances shows.
fn is_lit(site: Site, face: u32, texel: vec2i) -> f32 {
    let inside = clamp(texel, vec2i(0), vec2i(i32(map_light.size.x) - 1));
    let stored = unpacked(textureLoad(distance_map, inside, face, 0));
    let ndc = vec2f(2.0, -2.0) * ((vec2f(inside) + 0.5) * map_light.size.y) + vec2f(-1.0, 1.0);
    let projection = map_light.faces[face].projection;
    let direction = vec3f(ndc * projection.x, 1.0);
    let towards = dot(in_face(face, site.normal), direction);
    let farthest = site.along * (1.0 + STEEPEST * projection.z);
    let hit = site.offset / min(towards, -1e-30);
    let along = select(farthest, min(hit, farthest), towards < 0.0);
    let share = along * along * dot(direction, direction) * map_light.limits.z;
    return select(0.0, 1.0, share * (1.0 - map_light.bias.y) - map_light.bias.z <= stored);
}

// One tap: the four texels around a place of a face, weighted by the place between them. Hardware compares all four
// with one depth; it is the plane's at the texel where that is nearest to the light.
fn tap_face(site: Site, face: u32, ndc: vec2f) -> f32 {
    taps += 1.0;
    let size = map_light.size.x;
    let place = (ndc * vec2f(0.5, -0.5) + 0.5) * size;
    let corner = place - 0.5;
    let between = fract(corner);
    if FORMAT == FORMAT_DEPTH {
        let n = in_face(face, site.normal);
        let projection = map_light.faces[face].projection;
        var depth: f32;
        var slope: vec2f;           // of depth, a texel to the right and one down
        var deepest: f32;
        if SHAPE == CASCADES {
            let steep = min(n.z, -1e-6);
            let at = (site.offset - dot(n.xy, ndc) * projection.x) / steep;
            depth = 1.0 - at / projection.y;
            slope = vec2f(n.x, -n.y) * (projection.z / (steep * projection.y));
            deepest = 1.0 - (site.along + STEEPEST * projection.z) / projection.y;
        } else {
            let scale = projection.y / site.offset;
            depth = dot(n, vec3f(ndc * projection.x, 1.0)) * scale;
            slope = vec2f(n.x, -n.y) * (projection.z * scale);
            deepest = projection.y / (site.along * (1.0 + STEEPEST * projection.z));
        }
        let lenient = max(slope * (1.0 - between), -slope * between);
        // Where the plane leaves the far end of a parallel box nothing was drawn, and nothing is nearer.
        depth = max(max(depth + lenient.x + lenient.y, deepest), 0.0);
        depth = depth * (1.0 + map_light.bias.y) + map_light.bias.z;
        return textureSampleCompareLevel(depth_map, compare, place * map_light.size.y, face, depth);
    }
    if FILTER == JITTERED || FILTER == ADAPTIVE {
        return is_lit(site, face, vec2i(floor(place)));
    }
    let texel = vec2i(floor(corner));
    let top = mix(is_lit(site, face, texel), is_lit(site, face, texel + vec2i(1, 0)), between.x);
    let bottom = mix(is_lit(site, face, texel + vec2i(0, 1)), is_lit(site, face, texel + vec2i(1, 1)), between.x);
    return mix(top, bottom, between.y);
}

// A tap some texels off the pixel's own place; on a cube it may lie in another face.
fn tap(site: Site, texels: vec2f) -> f32 {
    let ndc = site.ndc + texels * vec2f(2.0, -2.0) * map_light.size.y;
    if SHAPE == CUBE {
        let f = map_light.faces[site.face];
        let side = f.projection.x;
        let direction = f.row_x.xyz * (ndc.x * side) + f.row_y.xyz * (ndc.y * side) + f.row_z.xyz;
        let face = cube_face(direction);
        let q = in_face(face, direction);
        return tap_face(site, face, q.xy / (q.z * side));
    }
    return tap_face(site, site.face, ndc);
}

// Source: Bunnell & Pellacini 2004, GPU Gems ch. 11, §11.3.
fn brute(site: Site) -> f32 {
    var sum = 0.0;
    for (var y = -1.5; y < 2.0; y += 1.0) {
        for (var x = -1.5; x < 2.0; x += 1.0) {
            sum += tap(site, vec2f(x, y));
        }
    }
    return sum / 16.0;
}

// Source: the same, §11.4: the pattern of figure 11-4.
fn dithered(site: Site, pixel: vec2u) -> f32 {
    let odd_x = pixel.x & 1u;
    let offset = vec2f(f32(odd_x), f32(odd_x ^ (pixel.y & 1u)));
    return 0.25 * (tap(site, offset + vec2f(-1.5, 0.5)) + tap(site, offset + vec2f(0.5, 0.5))
        + tap(site, offset + vec2f(-1.5, -1.5)) + tap(site, offset + vec2f(0.5, -1.5)));
}

// Source: Gerasimov 2004, GPU Gems ch. 12, listing 12-3; corners of a square turned so that no two share a row.
fn soft(site: Site, radius: f32) -> f32 {
    let a = vec2f(0.9239, 0.3827) * radius;
    let b = vec2f(-a.y, a.x);
    return 0.25 * (tap(site, a) + tap(site, -a) + tap(site, b) + tap(site, -b));
}

fn two_jittered(site: Site, pixel: vec2u, texel: i32, radius: f32) -> f32 {
    let offsets = textureLoad(jitter, vec3i(vec2i(pixel % TILE), texel), 0) * radius;
    return tap(site, offsets.xy) + tap(site, offsets.zw);
}

// The rim tells whether all of the disc is lit or dark; where it disagrees, the rest is looked up.
// Source: Uralsky & Ahmad 2004, "Soft Shadows" (NVIDIA SDK white paper).
fn jittered(site: Site, pixel: vec2u, radius: f32) -> f32 {
    var sum = 0.0;
    for (var texel = 0; texel < RIM_TEXELS; texel++) {
        sum += two_jittered(site, pixel, texel, radius);
    }
    let rim = f32(RIM_TEXELS) * 2.0;
    if FILTER == ADAPTIVE && (sum == 0.0 || sum == rim) {
        return sum / rim;
    }
    for (var texel = RIM_TEXELS; texel < JITTER_TEXELS; texel++) {
        sum += two_jittered(site, pixel, texel, radius);
    }
    return sum / (f32(JITTER_TEXELS) * 2.0);
}

fn filtered(site: Site, pixel: vec2u) -> f32 {
    let texel = map_light.faces[site.face].projection.z;
    let radius = map_light.size.z / texel;
    if FILTER == BRUTE {
        return brute(site);
    }
    if FILTER == DITHERED {
        return dithered(site, pixel);
    }
    if FILTER == SOFT {
        return soft(site, radius);
    }
    if FILTER == JITTERED || FILTER == ADAPTIVE {
        return jittered(site, pixel, radius);
    }
    return tap(site, vec2f(0.0));
}

// How far a plane is raised, metres.
fn raised(receiver: Receiver, texel: f32, along: f32, facing: f32) -> f32 {
    return map_light.bias.x * texel + map_light.bias.w * facing
        + ROUNDING * (length(receiver.position) + abs(along));
}

fn from_point(receiver: Receiver, pixel: vec2u) -> f32 {
    let first = map_light.faces[0];
    var face = 0u;
    var q = position_in_face(0u, receiver.position);
    if SHAPE == CUBE {
        let v = first.row_x.xyz * q.x + first.row_y.xyz * q.y + first.row_z.xyz * q.z;
        face = cube_face(v);
        q = position_in_face(face, receiver.position);
    }
    let f = map_light.faces[face];
    var normal = receiver.normal;
    let n = in_face(face, normal);
    let origin = vec3f(f.row_x.w, f.row_y.w, f.row_z.w);
    var offset = receiver.offset + dot(n, origin);
    if dot(normal, normal) == 0.0 {
        // Of what is not known it is assumed that it faces the light.
        let towards = -q / max(length(q), 1e-30);
        normal = f.row_x.xyz * towards.x + f.row_y.xyz * towards.y + f.row_z.xyz * towards.z;
        offset = dot(towards, q);
    }
    if offset >= 0.0 {
        return 0.0;                 // it faces away
    }
    if q.z <= f.projection.y {
        return 1.0;                 // before the near plane
    }
    let raise = raised(receiver, f.projection.z * q.z, length(q), -offset / max(length(q), 1e-30));
    offset += min(raise, -0.5 * offset);
    let ndc = q.xy / (q.z * f.projection.x);
    if SHAPE == SPOT && max(abs(ndc.x), abs(ndc.y)) > 1.0 {
        return 1.0;                 // out of the cone
    }
    return filtered(Site(face, ndc, q.z, normal, offset), pixel);
}

// Visibility in one cascade.
fn from_cascade(face: u32, receiver: Receiver, pixel: vec2u) -> f32 {
    let f = map_light.faces[face];
    let q = position_in_face(face, receiver.position);
    var normal = receiver.normal;
    let unknown = dot(normal, normal) == 0.0;
    normal = select(normal, -f.row_z.xyz, unknown);
    let n = in_face(face, normal);
    if n.z >= 0.0 {
        return 0.0;                 // it faces away
    }
    var offset = select(receiver.offset + dot(n, vec3f(f.row_x.w, f.row_y.w, f.row_z.w)), dot(n, q), unknown);
    offset += raised(receiver, f.projection.z, q.z, -n.z);
    return filtered(Site(face, q.xy / f.projection.x, q.z, normal, offset), pixel);
}

// The finest cascade that shows the pixel; near its border, it passes into the next. They are chosen first and looked up
// then, two at most, so that all pixels look up together.
fn from_afar(receiver: Receiver, pixel: vec2u) -> f32 {
    var finest = CASCADE_COUNT;
    var next = CASCADE_COUNT;
    var weight = 1.0;
    for (var face = 0u; face < CASCADE_COUNT; face++) {
        let f = map_light.faces[face];
        let q = position_in_face(face, receiver.position);
        // The filter stays inside.
        let reach = map_light.size.z + 3.0 * f.projection.z;
        let room = f.projection.x - reach - max(abs(q.x), abs(q.y));
        let shows = room > 0.0 && q.z < f.projection.y;
        let width = max(map_light.limits.w * f.projection.x, 1e-6);
        next = select(next, face, shows && finest < face && next == CASCADE_COUNT);
        weight = select(weight, clamp(room / width, 0.0, 1.0), shows && finest == CASCADE_COUNT);
        finest = select(finest, face, shows && finest == CASCADE_COUNT);
    }
    if finest == CASCADE_COUNT {
        return 1.0;                 // beyond the last
    }
    var visibility = from_cascade(finest, receiver, pixel);
    if weight < 1.0 && next < CASCADE_COUNT {
        visibility = mix(from_cascade(next, receiver, pixel), visibility, weight);
    }
    return visibility;
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let receiver = receiver_at(position.xy);
    // Nothing there, or out of the light's reach: nobody looks.
    if receiver.depth == 0.0 || receiver.depth > map_light.limits.x || receiver.depth < map_light.limits.y {
        return vec4f(vec3f(select(1.0, 0.0, SHOW_TAPS)), 1.0);
    }
    let pixel = vec2u(position.xy);
    var visibility: f32;
    if SHAPE == CASCADES {
        visibility = from_afar(receiver, pixel);
    } else {
        visibility = from_point(receiver, pixel);
    }
    if SHOW_TAPS {
        return vec4f(vec3f(taps / 64.0), visibility);
    }
    return vec4f(visibility);
}
