// Visibility of each pixel, looked up in a map and written into the mask.
// Host    src/techniques/maps/gpu/pipelines.rs
// Groups  0 view, 1 receiver, 2 map and jitter, 3 textures
// Spaces  as in common/map.wgsl; the sites of receivers are those of common/map_site.wgsl
#import antumbra::receiver::{Receiver, receiver_at}
#import antumbra::map::{map_light, FORMAT_DEPTH}
#import antumbra::map_crease::{Creases, Search, clamped, find_creases, ndc_of, place_of, plain_search, plane_row, unpacked}
#import antumbra::map_site::{Site, in_face, cube_face, plane_along, plane_depth, raised, STEEPEST, UNKNOWN}
#import antumbra::map_site::{Lookup, blended, known_site, lookup_in_cascades, lookup_of_site, site_from_point, CUBE, CASCADES, MATRICES}
#import antumbra::map_matrix::{NO_FACE, clip_in_face, depth_step, plane_in_face, ray_at, showing, texel_side}

@group(2) @binding(1) var compare: sampler_comparison;
@group(2) @binding(2) var jitter: texture_3d<f32>;
@group(3) @binding(0) var depth_map: texture_depth_2d_array;
@group(3) @binding(1) var distance_map: texture_2d_array<f32>;

// Values of FILTER: techniques::maps::MapFilter in its order; the adaptive variant of `Jittered` comes last.
const BILINEAR: u32 = 0u;           // mirror: techniques::maps::MapFilter::Bilinear
const BRUTE: u32 = 1u;              // mirror: techniques::maps::MapFilter::Brute4x4
const DITHERED: u32 = 2u;           // mirror: techniques::maps::MapFilter::Dithered4
const JITTERED: u32 = 3u;           // mirror: techniques::maps::MapFilter::Jittered
const SOFT: u32 = 4u;               // mirror: techniques::maps::MapFilter::Soft4
const ADAPTIVE: u32 = 5u;           // mirror: techniques::maps::MapFilter::Jittered, adaptive

override FILTER: u32 = 0u;
override SHAPE: u32 = 0u;
override FORMAT: u32 = 0u;
override CASCADE_COUNT: u32 = 1u;
override SHOW_TAPS: bool = false;

// Pixels along a side of the jitter's tile; texels of its rim and of all samples, two samples each:
// techniques::maps::jitter.
const TILE: u32 = 16u;              // mirror: techniques::maps::jitter::TILE
const RIM_TEXELS: i32 = 4;          // mirror: techniques::maps::jitter::RIM / 2
const JITTER_TEXELS: i32 = 32;      // mirror: techniques::maps::jitter::DEPTH

var<private> taps: f32 = 0.0;

// The creases of the receiver that is looked up.
var<private> creases: Creases;

// More of a receiver as seen in a face with a matrix.
struct MatrixSite {
    position: vec3f,                // relative
    farthest: vec3f,                // the deepest point that a plane may reach within a texel
    side_x: vec3f,                  // sides of the square around the filter's disc
    side_y: vec3f,
    slack: f32,                     // factor on depth
    texel_depth: f32,               // change of depth along the ray over the side of a texel
    raise: f32,                     // metres by which planes are raised
}

// Rounding of w as a share of the greatest w. Corners of large casters have that w, and where w is small,
// their rounding is a larger share of depth.
const W_ROUNDING: f32 = 2e-7;

var<private> matrix_site: MatrixSite;

// 1 where a plane is nearer to the light than the squared distance in a texel, else 0.
fn is_lit(site: Site, face: u32, texel: vec2i) -> f32 {
    let inside = clamped(texel);
    let stored = unpacked(textureLoad(distance_map, inside, face, 0), FORMAT);
    let projection = map_light.faces[face].projection;
    let direction = vec3f(ndc_of(inside) * projection.x, 1.0);
    var along = plane_along(site, face, direction);
    for (var i = 0u; i < creases.count; i++) {
        along = min(along, plane_along(creases.sites[i], face, direction));
    }
    let share = along * along * dot(direction, direction) * map_light.limits.z;
    return select(0.0, 1.0, share * (1.0 - map_light.bias.y) - map_light.bias.z <= stored);
}

