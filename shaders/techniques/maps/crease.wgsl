// Creases: other surfaces that meet the receiver's plane beside it. They are nearer to the light than that plane, as a
// caster is, and yet do not shadow the receiver.
// Spaces  as in common/map.wgsl
//
// Depth is linear over a plane in every face, so a surface is extrapolated from its texels. The planes of creases join the
// receiver's own: a texel is compared with the nearest to the light of all planes.
#define_import_path antumbra::map_crease

#import antumbra::map::{map_light, unpack_two_bytes, unpack_four_bytes, NOTHING}
#import antumbra::map::{FORMAT_DEPTH, FORMAT_FLOAT, FORMAT_TWO_BYTES}
#import antumbra::map_site::{Site, in_face, CASCADES, MATRICES}
#import antumbra::map_matrix::plane_in_face

// Texels of depth, per texel sideways, by which two surfaces may differ beyond the crease where they meet. By eye.
const STEEPEST_CREASE: f32 = 16.0;

// Share of its slope by which a surface may bend from one texel to the next, to be extrapolated. By eye.
const BENT: f32 = 0.25;

// Texels of depth that a step of a format with bytes may be, for surfaces to be extrapolated.
const COARSEST_STEP: f32 = 0.25;

// Largest number of surfaces that meet the receiver's plane in creases: two, in the corner of a room.
const MOST_CREASES: u32 = 2u;

// The receiver's site with the planes of the surfaces that it meets instead of its own.
struct Creases {
    count: u32,
    sites: array<Site, 2>,
}

// How creases of a receiver are searched for.
struct Search {
    shape: u32,
    format: u32,
    texel_depth: f32,               // change of depth along the ray of light over the side of a texel
    raise: f32,                     // distance by which the plane of a crease is raised, metres
    slack: f32,                     // factor on depth and summand for a comparison
    absolute: f32,
    deepest: f32,                   // depth that the receiver's plane may reach within a texel
    rounding: f32,                  // of depth: a share, or absolute for parallel faces
    step: f32,                      // of a format with bytes: the step of squared distance, as a share of the squared reach
    beside_x: vec2f,                // how far the filter reaches to two sides, texels
    beside_y: vec2f,
    count: i32,                     // 4: the texels around the receiver; 20: those that the filter reaches as well
}

// A plane as depth of a face, which is linear in place: at one place, and its change from one texel to the next (right,
// down).
struct PlaneSlope {
    depth: f32,
    slope: vec2f,
}

// A place in a face, texels.
fn place_of(ndc: vec2f) -> vec2f {
    return (ndc * vec2f(0.5, -0.5) + 0.5) * map_light.size.x;
}

fn ndc_of(texel: vec2i) -> vec2f {
    return vec2f(2.0, -2.0) * ((vec2f(texel) + 0.5) * map_light.size.y) + vec2f(-1.0, 1.0);
}

fn clamped(texel: vec2i) -> vec2i {
    return clamp(texel, vec2i(0), vec2i(i32(map_light.size.x) - 1));
}

// Squared distance of the casters in a texel of a map of distances, as a share of the squared reach.
fn unpacked(texel: vec4f, format: u32) -> f32 {
    if format == FORMAT_FLOAT {
        return texel.r;
    }
    // The largest value means that no caster is there.
    let share = select(unpack_four_bytes(texel), unpack_two_bytes(texel), format == FORMAT_TWO_BYTES);
    return select(share, NOTHING, texel.r >= 1.0);
}

// Row that gives the depth of a site's plane in a face with a matrix, from (NDC, 1).
fn plane_row(site: Site, face: u32) -> vec3f {
    let plane = plane_in_face(face, site.normal, site.offset);
    return plane.xyw * (-1.0 / max(plane.z, 1e-37));
}

fn plane_slope(shape: u32, site: Site, face: u32, ndc: vec2f) -> PlaneSlope {
    if shape == MATRICES {
        let row = plane_row(site, face);
        return PlaneSlope(dot(row, vec3f(ndc, 1.0)), vec2f(row.x, -row.y) * (2.0 * map_light.size.y));
    }
    let normal_face = in_face(face, site.normal);
    let projection = map_light.faces[face].projection;
    if shape == CASCADES {
        let steep = min(normal_face.z, -1e-6);
        let along = (site.offset - dot(normal_face.xy, ndc) * projection.x) / steep;
        let slope = vec2f(normal_face.x, -normal_face.y) * (projection.z / (steep * projection.y));
        return PlaneSlope(1.0 - along / projection.y, slope);
    }
    let scale = projection.y / site.offset;
    let slope = vec2f(normal_face.x, -normal_face.y) * (projection.z * scale);
    return PlaneSlope(dot(normal_face, vec3f(ndc * projection.x, 1.0)) * scale, slope);
}

