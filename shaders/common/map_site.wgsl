// A receiver as the faces of a map see it: the face that shows it, its place there, and the plane that
// texels are compared with.
// Spaces  as in common/map.wgsl
//
// A pixel is compared with the plane of its own triangle, traced along each texel's ray: on a flat surface,
// the texel's depth and the plane's depth belong to one point. The plane is raised by a share of a texel for
// surfaces that are not flat.
#define_import_path antumbra::map_site

#import antumbra::map::map_light
#import antumbra::receiver::Receiver

// Values of a shape: techniques::maps::request::MapShape in its order.
const SPOT: u32 = 0u;               // mirror: techniques::maps::request::MapShape::Spot
const CUBE: u32 = 1u;               // mirror: techniques::maps::request::MapShape::Cube
const CASCADES: u32 = 2u;           // mirror: techniques::maps::request::MapShape::Cascades
const MATRICES: u32 = 3u;           // mirror: techniques::maps::request::MapShape::Matrices

// Texels of depth, per texel sideways, by which a plane may recede from the light. Beyond, it counts as
// edge-on. By eye.
const STEEPEST: f32 = 32.0;

// Rounding of positions and planes in f32, as a share of their distance from eye and light.
const ROUNDING: f32 = 2e-6;

// Visibility of a site that a map must be asked for.
const UNKNOWN: f32 = -1.0;

// A receiver as seen in a face.
struct Site {
    face: u32,
    ndc: vec2f,
    along: f32,                     // z in the face's space
    normal: vec3f,                  // of the receiver's plane, relative space
    offset: f32,                    // of the raised plane, from the light (parallel: from the face's origin; matrix: relative)
    known: f32,                     // visibility that follows without the map, or UNKNOWN
}

// The cascades that show a receiver.
struct Chosen {
    finest: u32,                    // CASCADE_COUNT: none
    next: u32,                      // the cascade into which the finest blends; CASCADE_COUNT: none
    weight: f32,                    // of the finest
}

fn in_face(face: u32, vector: vec3f) -> vec3f {
    let map_face = map_light.faces[face];
    return vec3f(
        dot(map_face.row_x.xyz, vector),
        dot(map_face.row_y.xyz, vector),
        dot(map_face.row_z.xyz, vector),
    );
}

fn position_in_face(face: u32, position: vec3f) -> vec3f {
    let map_face = map_light.faces[face];
    return in_face(face, position) + vec3f(map_face.row_x.w, map_face.row_y.w, map_face.row_z.w);
}

// The face of a cube into which a direction points: techniques::omni_map::cube::DIRECTIONS.
fn cube_face(direction: vec3f) -> u32 {
    let size = abs(direction);
    let z_face = select(4u, 5u, direction.z < 0.0);
    let y_face = select(2u, 3u, direction.y < 0.0);
    let x_face = select(0u, 1u, direction.x < 0.0);
    let yz = select(z_face, y_face, size.y >= size.z);
    return select(yz, x_face, size.x >= size.y && size.x >= size.z);
}

// Distance, along the axis of a face, at which a ray of the face meets the site's plane.
fn plane_along(site: Site, face: u32, direction_face: vec3f) -> f32 {
    let towards = dot(in_face(face, site.normal), direction_face);
    let farthest = site.along * (1.0 + STEEPEST * map_light.faces[face].projection.z);
    let hit = site.offset / min(towards, -1e-30);
    return select(farthest, min(hit, farthest), towards < 0.0);
}

// Depth of the site's plane for a comparison with all four texels around a place of a face. It is the plane's
// depth at the texel where the plane is nearest to the light. `between` is the position between the texels.
fn plane_depth(site: Site, face: u32, ndc: vec2f, between: vec2f, parallel: bool) -> f32 {
    let normal_face = in_face(face, site.normal);
    let projection = map_light.faces[face].projection;
    var depth: f32;
    var slope: vec2f;               // of depth, one texel to the right and one down
    var deepest: f32;
    if parallel {
        let steep = min(normal_face.z, -1e-6);
        let along = (site.offset - dot(normal_face.xy, ndc) * projection.x) / steep;
        depth = 1.0 - along / projection.y;
        slope = vec2f(normal_face.x, -normal_face.y) * (projection.z / (steep * projection.y));
        deepest = 1.0 - (site.along + STEEPEST * projection.z) / projection.y;
    } else {
        let scale = projection.y / site.offset;
        depth = dot(normal_face, vec3f(ndc * projection.x, 1.0)) * scale;
        slope = vec2f(normal_face.x, -normal_face.y) * (projection.z * scale);
        deepest = projection.y / (site.along * (1.0 + STEEPEST * projection.z));
    }
    let lenient = max(slope * (1.0 - between), -slope * between);
    // Nothing is drawn where the plane leaves the far end of a parallel box, so no caster is nearer there.
    depth = max(max(depth + lenient.x + lenient.y, deepest), 0.0);
    return depth * (1.0 + map_light.bias.y) + map_light.bias.z;
}

// Distance by which a plane is raised, metres.
fn raised(receiver: Receiver, texel: f32, along: f32, facing: f32) -> f32 {
    return map_light.bias.x * texel + map_light.bias.w * facing
        + ROUNDING * (length(receiver.position) + abs(along));
}

