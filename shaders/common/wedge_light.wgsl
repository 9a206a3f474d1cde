// A part of a light, for wedges and their resolve: where the receiver is, which part lies above the
// receiver's horizon, and which part lies behind an edge.
// Host    src/techniques/penumbra_wedge/{geometry/records,gpu/plans,tables/lookup,tables/texture}.rs
// Groups  2 wedges
// Spaces  light: origin at the part's centre; places on the light: the square from −1 to 1, or the unit disc
#define_import_path antumbra::wedge_light

#import antumbra::coverage::{Projected, Seen, border_place, part_of, chord_of}
#import antumbra::coverage::{see_on_rect, project_to_rect, rect_coverage, see_on_disc, project_to_disc, disc_coverage, disc_frame}
#import antumbra::receiver::Receiver

struct WedgeLight {                 // mirror: techniques::penumbra_wedge::geometry::records::WedgeLight
    clip_from_light: mat4x4f,
    light_from_relative_x: vec4f,   // rows of the affine matrix
    light_from_relative_y: vec4f,
    light_from_relative_z: vec4f,
    half_size: vec2f,               // of a rectangle; a sphere has its radius twice
    table: u32,                     // first entry of the texture's tables
    reach: f32,                     // metres at which rays of shells end; 0: at infinity
    place: vec4f,                   // centre and half size within the whole light, which spans −1 to 1
    whole: vec4f,                   // centre of the whole light; w: radius of a whole sphere
}

// The part that is drawn. A uniform, because a storage array with an index would be read again by each
// fragment.
@group(2) @binding(2) var<uniform> light: WedgeLight;
// First angles and areas, made by lookup.rs. Then, for each texture, sectors along the border of the square
// and triangles, as shares by colour, made by texture.rs.
@group(2) @binding(3) var<storage, read> tables: array<vec4f>;

// How shares are computed.
struct Maths {
    is_sphere: bool,
    looks_up: bool,                 // angles and areas come from tables
    is_textured: bool,
}

const ANGLE_STEPS: u32 = 1024u;     // mirror: techniques::penumbra_wedge::tables::lookup::ANGLE_STEPS
const SECTOR_STEPS: u32 = 256u;     // mirror: techniques::penumbra_wedge::tables::lookup::SECTOR_STEPS

// Angle of a direction from the table, in turns, 0..1.
fn table_angle(direction: vec2f) -> f32 {
    let size = abs(direction);
    let at = clamp(size.y / max(size.x + size.y, 1e-20), 0.0, 1.0) * f32(ANGLE_STEPS);
    let first = min(u32(at), ANGLE_STEPS - 1u);
    let quarter = mix(tables[first].r, tables[first + 1u].r, at - f32(first));
    let half_turn = select(quarter, 0.5 - quarter, direction.x < 0.0);
    return select(half_turn, 1.0 - half_turn, direction.y < 0.0);
}

fn table_rect_coverage(edge: Projected) -> f32 {
    let at = clamp(vec2f(table_angle(edge.start), table_angle(edge.end)), vec2f(0.0), vec2f(1.0)) * f32(SECTOR_STEPS);
    let cell = min(vec2u(at), vec2u(SECTOR_STEPS - 1u));
    let share = at - vec2f(cell);
    let first = ANGLE_STEPS + 1u + cell.x * (SECTOR_STEPS + 1u) + cell.y;
    let low = mix(tables[first].r, tables[first + 1u].r, share.y);
    let next = first + SECTOR_STEPS + 1u;
    let high = mix(tables[next].r, tables[next + 1u].r, share.y);
    let triangle = 0.125 * abs(edge.start.x * edge.end.y - edge.start.y * edge.end.x);
    return select(0.0, max(mix(low, high, share.x) - triangle, 0.0), edge.is_visible);
}

fn table_disc_coverage(edge: Projected) -> f32 {
    let between = abs(table_angle(edge.start) - table_angle(edge.end));
    let triangle = abs(edge.start.x * edge.end.y - edge.start.y * edge.end.x) * 0.15915494;
    return select(0.0, max(min(between, 1.0 - between) - triangle, 0.0), edge.is_visible);
}

const BORDER_STEPS: f32 = 256.0;    // mirror: techniques::penumbra_wedge::tables::texture::BORDER_STEPS
const NODES: u32 = 16u;             // mirror: techniques::penumbra_wedge::tables::texture::NODES