// Depth of the casters in a texel, whatever the format. `distance_map` is not read if the format is depth.
fn depth_at(
    depth_map: texture_depth_2d_array,
    distance_map: texture_2d_array<f32>,
    format: u32,
    face: u32,
    texel: vec2i,
) -> f32 {
    let inside = clamped(texel);
    if format == FORMAT_DEPTH {
        return textureLoad(depth_map, inside, face, 0);
    }
    let projection = map_light.faces[face].projection;
    let direction = vec3f(ndc_of(inside) * projection.x, 1.0);
    let share = unpacked(textureLoad(distance_map, inside, face, 0), format);
    return projection.y * sqrt(dot(direction, direction) * map_light.limits.z / max(share, 1e-30));
}

// Step of depth in a texel of a format with bytes, as a share of the depth; 0 for other formats.
fn step_of_depth(search: Search, face: u32, texel: vec2i, depth: f32) -> f32 {
    let projection = map_light.faces[face].projection;
    let direction = vec3f(ndc_of(texel) * projection.x, 1.0);
    let along = projection.y / max(depth, 1e-30);
    return 0.5 * search.step / max(along * along * dot(direction, direction) * map_light.limits.z, 1e-30);
}

// Change of depth from a texel to the next one, of the surface in that texel: on the side away from the receiver or, where
// the surface ends there, on the other one. y is 1 if it ends on both sides.
fn surface_slope(
    depth_map: texture_depth_2d_array,
    distance_map: texture_2d_array<f32>,
    search: Search,
    face: u32,
    texel: vec2i,
    axis: vec2i,
    depth: f32,
    away: f32,
) -> vec2f {
    let rounding = search.rounding * select(depth, 1.0, search.shape == CASCADES)
        + 2.0 * depth * step_of_depth(search, face, texel, depth);
    for (var side = 0; side < 2; side++) {
        let step = axis * select(-1, 1, (away >= 0.0) == (side == 0));
        let slope = depth_at(depth_map, distance_map, search.format, face, texel + step) - depth;
        let after = texel + 2 * step;
        let next = depth_at(depth_map, distance_map, search.format, face, after);
        let bend = abs(next - depth - 2.0 * slope);
        if bend <= BENT * abs(slope) + rounding || any(after != clamped(after)) {
            return vec2f(slope * f32(step.x + step.y), 0.0);
        }
    }
    return vec2f(0.0, 1.0);
}

// The site with the plane of a surface in a texel instead of its own: `per_ndc` is the change of the surface's depth over
// NDC, `at_center` its depth in the middle of the face.
fn site_of_surface(search: Search, site: Site, per_ndc: vec2f, at_center: f32) -> Site {
    var out = site;
    let face = map_light.faces[site.face];
    if search.shape == MATRICES {
        let plane = vec4f(-per_ndc, 1.0, -at_center) * face.clip_from_relative;
        let size = max(length(plane.xyz), 1e-30);
        out.normal = plane.xyz / size;
        out.offset = -plane.w / size;
        // Distance of the light from the plane; a directional light has none.
        let light_w = face.relative_from_clip[2].w;
        let height = plane_in_face(site.face, out.normal, out.offset).z / select(1.0, light_w, light_w != 0.0);
        out.offset += select(search.raise, min(search.raise, 0.5 * height), light_w != 0.0);
        return out;
    }
    var normal_face = vec3f(-per_ndc / face.projection.x, -at_center);
    var offset = -face.projection.y;
    if search.shape == CASCADES {
        normal_face = vec3f(-per_ndc * (face.projection.y / face.projection.x), -1.0);
        offset = -face.projection.y * (1.0 - at_center);
    }
    let normal = face.row_x.xyz * normal_face.x + face.row_y.xyz * normal_face.y + face.row_z.xyz * normal_face.z;
    let size = max(length(normal), 1e-30);
    out.normal = normal / size;
    // As a receiver's plane is raised, but never past the light.
    out.offset = offset / size
        + select(min(search.raise, -0.5 * offset / size), search.raise, search.shape == CASCADES);
    return out;
}