// The site of a receiver of a spot light or of a light with a cube.
fn site_from_point(receiver: Receiver, shape: u32) -> Site {
    let first = map_light.faces[0];
    var face = 0u;
    var position_face = position_in_face(0u, receiver.position);
    if shape == CUBE {
        let from_light = first.row_x.xyz * position_face.x + first.row_y.xyz * position_face.y
            + first.row_z.xyz * position_face.z;
        face = cube_face(from_light);
        position_face = position_in_face(face, receiver.position);
    }
    let map_face = map_light.faces[face];
    var normal = receiver.normal;
    let normal_face = in_face(face, normal);
    let origin = vec3f(map_face.row_x.w, map_face.row_y.w, map_face.row_z.w);
    var offset = receiver.offset + dot(normal_face, origin);
    if dot(normal, normal) == 0.0 {
        // A receiver without a plane is assumed to face the light.
        let towards = -position_face / max(length(position_face), 1e-30);
        normal = map_face.row_x.xyz * towards.x + map_face.row_y.xyz * towards.y
            + map_face.row_z.xyz * towards.z;
        offset = dot(towards, position_face);
    }
    if offset >= 0.0 {              // it faces away
        return Site(face, vec2f(0.0), position_face.z, normal, offset, 0.0);
    }
    if position_face.z <= map_face.projection.y { // in front of the near plane
        return Site(face, vec2f(0.0), position_face.z, normal, offset, 1.0);
    }
    let raise = raised(
        receiver,
        map_face.projection.z * position_face.z,
        length(position_face),
        -offset / max(length(position_face), 1e-30),
    );
    offset += min(raise, -0.5 * offset);
    let ndc = position_face.xy / (position_face.z * map_face.projection.x);
    let out_of_cone = shape == SPOT && max(abs(ndc.x), abs(ndc.y)) > 1.0;
    return Site(face, ndc, position_face.z, normal, offset, select(UNKNOWN, 1.0, out_of_cone));
}

// The site of a receiver in one cascade.
fn site_in_cascade(face: u32, receiver: Receiver) -> Site {
    let map_face = map_light.faces[face];
    let position_face = position_in_face(face, receiver.position);
    var normal = receiver.normal;
    let unknown = dot(normal, normal) == 0.0;
    normal = select(normal, -map_face.row_z.xyz, unknown);
    let normal_face = in_face(face, normal);
    if normal_face.z >= 0.0 {       // it faces away
        return Site(face, vec2f(0.0), position_face.z, normal, 0.0, 0.0);
    }
    var offset = select(
        receiver.offset + dot(normal_face, vec3f(map_face.row_x.w, map_face.row_y.w, map_face.row_z.w)),
        dot(normal_face, position_face),
        unknown,
    );
    offset += raised(receiver, map_face.projection.z, position_face.z, -normal_face.z);
    return Site(face, position_face.xy / map_face.projection.x, position_face.z, normal, offset, UNKNOWN);
}

// The finest cascade that shows the receiver; near its border, also the next one. Cascades are chosen before
// any is looked up, at most two, so that all pixels take the lookup together.
fn choose_cascades(receiver: Receiver, count: u32) -> Chosen {
    var chosen = Chosen(count, count, 1.0);
    for (var face = 0u; face < count; face++) {
        let map_face = map_light.faces[face];
        let position_face = position_in_face(face, receiver.position);
        // The filter's taps stay inside the cascade.
        let reach = map_light.size.z + 3.0 * map_face.projection.z;
        let room = map_face.projection.x - reach - max(abs(position_face.x), abs(position_face.y));
        let shows = room > 0.0 && position_face.z < map_face.projection.y;
        let width = max(map_light.limits.w * map_face.projection.x, 1e-6);
        chosen.next = select(chosen.next, face, shows && chosen.finest < face && chosen.next == count);
        chosen.weight = select(chosen.weight, clamp(room / width, 0.0, 1.0), shows && chosen.finest == count);
        chosen.finest = select(chosen.finest, face, shows && chosen.finest == count);
    }
    return chosen;
}

// The sites at which a receiver is looked up, and the weight of the first. Shaders look them up in one loop, because drivers
// copy what is called to every call.
struct Lookup {
    count: u32,
    sites: array<Site, 2>,
    weight: f32,
    shadow_left: f32,               // 1, or less where shadows fade out
}

fn known_site(visibility: f32) -> Site {
    var site: Site;
    site.known = visibility;
    return site;
}

fn lookup_of_site(site: Site) -> Lookup {
    return Lookup(1u, array<Site, 2>(site, known_site(1.0)), 1.0, 1.0);
}

// The finest cascade that shows the receiver; near its border, it blends into the next cascade. Before the view depth at
// which shadows are to end, they fade out.
fn lookup_in_cascades(receiver: Receiver, count: u32) -> Lookup {
    let shadow_left = clamp(map_light.ending.w - dot(map_light.ending.xyz, receiver.position), 0.0, 1.0);
    if shadow_left == 0.0 {
        return lookup_of_site(known_site(1.0));
    }
    let chosen = choose_cascades(receiver, count);
    if chosen.finest == count {
        return lookup_of_site(known_site(1.0)); // beyond the last cascade
    }
    var out = lookup_of_site(site_in_cascade(chosen.finest, receiver));
    out.weight = chosen.weight;
    out.shadow_left = shadow_left;
    if chosen.weight < 1.0 && chosen.next < count {
        out.sites[1] = site_in_cascade(chosen.next, receiver);
        out.count = 2u;
    }
    return out;
}

// Visibility of a lookup from that of its sites.
fn blended(lookup: Lookup, seen: array<f32, 2>) -> f32 {
    let visibility = select(seen[0], mix(seen[1], seen[0], lookup.weight), lookup.count == 2u);
    return select(mix(1.0, visibility, lookup.shadow_left), visibility, lookup.shadow_left == 1.0);
}
