// The share of a light that a triangle hides which cuts the light.
// Host    src/techniques/penumbra_wedge/geometry/cut.rs
// Spaces  homogeneous places on the light: xy / z on the square from −1 to 1 or the unit disc; z: share of the way to it
#define_import_path antumbra::cut_surface

#import antumbra::coverage::{Seen, LEAST_WAY, place_on_rect, place_on_disc, project_to_rect, project_to_disc}
#import antumbra::wedge_light::{light, Maths, Places, Sampling, behind, places_x, places_y, three_beyond, unit_line}

// A convex polygon of homogeneous places on the light.
struct Polygon {
    corners: array<vec3f, 6>,
    count: u32,
    turn: f32,                      // 1: counter-clockwise; −1: clockwise
}

// Clips a polygon to where a linear function is not negative.
fn clip_polygon(polygon: Polygon, plane: vec4f) -> Polygon {
    var all = polygon;
    var kept: Polygon;
    kept.turn = polygon.turn;
    for (var i = 0u; i < all.count; i++) {
        let last = all.corners[(i + all.count - 1u) % all.count];
        let next = all.corners[i];
        let at_last = dot(plane.xyz, last) + plane.w;
        let at_next = dot(plane.xyz, next) + plane.w;
        if (at_last >= 0.0) != (at_next >= 0.0) && kept.count < 6u {
            kept.corners[kept.count] = mix(last, next, at_last / (at_last - at_next));
            kept.count += 1u;
        }
        if at_next >= 0.0 && kept.count < 6u {
            kept.corners[kept.count] = next;
            kept.count += 1u;
        }
    }
    return kept;
}

// The part of a triangle between a receiver and the light, as the receiver sees it on the light.
fn cut_polygon(p: vec3f, corners: array<vec3f, 3>, is_sphere: bool) -> Polygon {
    var polygon: Polygon;
    polygon.count = select(0u, 3u, is_sphere || p.z < 0.0);
    var points = corners;
    for (var i = 0u; i < 3u; i++) {
        if is_sphere {
            polygon.corners[i] = place_on_disc(p, points[i], light.half_size.x);
        } else {
            polygon.corners[i] = place_on_rect(p, points[i], light.half_size);
        }
    }
    let volume = dot(cross(polygon.corners[0], polygon.corners[1]), polygon.corners[2]);
    polygon.turn = select(-1.0, 1.0, volume >= 0.0);
    return clip_polygon(clip_polygon(polygon, vec4f(0.0, 0.0, 1.0, -LEAST_WAY)), vec4f(0.0, 0.0, -1.0, 1.0));
}

// Share of the light that lies behind a polygon and above the receiver's horizon: 1 if the centre lies behind it, less
// what lies behind its far edges, plus what lies behind its near edges.
fn polygon_share(polygon: Polygon, horizon: vec3f, maths: Maths) -> vec4f {
    var over = clip_polygon(polygon, vec4f(horizon, 0.0));
    var share = vec4f(0.0);
    var holds_center = over.count >= 3u;
    for (var i = 0u; i < over.count; i++) {
        let seen = Seen(over.corners[i], over.corners[(i + 1u) % over.count], true);
        let is_far = cross(seen.first, seen.last).z * over.turn >= 0.0;
        holds_center = holds_center && is_far;
        if maths.is_sphere {
            share += behind(project_to_disc(seen), maths) * select(1.0, -1.0, is_far);
        } else {
            share += behind(project_to_rect(seen), maths) * select(1.0, -1.0, is_far);
        }
    }
    return clamp(share + select(0.0, 1.0, holds_center), vec4f(0.0), vec4f(1.0));
}

// For all places, the part behind a polygon, in steps.
fn polygon_places(polygon: Polygon, sampling: Sampling) -> Places {
    var all = polygon;
    var x = places_x(sampling);
    var y = places_y(sampling);
    var inside: Places;
    let most = vec3f(select(0.0, sampling.steps, all.count >= 3u));
    inside.first = mat3x3f(most, most, most);
    inside.more = mat4x3f(most, most, most, most);
    for (var i = 0u; i < all.count; i++) {
        let line = unit_line(cross(all.corners[i], all.corners[(i + 1u) % all.count]) * all.turn);
        for (var column = 0u; column < 3u; column++) {
            inside.first[column] = min(inside.first[column], three_beyond(line, x.first[column], y.first[column], sampling));
        }
        if sampling.is_dense {
            for (var column = 0u; column < 4u; column++) {
                inside.more[column] = min(inside.more[column], three_beyond(line, x.more[column], y.more[column], sampling));
            }
        }
    }
    return inside;
}