// The texture's integral over the sector from the border's start to a place on it.
fn sector_to(table: u32, place: f32) -> vec3f {
    let at = clamp((place - 8.0 * floor(place / 8.0)) * (BORDER_STEPS / 8.0), 0.0, BORDER_STEPS);
    let first = min(u32(at), u32(BORDER_STEPS) - 1u);
    return mix(tables[table + first].rgb, tables[table + first + 1u].rgb, at - f32(first));
}

// The table of triangles, interpolated along one end of the edge at a node of the other end.
fn triangle_at(table: u32, node: u32, corner: vec2u, share: vec2f) -> vec3f {
    let first = table + u32(BORDER_STEPS) + 1u + node * NODES * NODES + corner.y * NODES + corner.x;
    let low = mix(tables[first].rgb, tables[first + 1u].rgb, share.x);
    let high = mix(tables[first + NODES].rgb, tables[first + NODES + 1u].rgb, share.x);
    return mix(low, high, share.y);
}

// Coverage by colour: the sector between the ends, counter-clockwise, less the triangle. It is a lookup in
// four dimensions.
fn textured_coverage(table: u32, edge: Projected) -> vec3f {
    let turn = edge.start.x * edge.end.y - edge.start.y * edge.end.x;
    let start = select(edge.end, edge.start, turn >= 0.0);
    let end = select(edge.start, edge.end, turn >= 0.0);
    let from_place = border_place(start);
    let to_place = border_place(end);
    let low = sector_to(table, from_place);
    let high = sector_to(table, to_place);
    let turns = (to_place - 8.0 * floor(to_place / 8.0)) < (from_place - 8.0 * floor(from_place / 8.0));
    let sector = high - low + select(0.0, 1.0, turns);
    let last = f32(NODES - 1u);
    let start_at = (start * 0.5 + 0.5) * last;
    let end_at = (end * 0.5 + 0.5) * last;
    let start_cell = min(vec2u(start_at), vec2u(NODES - 2u));
    let end_cell = min(vec2u(end_at), vec2u(NODES - 2u));
    let start_share = start_at - vec2f(start_cell);
    let end_share = end_at - vec2f(end_cell);
    let node = end_cell.y * NODES + end_cell.x;
    let lower = mix(
        triangle_at(table, node, start_cell, start_share),
        triangle_at(table, node + 1u, start_cell, start_share),
        end_share.x,
    );
    let upper = mix(
        triangle_at(table, node + NODES, start_cell, start_share),
        triangle_at(table, node + NODES + 1u, start_cell, start_share),
        end_share.x,
    );
    return max(sector - mix(lower, upper, end_share.y), vec3f(0.0));
}

// The position of a receiver relative to a light.
struct Seat {
    p: vec3f,                       // light space
    horizon: vec3f,                 // dot(xy, place) + z, negative for places below the horizon
    is_there: bool,
}

fn in_light(position_relative: vec3f) -> vec3f {
    let relative = vec4f(position_relative, 1.0);
    return vec3f(
        dot(light.light_from_relative_x, relative),
        dot(light.light_from_relative_y, relative),
        dot(light.light_from_relative_z, relative),
    );
}

fn direction_in_light(direction: vec3f) -> vec3f {
    return vec3f(
        dot(light.light_from_relative_x.xyz, direction),
        dot(light.light_from_relative_y.xyz, direction),
        dot(light.light_from_relative_z.xyz, direction),
    );
}

// Moves a receiver into the plane of its own triangle; the rasterizer moves it off by up to 1/512 of a pixel.
// Edges near the receiver are then where the mesh has them.
fn in_plane(receiver: Receiver) -> vec3f {
    return receiver.position + receiver.normal * (receiver.offset - dot(receiver.normal, receiver.position));
}

// Seat of a receiver for a light of this extent around `center`.
fn seat_at(receiver: Receiver, center: vec3f, half_size: vec2f, is_sphere: bool) -> Seat {
    let position_light = in_light(in_plane(receiver)) - center;
    let normal_light = direction_in_light(receiver.normal);
    let frame = disc_frame(position_light);
    let on_disc = vec2f(dot(normal_light, frame.across), dot(normal_light, frame.up));
    let tilt = select(normal_light.xy, on_disc, is_sphere) * half_size;
    // A point has no part below the horizon, and nothing is cut where no plane is known.
    let is_known = dot(normal_light, normal_light) > 0.5 && half_size.x > 0.0;
    let horizon = vec3f(tilt, -dot(normal_light, position_light));
    return Seat(position_light, select(vec3f(0.0, 0.0, 1.0), horizon, is_known), receiver.depth > 0.0);
}

