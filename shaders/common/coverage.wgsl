// The share of a light that lies behind an edge as seen from the light's centre: the sector that the
// projected edge cuts off.
// Host    src/techniques/penumbra_wedge/
// Spaces  light: origin at the light's centre, a rectangle in the xy plane that shines to −z
// Source  Assarsson et al. 2003, section 4.2: clip the edge in homogeneous coordinates, project, and subtract
//         the triangle from the sector
#define_import_path antumbra::coverage

#import antumbra::conventions::PI

// An edge projected onto a light and clipped to it. A rectangle is the square from −1 to 1; a disc has radius
// 1.
struct Projected {
    start: vec2f,
    end: vec2f,
    is_visible: bool,
}

// The part of an edge between the receiver and the light, as homogeneous places on the light, not clipped to
// it.
struct Seen {
    first: vec3f,
    last: vec3f,
    is_there: bool,
}

// Clips the range of the parameter along an edge to where a linear function is not negative. `at` has its
// values at the ends.
fn clip_range(range: vec2f, at: vec2f) -> vec2f {
    let crossing = at.x / (at.x - at.y); // used only where the signs differ
    let lower = select(range.x, max(range.x, crossing), at.x < 0.0);
    let upper = select(range.y, min(range.y, crossing), at.y < 0.0);
    return select(vec2f(lower, upper), vec2f(1.0, 0.0), at.x < 0.0 && at.y < 0.0);
}

// Smallest share of the way to the light at which an edge counts.
const LEAST_WAY: f32 = 1e-6;

fn cut_between(a: vec3f, b: vec3f) -> Seen {
    let w = vec2f(a.z, b.z);
    var range = clip_range(vec2f(0.0, 1.0), w - LEAST_WAY);
    range = clip_range(range, 1.0 - w);
    var seen = Seen(mix(a, b, range.x), mix(a, b, range.y), range.x < range.y);
    // Where one end is far nearer to the cut than the other, rounding leaves it beyond the cut.
    seen.first.z = max(seen.first.z, LEAST_WAY);
    seen.last.z = max(seen.last.z, LEAST_WAY);
    return seen;
}

// Projects the edge from `p`. With w the share of the way from `p` to the light's plane, an edge point
// projects to H / w; H and w are linear along the edge. Only points between `p` and the light count, with w
// in 0..1.
fn see_on_rect(p: vec3f, start: vec3f, end: vec3f, half_size: vec2f) -> Seen {
    var seen = cut_between(place_on_rect(p, start, half_size), place_on_rect(p, end, half_size));
    seen.is_there = seen.is_there && p.z < 0.0;
    return seen;
}

// The homogeneous place on the light to which a point projects.
fn place_on_rect(p: vec3f, point: vec3f, half_size: vec2f) -> vec3f {
    let w = (point.z - p.z) / -p.z;
    return vec3f((point.xy - p.xy * (1.0 - w)) / half_size, w);
}

fn project_to_rect(seen: Seen) -> Projected {
    let a = seen.first;
    let b = seen.last;
    let w = vec2f(a.z, b.z);
    var range = vec2f(0.0, 1.0);
    range = clip_range(range, w - vec2f(a.x, b.x));
    range = clip_range(range, w + vec2f(a.x, b.x));
    range = clip_range(range, w - vec2f(a.y, b.y));
    range = clip_range(range, w + vec2f(a.y, b.y));
    let at = max(mix(vec2f(w.x), vec2f(w.y), range), vec2f(1e-9));
    return Projected(
        clamp(mix(a.xy, b.xy, range.x) / at.x, vec2f(-1.0), vec2f(1.0)),
        clamp(mix(a.xy, b.xy, range.y) / at.y, vec2f(-1.0), vec2f(1.0)),
        range.x < range.y && seen.is_there,
    );
}

// Length of the way along the border of the square from (1, 0) to where a direction leaves it,
// counter-clockwise. The whole border is 8 long. The length is twice the sector's area, because every side is
// at distance 1 from the centre, so no angle is needed.
fn border_place(direction: vec2f) -> f32 {
    let size = abs(direction);
    let x_side = direction.y / max(size.x, 1e-20);
    let y_side = -direction.x / max(size.y, 1e-20);
    let on_x = select(4.0 - x_side, x_side, direction.x >= 0.0);
    let on_y = select(6.0 - y_side, 2.0 + y_side, direction.y >= 0.0);
    return select(on_y, on_x, size.x >= size.y);
}

// Share of a rectangle that lies behind an edge.
fn rect_coverage(edge: Projected) -> f32 {
    let between = abs(border_place(edge.start) - border_place(edge.end));
    let sector = 0.5 * min(between, 8.0 - between);
    let triangle = 0.5 * abs(edge.start.x * edge.end.y - edge.start.y * edge.end.x);
    return select(0.0, 0.25 * max(sector - triangle, 0.0), edge.is_visible);
}