// Looks whether the surface in a texel, which is nearer to the light than the receiver's plane there, meets that plane in a
// concave crease between the receiver and the texel: it then does not shadow the receiver. Depth is linear over a plane,
// so the surface is extrapolated to the receiver's own ray, and it must be there all the way to the crease. Returns 1 and
// sets `found` to the surface's plane if so.
fn try_crease(
    depth_map: texture_depth_2d_array,
    distance_map: texture_2d_array<f32>,
    search: Search,
    site: Site,
    own: PlaneSlope,
    texel: vec2i,
    depth: f32,
    apart: vec2f,
    found: ptr<function, Site>,
) -> u32 {
    let above = depth - max(own.depth + dot(own.slope, apart), search.deepest);
    let face = site.face;
    let step = depth * step_of_depth(search, face, texel, depth);
    let too_coarse = step > COARSEST_STEP * search.texel_depth;
    if too_coarse || above > STEEPEST_CREASE * search.texel_depth * (1.0 + length(apart)) {
        return 0u;
    }
    let x = surface_slope(depth_map, distance_map, search, face, texel, vec2i(1, 0), depth, apart.x);
    let y = surface_slope(depth_map, distance_map, search, face, texel, vec2i(0, 1), depth, apart.y);
    let slope = vec2f(x.x, y.x);
    // Each slope is exact to a step of a texel.
    let coarse = step * (1.0 + abs(apart.x) + abs(apart.y));
    let at_receiver = depth - dot(slope, apart) - own.depth - coarse;
    if at_receiver > 0.0 || x.y + y.y > 0.0 {
        return 0u;
    }
    // Two texels beyond the crease the surface must be there already. Otherwise it hangs above the receiver.
    let beyond = at_receiver / min(at_receiver - above, -1e-30) + 2.0 / max(length(apart), 1e-6);
    let probe = vec2i(floor(place_of(site.ndc) + apart * min(beyond, 1.0)));
    let probe_apart = vec2f(probe) + 0.5 - place_of(site.ndc);
    let surface = depth + dot(slope, probe_apart - apart);
    let lower = own.depth + dot(own.slope, probe_apart);
    let there = depth_at(depth_map, distance_map, search.format, face, probe);
    if beyond < 1.0 && abs(there - surface) > 0.5 * abs(surface - lower) + coarse {
        return 0u;
    }
    let per_ndc = slope * vec2f(0.5, -0.5) * map_light.size.x;
    *found = site_of_surface(search, site, per_ndc, depth - dot(per_ndc, ndc_of(texel)));
    return 1u;
}

// Finds the planes that meet the receiver's in concave creases: in the four texels around it and, if the filter reaches
// further, in eight directions.
fn find_creases(
    depth_map: texture_depth_2d_array,
    distance_map: texture_2d_array<f32>,
    search: Search,
    site: Site,
) -> Creases {
    var creases: Creases;
    let receiver = place_of(site.ndc);
    let own = plane_slope(search.shape, site, site.face, site.ndc);
    for (var i = 0; i < search.count && creases.count < MOST_CREASES; i++) {
        let angle = (f32(i) * 2.0 + 1.0) * 0.39269908;
        let beside = (search.beside_x * cos(angle) + search.beside_y * sin(angle)) * select(1.0, 0.5, i < 12);
        let around = vec2f(vec2i(i & 1, (i >> 1) & 1)) - 0.5;
        let texel = clamped(vec2i(floor(receiver + select(beside, around, i < 4))));
        let depth = depth_at(depth_map, distance_map, search.format, site.face, texel);
        let apart = vec2f(texel) + 0.5 - receiver;
        var known = max(own.depth + dot(own.slope, apart), search.deepest);
        for (var crease = 0u; crease < creases.count; crease++) {
            let plane = plane_slope(search.shape, creases.sites[crease], site.face, ndc_of(texel));
            known = max(known, plane.depth);
        }
        let slack = search.slack + step_of_depth(search, site.face, texel, depth);
        if depth > known * slack + search.absolute {
            var found: Site;
            let count =
                try_crease(depth_map, distance_map, search, site, own, texel, depth, apart, &found);
            if count > 0u {
                creases.sites[creases.count] = found;
                creases.count += 1u;
            }
        }
    }
    return creases;
}

// The search for a receiver of a plain map: a spot light's, a cube or cascades. `reach` is that of the filter, texels.
fn plain_search(shape: u32, format: u32, site: Site, reach: f32, count: i32) -> Search {
    let projection = map_light.faces[site.face].projection;
    let own = plane_slope(shape, site, site.face, site.ndc);
    let parallel = shape == CASCADES;
    let is_depth = format == FORMAT_DEPTH;
    var search = Search(
        shape,
        format,
        select(own.depth * projection.z, projection.z / projection.y, parallel),
        map_light.bias.x * projection.z * select(site.along, 1.0, parallel),
        // Squared distances have twice the slack of depth.
        1.0 + map_light.bias.y * select(0.5, 1.0, is_depth),
        select(0.0, map_light.bias.z, is_depth),
        -1e30,
        2e-6,
        select(map_light.bias.z, 0.0, is_depth),
        vec2f(reach, 0.0),
        vec2f(0.0, reach),
        count,
    );
    // The plane of a crease follows from differences between neighbours, and reaches as far as the filter.
    let step = step_of_depth(search, site.face, clamped(vec2i(floor(place_of(site.ndc)))), own.depth);
    search.raise += 2.0 * (1.0 + reach) * step * site.along;
    return search;
}