// One tap: compares the four texels around a place of a face, weighted by the position between them. Hardware
// compares all four with one depth; it is the plane's depth at the texel where the plane is nearest to the
// light.
fn tap_face(site: Site, face: u32, ndc: vec2f) -> f32 {
    taps += 1.0;
    let size = map_light.size.x;
    let place = (ndc * vec2f(0.5, -0.5) + 0.5) * size;
    let corner = place - 0.5;
    let between = fract(corner);
    if FORMAT == FORMAT_DEPTH {
        var depth = plane_depth(site, face, ndc, between, SHAPE == CASCADES);
        for (var i = 0u; i < creases.count; i++) {
            depth = max(depth, plane_depth(creases.sites[i], face, ndc, between, SHAPE == CASCADES));
        }
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

// The planes of the receiver and of its creases in the face of a tap: each row times (NDC, 1) is a depth.
var<private> rows: array<vec3f, 3>;

// 1 where one of the planes is nearer to the light than what a texel of a face with a matrix holds, else 0.
fn is_lit_in_matrix(face: u32, texel: vec2i, deepest: f32) -> f32 {
    let inside = clamped(texel);
    let place = vec3f(ndc_of(inside), 1.0);
    let nearest = max(max(dot(rows[0], place), dot(rows[1], place)), dot(rows[2], place));
    let depth = max(nearest, deepest) * matrix_site.slack;
    return select(0.0, 1.0, depth >= textureLoad(depth_map, inside, face, 0));
}

// One tap in a face with a matrix. Its depth on a plane is linear in NDC. Each texel is compared with the plane's depth in
// that texel: near the eye w, and depth with it, changes by more from texel to texel than it does from a caster to a
// receiver close below it, so one depth for four texels, as hardware compares, would let light through.
fn tap_matrix(site: Site, face: u32, ndc: vec2f) -> f32 {
    taps += 1.0;
    let place = place_of(ndc);
    rows[0] = plane_row(site, face);
    rows[1] = rows[0];
    rows[2] = rows[0];
    for (var i = 0u; i < creases.count; i++) {
        rows[i + 1u] = plane_row(creases.sites[i], face);
    }
    let farthest = clip_in_face(face, matrix_site.farthest);
    let deepest = max(farthest.z, 0.0) / max(farthest.w, 1e-37);
    if FILTER == JITTERED || FILTER == ADAPTIVE {
        return is_lit_in_matrix(face, vec2i(floor(place)), deepest);
    }
    let texel = vec2i(floor(place - 0.5));
    let between = fract(place - 0.5);
    let top = mix(
        is_lit_in_matrix(face, texel, deepest),
        is_lit_in_matrix(face, texel + vec2i(1, 0), deepest),
        between.x,
    );
    let bottom = mix(
        is_lit_in_matrix(face, texel + vec2i(0, 1), deepest),
        is_lit_in_matrix(face, texel + vec2i(1, 1), deepest),
        between.x,
    );
    return mix(top, bottom, between.y);
}

// A tap at an offset from the pixel's own place, in texels; in units of the disc if the filter has one. The
// disc may reach into other faces.
fn tap_matrices(site: Site, offset: vec2f) -> f32 {
    if FILTER == JITTERED || FILTER == ADAPTIVE || FILTER == SOFT {
        let beside = matrix_site.position + matrix_site.side_x * offset.x + matrix_site.side_y * offset.y;
        let shown = showing(beside);
        let face = select(shown, site.face, shown == NO_FACE);
        let clip = clip_in_face(face, beside);
        return tap_matrix(site, face, clip.xy / max(clip.w, 1e-37));
    }
    return tap_matrix(site, site.face, site.ndc + offset * vec2f(2.0, -2.0) * map_light.size.y);
}

// A tap at an offset in texels from the pixel's own place. On a cube it may be in another face.
fn tap(site: Site, texels: vec2f) -> f32 {
    if SHAPE == MATRICES {
        return tap_matrices(site, texels);
    }
    let ndc = site.ndc + texels * vec2f(2.0, -2.0) * map_light.size.y;
    if SHAPE == CUBE {
        let map_face = map_light.faces[site.face];
        let side = map_face.projection.x;
        let direction = map_face.row_x.xyz * (ndc.x * side) + map_face.row_y.xyz * (ndc.y * side)
            + map_face.row_z.xyz;
        let face = cube_face(direction);
        let direction_face = in_face(face, direction);
        return tap_face(site, face, direction_face.xy / (direction_face.z * side));
    }
    return tap_face(site, site.face, ndc);
}

// Offsets of a step of the filter: of one tap or, if jittered, of two. In texels, or in units of the disc if the filter has one
// and the face a matrix.
fn step_offsets(step: i32, pixel: vec2u, radius: f32) -> vec4f {
    var offset = vec2f(0.0);
    if FILTER == BRUTE {
        // Source: Bunnell & Pellacini 2004, GPU Gems ch. 11, §11.3.
        offset = vec2f(f32(step & 3), f32(step >> 2u)) - 1.5;
    }
    if FILTER == DITHERED {
        // Source: Bunnell & Pellacini 2004, GPU Gems ch. 11, §11.4: the pattern of figure 11-4.
        let odd_x = pixel.x & 1u;
        offset = vec2f(f32(odd_x), f32(odd_x ^ (pixel.y & 1u)));
        offset += vec2f(select(-1.5, 0.5, (step & 1) == 1), select(0.5, -1.5, step >= 2));
    }
    if FILTER == SOFT {
        // The taps are corners of a square, turned so that no two share a row.
        // Source: Gerasimov 2004, GPU Gems ch. 12, listing 12-3.
        let a = vec2f(0.9239, 0.3827) * radius;
        offset = select(a, vec2f(-a.y, a.x), step >= 2) * select(1.0, -1.0, (step & 1) == 1);
    }
    if FILTER == JITTERED || FILTER == ADAPTIVE {
        return textureLoad(jitter, vec3i(vec2i(pixel % TILE), step), 0) * radius;
    }
    return vec4f(offset, offset);
}

// Number of steps of the filter.
fn step_count() -> i32 {
    if FILTER == BRUTE {
        return 16;
    }
    if FILTER == DITHERED || FILTER == SOFT {
        return 4;
    }
    return select(1, JITTER_TEXELS, FILTER == JITTERED || FILTER == ADAPTIVE);
}

// The filter has one call of a tap, and the shader one call of the filter: drivers copy what is called to every call, before
// they find out which filter and shape there are, and took most of a second for it.
//
// The rim of jittered taps indicates whether the whole disc is lit or dark. The other taps are made only where it disagrees.
// Source: Uralsky & Ahmad 2004, "Soft Shadows" (NVIDIA SDK white paper).
fn filtered_once(site: Site, pixel: vec2u, radius: f32) -> f32 {
    let steps = step_count();
    let taps_of_step = select(1, 2, FILTER == JITTERED || FILTER == ADAPTIVE);
    let rim = f32(RIM_TEXELS) * 2.0;
    var sum = 0.0;
    for (var step = 0; step < steps; step++) {
        if FILTER == ADAPTIVE && step == RIM_TEXELS && (sum == 0.0 || sum == rim) {
            return sum / rim;
        }
        let offsets = step_offsets(step, pixel, radius);
        var of_step = 0.0;
        for (var i = 0; i < taps_of_step; i++) {
            of_step += tap(site, select(offsets.xy, offsets.zw, i == 1));
        }
        sum += of_step;
    }
    return sum / f32(steps * taps_of_step);
}

// How far from the receiver's place the filter's disc reaches along one of its axes, in a face with a matrix; texels.
fn reach_of(site: Site, side: vec3f) -> vec2f {
    let clip = clip_in_face(site.face, matrix_site.position + side);
    let reach = place_of(clip.xy / max(clip.w, 1e-37)) - place_of(site.ndc);
    let texels = min(length(reach), map_light.size.x);
    return reach * ((texels + 1.0) / max(texels, 1e-6));
}

// How creases are searched for; everywhere that the filter reaches if `is_wide`.
fn search_of(site: Site, radius: f32, is_wide: bool) -> Search {
    let is_square = FILTER == BRUTE || FILTER == DITHERED;
    let count = select(4, 20, is_wide);
    if SHAPE != MATRICES {
        return plain_search(SHAPE, FORMAT, site, select(radius + 1.0, 3.0, is_square), count);
    }
    let farthest = clip_in_face(site.face, matrix_site.farthest);
    var beside_x = vec2f(3.0, 0.0);
    var beside_y = vec2f(0.0, 3.0);
    if is_wide && !is_square {
        beside_x = reach_of(site, matrix_site.side_x);
        beside_y = reach_of(site, matrix_site.side_y);
    }
    return Search(
        SHAPE,
        FORMAT,
        matrix_site.texel_depth,
        matrix_site.raise,
        matrix_site.slack,
        0.0,
        max(farthest.z, 0.0) / max(farthest.w, 1e-37),
        max(2e-6, matrix_site.slack - 1.0),
        0.0,
        beside_x,
        beside_y,
        count,
    );
}

// The filter is applied again where a surface darkens the receiver that only meets it in a crease. Some tap of such a pixel
// is lit: the taps surround it, and it is on its own side of the crease. So what is wholly dark is searched but little.
fn filtered(site: Site, pixel: vec2u) -> f32 {
    let texel = map_light.faces[site.face].projection.z;
    let radius = select(map_light.size.z / texel, 1.0, SHAPE == MATRICES);
    creases.count = 0u;
    var visibility = 1.0;
    for (var turn = 0; turn < 2; turn++) {
        visibility = filtered_once(site, pixel, radius);
        if turn == 1 || visibility == 1.0 {
            break;
        }
        let is_wide = FILTER != BILINEAR && visibility > 0.0;
        creases = find_creases(depth_map, distance_map, search_of(site, radius, is_wide), site);
        if creases.count == 0u {
            break;
        }
    }
    return visibility;
}

// Visibility at a site.
fn at_site(site: Site, pixel: vec2u) -> f32 {
    if site.known != UNKNOWN {
        return site.known;
    }
    return filtered(site, pixel);
}

// The site of a receiver in the face that shows it; sets `matrix_site`.
fn site_in_matrix(receiver: Receiver) -> Site {
    let face = showing(receiver.position);
    if face == NO_FACE {
        return known_site(1.0);     // out of all faces
    }
    let clip = clip_in_face(face, receiver.position);
    let ray = ray_at(face, receiver.position);
    // A receiver without a plane is assumed to face the light.
    let unknown = dot(receiver.normal, receiver.normal) == 0.0;
    let normal = select(receiver.normal, -ray, unknown);
    var offset = select(receiver.offset, dot(normal, receiver.position), unknown);
    let height = plane_in_face(face, normal, offset).z;
    if height <= 0.0 {
        return known_site(0.0);     // it faces away
    }
    let side_x = texel_side(face, 0u, receiver.position, clip.w, ray);
    let side_y = texel_side(face, 1u, receiver.position, clip.w, ray);
    let texel = max(length(side_x), length(side_y));
    // Parallel rays come from a light at no distance: its homogeneous point has w = 0.
    let light = map_light.faces[face].relative_from_clip[2];
    let is_point = light.w != 0.0;
    let light_w = select(1.0, light.w, is_point);
    let distance = select(1.0, length(receiver.position - light.xyz / light_w), is_point);
    let radius = map_light.size.z * distance;
    let along = select(0.0, distance, is_point);
    let raise = raised(receiver, texel + 0.5 * radius, along, max(dot(normal, -ray), 0.0));
    offset += select(raise, min(raise, 0.5 * height / light_w), is_point);
    let across = select(map_light.faces[face].row_x.xyz, map_light.faces[face].row_y.xyz,
        abs(dot(ray, map_light.faces[face].row_x.xyz)) > 0.7);
    let disc_x = normalize(across - ray * dot(across, ray));
    matrix_site = MatrixSite(
        receiver.position,
        receiver.position + ray * (STEEPEST * texel),
        disc_x * radius,
        cross(ray, disc_x) * radius,
        1.0 + map_light.bias.y + W_ROUNDING / clip.w,
        depth_step(face, clip, ray * texel),
        raise,
    );
    return Site(face, clip.xy / clip.w, along, normal, offset, UNKNOWN);
}

fn lookup_of(receiver: Receiver) -> Lookup {
    if SHAPE == CASCADES {
        return lookup_in_cascades(receiver, CASCADE_COUNT);
    }
    if SHAPE == MATRICES {
        return lookup_of_site(site_in_matrix(receiver));
    }
    return lookup_of_site(site_from_point(receiver, SHAPE));
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let receiver = receiver_at(position.xy);
    // No surface is there, or it is out of the light's reach: the value is not used.
    if receiver.depth == 0.0 || receiver.depth > map_light.limits.x || receiver.depth < map_light.limits.y {
        return vec4f(vec3f(select(1.0, 0.0, SHOW_TAPS)), 1.0);
    }
    let pixel = vec2u(position.xy);
    let lookup = lookup_of(receiver);
    var seen = array<f32, 2>(1.0, 1.0);
    for (var i = 0u; i < lookup.count; i++) {
        seen[i] = at_site(lookup.sites[i], pixel);
    }
    let visibility = blended(lookup, seen);
    if SHOW_TAPS {
        return vec4f(vec3f(taps / 64.0), visibility);
    }
    return vec4f(visibility);
}