// Axes of the disc through a sphere's centre that faces `p`.
struct DiscFrame {
    axis: vec3f,                    // towards the centre
    across: vec3f,
    up: vec3f,
}

fn disc_frame(p: vec3f) -> DiscFrame {
    let axis = -p / max(length(p), 1e-20);
    let other = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(axis.x) > 0.7);
    let across = normalize(other - axis * dot(axis, other));
    return DiscFrame(axis, across, cross(axis, across));
}

fn see_on_disc(p: vec3f, start: vec3f, end: vec3f, radius: f32) -> Seen {
    return cut_between(place_on_disc(p, start, radius), place_on_disc(p, end, radius));
}

// The homogeneous place on the disc to which a point projects.
fn place_on_disc(p: vec3f, point: vec3f, radius: f32) -> vec3f {
    let distance = max(length(p), 1e-20);
    let frame = disc_frame(p);
    let a = point - p;
    return vec3f(vec2f(dot(a, frame.across), dot(a, frame.up)) / radius, dot(a, frame.axis) / distance);
}

// The paper clips the edge at the cone by a quadratic. Here the line of the projected edge comes first, as
// the cross product of its homogeneous ends, so nothing cancels where an end lies beside the receiver.
fn project_to_disc(seen: Seen) -> Projected {
    let line = cross(seen.first, seen.last);
    let scale = inverseSqrt(max(dot(line.xy, line.xy), 1e-30));
    let normal = line.xy * scale;
    let offset = line.z * scale;
    let along = vec2f(-normal.y, normal.x);
    let half_chord = sqrt(max(1.0 - offset * offset, 0.0));
    let from_place = clamp(dot(seen.first.xy, along) / max(seen.first.z, LEAST_WAY), -half_chord, half_chord);
    let to_place = clamp(dot(seen.last.xy, along) / max(seen.last.z, LEAST_WAY), -half_chord, half_chord);
    let foot = -normal * offset;
    return Projected(
        foot + along * from_place,
        foot + along * to_place,
        seen.is_there && abs(offset) < 1.0 && from_place != to_place,
    );
}

// Share of a disc that lies behind an edge.
fn disc_coverage(edge: Projected) -> f32 {
    let triangle = abs(edge.start.x * edge.end.y - edge.start.y * edge.end.x);
    let angle = atan2(triangle, dot(edge.start, edge.end));
    return select(0.0, max(angle - triangle, 0.0) / (2.0 * PI), edge.is_visible);
}

// The part of an edge where a linear function, given by its values at the ends, is not negative.
fn part_of(edge: Projected, at_start: f32, at_end: f32) -> Projected {
    let range = clip_range(vec2f(0.0, 1.0), vec2f(at_start, at_end));
    return Projected(
        mix(edge.start, edge.end, range.x),
        mix(edge.start, edge.end, range.y),
        edge.is_visible && range.x < range.y,
    );
}

// The chord in which a line, `dot(line.xy, place) + line.z == 0`, cuts the light. Unless `is_whole`, only the
// part that is seen from the centre between the ends of `between`.
fn chord_of(line: vec3f, is_disc: bool, between: Projected, is_whole: bool) -> Projected {
    let scale = inverseSqrt(max(dot(line.xy, line.xy), 1e-30));
    let normal = line.xy * scale;
    let foot = -normal * (line.z * scale);
    let along = vec2f(-normal.y, normal.x);
    // The diagonal of the square is 2√2.
    let reach = select(1.5, sqrt(max(1.0 - dot(foot, foot), 0.0)), is_disc);
    let a = foot - along * reach;
    let b = foot + along * reach;
    let bounds = select(1.0, 4.0, is_disc);
    var range = vec2f(0.0, 1.0);
    range = clip_range(range, bounds - vec2f(a.x, b.x));
    range = clip_range(range, bounds + vec2f(a.x, b.x));
    range = clip_range(range, bounds - vec2f(a.y, b.y));
    range = clip_range(range, bounds + vec2f(a.y, b.y));
    let turn = between.start.x * between.end.y - between.start.y * between.end.x;
    let start = select(between.end, between.start, turn >= 0.0);
    let end = select(between.start, between.end, turn >= 0.0);
    let after_start = vec2f(start.x * a.y - start.y * a.x, start.x * b.y - start.y * b.x);
    let before_end = vec2f(a.x * end.y - a.y * end.x, b.x * end.y - b.y * end.x);
    range = select(clip_range(clip_range(range, after_start), before_end), range, is_whole);
    return Projected(
        mix(a, b, range.x),
        mix(a, b, range.y),
        range.x < range.y && reach > 0.0 && (is_whole || between.is_visible),
    );
}
