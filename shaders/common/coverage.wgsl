// How much of a light lies behind an edge, as seen from the light's centre: the sector that the projected edge cuts
// off, as a share of the whole.
// Host    src/techniques/penumbra_wedge/
// Spaces  light: origin at the light's centre, a rectangle in the xy plane that shines to −z
// Source  Assarsson et al. 2003, section 4.2: clip the edge in homogeneous coordinates, project, sector minus triangle
#define_import_path antumbra::coverage

#import antumbra::conventions::PI

// An edge projected onto a rectangle and clipped to it; the rectangle is the square from −1 to 1.
struct Projected {
    start: vec2f,
    end: vec2f,
    is_visible: bool,
}

// The range of the parameter along an edge where a linear function is not negative; the ends' values in `at`.
fn clip_range(range: vec2f, at: vec2f) -> vec2f {
    let crossing = at.x / (at.x - at.y); // used only where the signs differ
    let lower = select(range.x, max(range.x, crossing), at.x < 0.0);
    let upper = select(range.y, min(range.y, crossing), at.y < 0.0);
    return select(vec2f(lower, upper), vec2f(1.0, 0.0), at.x < 0.0 && at.y < 0.0);
}

// Sees the edge from `p`. With w the share of the way from `p` to the light's plane, an edge point projects to
// H / w; H and w are linear along the edge. Only points between `p` and the light count: 0 < w < 1.
fn project_to_rect(p: vec3f, start: vec3f, end: vec3f, half_size: vec2f) -> Projected {
    let w = (vec2f(start.z, end.z) - p.z) / -p.z;
    let a = (start.xy - p.xy * (1.0 - w.x)) / half_size;
    let b = (end.xy - p.xy * (1.0 - w.y)) / half_size;
    var range = vec2f(0.0, 1.0);
    range = clip_range(range, w - vec2f(a.x, b.x));
    range = clip_range(range, w + vec2f(a.x, b.x));
    range = clip_range(range, w - vec2f(a.y, b.y));
    range = clip_range(range, w + vec2f(a.y, b.y));
    range = clip_range(range, 1.0 - w);
    let at = max(mix(vec2f(w.x), vec2f(w.y), range), vec2f(1e-9));
    return Projected(
        clamp(mix(a, b, range.x) / at.x, vec2f(-1.0), vec2f(1.0)),
        clamp(mix(a, b, range.y) / at.y, vec2f(-1.0), vec2f(1.0)),
        range.x < range.y && p.z < 0.0,
    );
}

// Way along the border of the square from (1, 0) to where a direction leaves it, counter-clockwise; the border is 8
// long. Twice the area of the sector, since every side is 1 from the centre: no angle is needed.
fn border_place(direction: vec2f) -> f32 {
    let size = abs(direction);
    let x_side = direction.y / max(size.x, 1e-20);
    let y_side = -direction.x / max(size.y, 1e-20);
    let on_x = select(4.0 - x_side, x_side, direction.x >= 0.0);
    let on_y = select(6.0 - y_side, 2.0 + y_side, direction.y >= 0.0);
    return select(on_y, on_x, size.x >= size.y);
}

// Share of a rectangle.
fn rect_coverage(edge: Projected) -> f32 {
    let between = abs(border_place(edge.start) - border_place(edge.end));
    let sector = 0.5 * min(between, 8.0 - between);
    let triangle = 0.5 * abs(edge.start.x * edge.end.y - edge.start.y * edge.end.x);
    return select(0.0, 0.25 * max(sector - triangle, 0.0), edge.is_visible);
}

// A chord of the disc that stands for a sphere: the line's distance from the centre, and the places on it, all in radii.
struct Chord {
    distance: f32,
    start: f32,
    end: f32,
    is_visible: bool,
}

// Sees the edge from `p`, on the disc through the sphere's centre that faces `p`.
//
// The paper clips the edge at the cone by a quadratic; here the line of the projected edge is found first (the cross
// product of its homogeneous ends), so that nothing cancels where an end lies beside the receiver.
fn project_to_disc(p: vec3f, start: vec3f, end: vec3f, radius: f32) -> Chord {
    let distance = length(p);
    let axis = -p / max(distance, 1e-20);
    let across = normalize(select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(axis.x) > 0.7) - axis
        * select(axis.x, axis.y, abs(axis.x) > 0.7));
    let up = cross(axis, across);
    let from_start = start - p;
    let from_end = end - p;
    let w_start = dot(from_start, axis) / distance;
    let w_end = dot(from_end, axis) / distance;
    var a = vec3f(vec2f(dot(from_start, across), dot(from_start, up)) / radius, w_start);
    var b = vec3f(vec2f(dot(from_end, across), dot(from_end, up)) / radius, w_end);
    // Between the receiver and the disc alone.
    let least = 1e-6;
    var range = clip_range(vec2f(0.0, 1.0), vec2f(w_start, w_end) - least);
    range = clip_range(range, 1.0 - vec2f(w_start, w_end));
    let line = cross(a, b);
    let scale = inverseSqrt(max(dot(line.xy, line.xy), 1e-30));
    let normal = line.xy * scale;
    let offset = line.z * scale;
    let along = vec2f(-normal.y, normal.x);
    let half_chord = sqrt(max(1.0 - offset * offset, 0.0));
    let first = mix(a, b, range.x);
    let last = mix(a, b, range.y);
    return Chord(
        abs(offset),
        clamp(dot(first.xy, along) / max(first.z, least), -half_chord, half_chord),
        clamp(dot(last.xy, along) / max(last.z, least), -half_chord, half_chord),
        range.x < range.y && abs(offset) < 1.0,
    );
}

// Share of a disc.
fn disc_coverage(chord: Chord) -> f32 {
    let angle = abs(atan2(chord.start, chord.distance) - atan2(chord.end, chord.distance));
    let triangle = chord.distance * abs(chord.start - chord.end);
    return select(0.0, max(angle - triangle, 0.0) / (2.0 * PI), chord.is_visible);
}