fn seat(receiver: Receiver, is_sphere: bool) -> Seat {
    return seat_at(receiver, vec3f(0.0), light.half_size, is_sphere);
}

// Share of the light that lies behind an edge as seen from the centre: rgb by colour, a by area.
fn behind(edge: Projected, maths: Maths) -> vec4f {
    var area = 0.0;
    if maths.is_sphere {
        if maths.looks_up {
            area = table_disc_coverage(edge);
        } else {
            area = disc_coverage(edge);
        }
    } else if maths.looks_up {
        area = table_rect_coverage(edge);
    } else {
        area = rect_coverage(edge);
    }
    var share = vec4f(area);
    if maths.is_textured && edge.is_visible {
        share = vec4f(textured_coverage(light.table, edge), area);
    }
    return share;
}

// 1: the whole part is above the horizon; −1: the whole part is below; 0: the horizon cuts it.
fn side_of(horizon: vec3f, is_sphere: bool) -> i32 {
    let reach = select(abs(horizon.x) + abs(horizon.y), length(horizon.xy), is_sphere);
    return select(select(0, -1, horizon.z <= -reach), 1, horizon.z >= reach);
}

// Share of the part that lies above the horizon.
fn above(horizon: vec3f, maths: Maths) -> vec4f {
    let side = side_of(horizon, maths.is_sphere);
    var share = vec4f(select(0.0, 1.0, side > 0));
    if side == 0 {
        let none = Projected(vec2f(0.0), vec2f(0.0), false);
        let beyond = behind(chord_of(horizon, maths.is_sphere, none, true), maths);
        share = select(beyond, 1.0 - beyond, horizon.z >= 0.0);
    }
    return share;
}

fn see(p: vec3f, start: vec3f, end: vec3f, is_sphere: bool) -> Seen {
    if is_sphere {
        return see_on_disc(p, start, end, light.half_size.x);
    }
    return see_on_rect(p, start, end, light.half_size);
}

// Whether an edge passes beside the light: its line does, or both ends lie beyond one side.
fn misses(seen: Seen, is_sphere: bool) -> bool {
    let a = seen.first;
    let b = seen.last;
    let line = cross(a, b);
    let reach = select(abs(line.x) + abs(line.y), length(line.xy), is_sphere);
    let is_beyond = (a.xy > a.zz & b.xy > b.zz) | (a.xy < -a.zz & b.xy < -b.zz);
    return !(seen.is_there && abs(line.z) < reach) || any(is_beyond);
}

// Share of the part that lies above the horizon and behind an edge.
//
// As seen from the centre, the horizon is an edge too. If the centre is above it, the part behind the horizon
// is subtracted from the part behind the edge. If the centre is below it, the part above lies behind the
// horizon. Where the edge is nearer to the centre than the horizon, that whole part counts; elsewhere, what
// lies behind the edge counts.
fn covered(horizon: vec3f, seen: Seen, maths: Maths) -> vec4f {
    var edge: Projected;
    if maths.is_sphere {
        edge = project_to_disc(seen);
    } else {
        edge = project_to_rect(seen);
    }
    let side = side_of(horizon, maths.is_sphere);
    var share = vec4f(0.0);
    if side > 0 {
        share = behind(edge, maths);
    } else if side == 0 && edge.is_visible {
        let at_start = dot(horizon.xy, edge.start) + horizon.z;
        let at_end = dot(horizon.xy, edge.end) + horizon.z;
        let over = part_of(edge, at_start, at_end);
        let is_over = horizon.z >= 0.0;
        var near = part_of(edge, -at_start, -at_end);
        if is_over {
            near = over;
        }
        let beyond = behind(chord_of(horizon, maths.is_sphere, near, false), maths);
        let behind_edge = behind(over, maths);
        share = select(behind_edge + beyond, max(behind_edge - beyond, vec4f(0.0)), is_over);
    }
    return share;
}
