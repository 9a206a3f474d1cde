// The share of a light that a polygon hides which cuts the light.
// Host    src/techniques/penumbra_wedge/geometry/cut.rs
// Spaces  homogeneous places on the light: xy / z on the square from −1 to 1 or the unit disc; z: share of the way to it
#define_import_path antumbra::cut_surface

#import antumbra::conventions::PI
#import antumbra::coverage::{Seen, LEAST_WAY, border_place, clip_range, place_on_rect, place_on_disc, project_to_rect, disc_frame}
#import antumbra::light_places::{Places, Sampling, Sides, places_between, unit_line}
#import antumbra::wedge_light::{light, Maths, behind}

// A polygon of homogeneous places on the light. It may cross itself: its area counts with its sign.
struct Polygon {
    corners: array<vec3f, 8>,       // MOST_CORNERS
    count: u32,
    turn: f32,                      // 1: what turns counter-clockwise hides; −1: what turns clockwise does
}

// Four corners, and one more for each of the four lines that cut them.
const MOST_CORNERS: u32 = 8u;

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
        if (at_last >= 0.0) != (at_next >= 0.0) && kept.count < MOST_CORNERS {
            // `mix` would leave a corner where it is, beyond the line, if the other one is 1e7 times farther from it.
            kept.corners[kept.count] = (last * at_next - next * at_last) / (at_next - at_last);
            kept.count += 1u;
        }
        if at_next >= 0.0 && kept.count < MOST_CORNERS {
            kept.corners[kept.count] = next;
            kept.count += 1u;
        }
    }
    return kept;
}

// The part of a polygon between a receiver and the light, as the receiver sees it on the light; without corners if it lies
// beside the light. The polygon turns counter-clockwise about the normal of its plane, and `height` is the receiver's
// distance from the plane. Points of the light that are behind the plane by less than `clearance`, metres, are not hidden:
// otherwise a surface in which the light nearly lies would hide whatever rounding puts behind it.
fn cut_polygon(p: vec3f, height: f32, plane: vec4f, corners: array<vec3f, 4>, clearance: f32, is_sphere: bool) -> Polygon {
    var polygon: Polygon;
    polygon.count = select(0u, 4u, is_sphere || p.z < 0.0);
    polygon.turn = select(-1.0, 1.0, height < 0.0);
    var points = corners;
    for (var i = 0u; i < 4u; i++) {
        if is_sphere {
            polygon.corners[i] = place_on_disc(p, points[i], light.half_size.x);
        } else {
            polygon.corners[i] = place_on_rect(p, points[i], light.half_size);
        }
    }
    polygon = clip_polygon(polygon, vec4f(0.0, 0.0, 1.0, -LEAST_WAY));
    for (var i = 0u; i < polygon.count; i++) {
        // Rounding leaves corners beyond the line, because the shares of the way reach thousands for a receiver close to the
        // light's plane.
        polygon.corners[i].z = max(polygon.corners[i].z, LEAST_WAY);
    }
    polygon = clip_polygon(polygon, vec4f(0.0, 0.0, -1.0, 1.0));
    if clearance > 0.0 {
        let frame = disc_frame(p);
        let on_disc = vec2f(dot(plane.xyz, frame.across), dot(plane.xyz, frame.up));
        let tilt = select(plane.xy, on_disc, is_sphere) * light.half_size;
        let behind_plane = vec3f(tilt, plane.w) * polygon.turn;
        polygon = clip_polygon(polygon, vec4f(behind_plane - vec3f(0.0, 0.0, clearance), 0.0));
    }
    if is_beside(polygon) {
        polygon.count = 0u;
    }
    return polygon;
}

// Whether all corners lie beyond one side of the square around the light.
fn is_beside(polygon: Polygon) -> bool {
    var beyond = vec4<bool>(true);
    var all_corners = polygon;
    for (var i = 0u; i < all_corners.count; i++) {
        let at = all_corners.corners[i];
        beyond = beyond & vec4<bool>(at.xy > at.zz, -at.xy > at.zz);
    }
    return any(beyond);
}

// Signed share of a disc that a ray from its centre sweeps along an edge, up to the edge: a triangle where the edge is on
// the disc, and sectors where it is outside. No angle is taken at a point on the disc, because a corner that is at the
// centre has none.
fn swept_disc(first: vec3f, last: vec3f) -> f32 {
    let line = cross(first, last);
    let scale = inverseSqrt(max(dot(line.xy, line.xy), 1e-30));
    let normal = line.xy * scale;
    let offset = line.z * scale;
    if abs(offset) >= 1.0 {
        return turned(first.xy, last.xy) / (2.0 * PI);
    }
    let along = vec2f(-normal.y, normal.x);
    let half_chord = sqrt(max(1.0 - offset * offset, 0.0));
    let from_place = dot(first.xy, along) / max(first.z, LEAST_WAY);
    let to_place = dot(last.xy, along) / max(last.z, LEAST_WAY);
    let enters = clamp(from_place, -half_chord, half_chord);
    let leaves = clamp(to_place, -half_chord, half_chord);
    let start = along * enters - normal * offset;
    let end = along * leaves - normal * offset;
    let before = select(0.0, turned(first.xy, start), enters != from_place);
    let after = select(0.0, turned(end, last.xy), leaves != to_place);
    return (before + turn_of(start, end) + after) / (2.0 * PI);
}

