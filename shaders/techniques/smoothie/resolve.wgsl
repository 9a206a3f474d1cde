// Visibility of each pixel, looked up in a map and its smoothies and written into the mask.
// Host    src/techniques/smoothie/gpu/recorder.rs
// Groups  0 view, 1 receiver, 2 map, 3 depths and smoothies
// Spaces  as in common/map.wgsl
//
// The comparison with the map is that of its bilinear filter, so the umbra is the same, creases included. Each of the four texels
// then gives 0 behind a caster, a' behind a smoothie, and 1 elsewhere.
#import antumbra::receiver::{Receiver, receiver_at}
#import antumbra::map::{map_light, FORMAT_DEPTH}
#import antumbra::map_crease::{Creases, clamped, find_creases, ndc_of, place_of, plain_search}
#import antumbra::map_site::{Site, in_face, plane_along, plane_depth, STEEPEST, UNKNOWN, CASCADES}
#import antumbra::map_site::{Lookup, blended, lookup_in_cascades, lookup_of_site, site_from_point}
#import antumbra::smoothie::{visibility_from_point, visibility_parallel}

@group(2) @binding(1) var compare: sampler_comparison;
@group(3) @binding(0) var all_depth: texture_depth_2d_array;
@group(3) @binding(1) var still_depth: texture_depth_2d_array;
@group(3) @binding(2) var smoothies: texture_2d_array<f32>;

// Scale of reciprocals of distances, as a share of the distance of the near plane.
const SCALE_OF_NEAR: f32 = 32768.0; // mirror: techniques::smoothie::records::SCALE_OF_NEAR

override SHAPE: u32 = 0u;
override CASCADE_COUNT: u32 = 1u;

// The creases of the receiver that is looked up.
var<private> creases: Creases;

// Distance from the light, along the face's axis, at which the ray of a texel meets a plane.
fn along_at(site: Site, ndc: vec2f) -> f32 {
    let projection = map_light.faces[site.face].projection;
    if SHAPE != CASCADES {
        return plane_along(site, site.face, vec3f(ndc * projection.x, 1.0));
    }
    let normal_face = in_face(site.face, site.normal);
    let hit = (site.offset - dot(normal_face.xy, ndc) * projection.x) / min(normal_face.z, -1e-6);
    return min(hit, site.along + STEEPEST * projection.z);
}

// Visibility at one texel. `depth` is the receiver's, for the comparison with the map.
fn at_texel(site: Site, texel: vec2i, depth: f32) -> f32 {
    let inside = clamped(texel);
    let stored = textureLoad(smoothies, inside, site.face, 0).rg;
    let still = textureLoad(still_depth, inside, site.face, 0);
    let lit = depth >= textureLoad(all_depth, inside, site.face, 0);
    let ndc = ndc_of(inside);
    let projection = map_light.faces[site.face].projection;
    // The receiver's plane on the texel's own ray: near its own silhouette, a surface recedes from its own
    // smoothie as fast as alpha grows.
    var along = along_at(site, ndc);
    for (var i = 0u; i < creases.count; i++) {
        along = min(along, along_at(creases.sites[i], ndc));
    }
    var visibility: f32;
    if SHAPE == CASCADES {
        visibility = visibility_parallel(stored, along, (1.0 - still) * projection.y, map_light.limits.z);
    } else {
        let scale = projection.y * SCALE_OF_NEAR;
        visibility = visibility_from_point(stored, 1.0 / along, still / projection.y, scale);
    }
    return select(0.0, visibility, lit);
}

fn at_site(site: Site) -> f32 {
    if site.known != UNKNOWN {
        return site.known;
    }
    let place = place_of(site.ndc);
    let corner = place - 0.5;
    let between = fract(corner);
    creases.count = 0u;
    var depth = plane_depth(site, site.face, site.ndc, between, SHAPE == CASCADES);
    var hard = textureSampleCompareLevel(all_depth, compare, place * map_light.size.y, site.face, depth);
    if hard < 1.0 {
        let search = plain_search(SHAPE, FORMAT_DEPTH, site, 1.0, 4);
        creases = find_creases(all_depth, smoothies, search, site);
        for (var i = 0u; i < creases.count; i++) {
            depth = max(depth, plane_depth(creases.sites[i], site.face, site.ndc, between, SHAPE == CASCADES));
        }
        if creases.count > 0u {
            hard = textureSampleCompareLevel(all_depth, compare, place * map_light.size.y, site.face, depth);
        }
    }
    if hard == 0.0 {
        return 0.0;
    }
    let first = vec2i(floor(corner));
    var around = array<f32, 4>(0.0, 0.0, 0.0, 0.0);
    for (var i = 0; i < 4; i++) {
        around[i] = at_texel(site, first + vec2i(i & 1, i >> 1u), depth);
    }
    let top = mix(around[0], around[1], between.x);
    let bottom = mix(around[2], around[3], between.x);
    return min(mix(top, bottom, between.y), hard);
}

fn lookup_of(receiver: Receiver) -> Lookup {
    if SHAPE == CASCADES {
        return lookup_in_cascades(receiver, CASCADE_COUNT);
    }
    return lookup_of_site(site_from_point(receiver, SHAPE));
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let receiver = receiver_at(position.xy);
    // No surface is there, or it is out of the light's reach: the value is not used.
    if receiver.depth == 0.0 || receiver.depth > map_light.limits.x || receiver.depth < map_light.limits.y {
        return vec4f(1.0);
    }
    let lookup = lookup_of(receiver);
    var seen = array<f32, 2>(1.0, 1.0);
    for (var i = 0u; i < lookup.count; i++) {
        seen[i] = at_site(lookup.sites[i]);
    }
    return vec4f(blended(lookup, seen));
}