// Signed share of a rectangle that a ray from its centre sweeps along an edge. Lengths along the border take the place of
// angles.
fn swept_rect(first: vec3f, last: vec3f) -> f32 {
    let w = vec2f(first.z, last.z);
    var range = vec2f(0.0, 1.0);
    range = clip_range(range, w - vec2f(first.x, last.x));
    range = clip_range(range, w + vec2f(first.x, last.x));
    range = clip_range(range, w - vec2f(first.y, last.y));
    range = clip_range(range, w + vec2f(first.y, last.y));
    if range.x >= range.y {
        return passed(first.xy, last.xy);
    }
    let at = max(mix(vec2f(w.x), vec2f(w.y), range), vec2f(LEAST_WAY));
    let start = mix(first.xy, last.xy, range.x) / at.x;
    let end = mix(first.xy, last.xy, range.y) / at.y;
    let before = select(0.0, passed(first.xy, start), range.x > 0.0);
    let after = select(0.0, passed(end, last.xy), range.y < 1.0);
    return before + 0.125 * turn_of(start, end) + after;
}

fn turn_of(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// The angle from one direction to another, −π to π.
fn turned(a: vec2f, b: vec2f) -> f32 {
    return atan2(turn_of(a, b), dot(a, b));
}

// The way along the border of the square from one direction to another, as a share of the border, −½ to ½. Areas of
// sectors are in proportion to it.
fn passed(a: vec2f, b: vec2f) -> f32 {
    let share = (border_place(b) - border_place(a)) * 0.125;
    return share - round(share);
}

// Signed share of the light that lies behind a polygon and above the receiver's horizon.
fn polygon_share(polygon: Polygon, horizon: vec3f, maths: Maths) -> vec4f {
    var over = clip_polygon(polygon, vec4f(horizon, 0.0));
    var swept = 0.0;
    for (var i = 0u; i < over.count; i++) {
        let first = over.corners[i];
        let last = over.corners[(i + 1u) % over.count];
        if maths.is_sphere {
            swept += swept_disc(first, last);
        } else {
            swept += swept_rect(first, last);
        }
    }
    let share = vec4f(clamp(swept * over.turn, -1.0, 1.0));
    if maths.is_textured {
        return vec4f(polygon_colors(over, maths), share.a);
    }
    return share;
}

// Signed share of a textured light, by colour: the whole for each turn of the polygon around the centre, less what lies
// behind edges that turn about the centre as the polygon does, plus what lies behind the others.
fn polygon_colors(polygon: Polygon, maths: Maths) -> vec3f {
    var over = polygon;
    var share = vec3f(0.0);
    var turns = 0.0;
    for (var i = 0u; i < over.count; i++) {
        let seen = Seen(over.corners[i], over.corners[(i + 1u) % over.count], true);
        let way = passed(seen.first.xy, seen.last.xy);
        turns += way;
        share -= behind(project_to_rect(seen), maths).rgb * sign(way);
    }
    return clamp((share + round(turns)) * over.turn, vec3f(-1.0), vec3f(1.0));
}

// For all places, the part behind a polygon, in steps. It is what lies below the upper edges, less what lies below the
// lower edges. Polygons agree on the steps of the edge that they share, so a surface of thin polygons hides no place
// twice. Sectors around the centre would not do: they have no direction where a corner of the polygon is at the
// centre, which is so wherever a light sits on an edge of the mesh.
fn polygon_places(polygon: Polygon, sampling: Sampling) -> Places {
    var all = polygon;
    var inside: Places;
    for (var i = 0u; i < all.count; i++) {
        let first = all.corners[i];
        let last = all.corners[(i + 1u) % all.count];
        let line = unit_line(cross(first, last));
        let below = Sides(upright_at(first), upright_at(last), line * select(1.0, -1.0, line.y > 0.0));
        let is_lower = first.x * last.z < last.x * first.z;
        let sign = all.turn * select(1.0, -1.0, is_lower);
        let places = places_between(below, sampling);
        inside.first += places.first * sign;
        inside.more += places.more * sign;      // 0 unless dense
    }
    return inside;
}

// The line that runs upwards through a homogeneous place. Its positive side is the right one.
fn upright_at(place: vec3f) -> vec3f {
    return unit_line(vec3f(place.z, 0.0, -place.x));
}
