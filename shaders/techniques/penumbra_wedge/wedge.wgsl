// Wedges, separators and caps of one part of a light, blended into the visibility buffer.
// Host    src/techniques/penumbra_wedge/node.rs
// Groups  0 view, 2 wedges, 3 receiver depth
// Spaces  in: local (edges, caps) and light (rims, pieces); out: clip. Infinity is w = 0: depth 0.
#import antumbra::view::{objects, clip_position, relative_from_pixel}
#import antumbra::coverage::{Chord, Projected, border_place, project_to_rect, rect_coverage, project_to_disc, disc_coverage}

struct WedgeCaster {                // mirror: techniques::penumbra_wedge::records::WedgeCaster
    light_local: vec4f,             // w = 1: a position; w = 0: xyz points towards the light
    object: u32,
    padding: array<u32, 3>,
}

struct Wedge {                      // mirror: techniques::penumbra_wedge::records::Wedge
    start_local: vec3f,
    caster: u32,
    end_local: vec3f,
    flags: u32,                     // HARD, PIECE, SOFT; layers from bit 3 on
    start_light: vec3f,
    light: u32,
    end_light: vec3f,
    padding: u32,
    rims: array<vec4f, 12>,         // direction; w: 1 where the ray leaves from the end
}

struct WedgeLight {                 // mirror: techniques::penumbra_wedge::records::WedgeLight
    clip_from_light: mat4x4f,
    light_from_relative_x: vec4f,   // rows of the affine matrix
    light_from_relative_y: vec4f,
    light_from_relative_z: vec4f,
    half_size: vec2f,               // of a sphere: its radius twice
    table: u32,                     // first entry of the texture's tables
    padding: u32,
    place: vec4f,
}

@group(2) @binding(0) var<storage, read> casters: array<WedgeCaster>;
@group(2) @binding(1) var<storage, read> wedges: array<Wedge>;
@group(2) @binding(2) var<storage, read> lights: array<WedgeLight>;
// Angles and areas, made by lookup.rs; then for each texture sectors along the border of the square and triangles,
// shares by colour, made by texture.rs.
@group(2) @binding(3) var<storage, read> tables: array<vec4f>;
@group(3) @binding(0) var receiver_depth: texture_2d<f32>;

const HARD: u32 = 1u;
const PIECE: u32 = 2u;
const SOFT: u32 = 4u;

// The light is a sphere, else a rectangle.
override IS_SPHERE: bool = false;
// Sign of the half that is shaded: 1 for the inner half.
override HALF_SIGN: f32 = 1.0;
// Angles and areas come from tables.
override LOOKS_UP: bool = false;
// The light is a textured rectangle.
override IS_TEXTURED: bool = false;
// Layers that a cap belongs to: 1 facing, 2 averted.
override CAP_LAYERS: u32 = 3u;
// Steps of coverage in 1: sums of multiples are exact, so no order of blending shows.
override STEPS: f32 = 16384.0;

struct Corner {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) @interpolate(flat) start_light: vec3f,
    @location(1) @interpolate(flat) end_light: vec3f,
    @location(2) @interpolate(flat) light: u32,
    @location(3) @interpolate(flat) hard: f32,  // 1: bounds the hard shadow
    @location(4) @interpolate(flat) soft: f32,  // 1 in the inner half, −1 in the outer; 0 without a shell
    @location(5) @interpolate(flat) layers: u32,
}

fn far_position(caster: WedgeCaster, position_local: vec3f) -> vec4f {
    let from_light = position_local * caster.light_local.w - caster.light_local.xyz;
    return objects[caster.object].clip_from_local * vec4f(from_light, 0.0);
}

// Vertices as topology.rs names them.
@vertex
fn wedge_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    let wedge = wedges[instance];
    let caster = casters[wedge.caster];
    let clip_from_light = lights[wedge.light].clip_from_light;
    let rim_index = select(0u, (vertex - 4u) % 12u, vertex >= 4u);
    let rim = wedge.rims[rim_index];
    let is_end = select(vertex == 1u || vertex == 3u, rim.w > 0.5, vertex >= 4u);
    let position_local = select(wedge.start_local, wedge.end_local, is_end);
    let position_light = select(wedge.start_light, wedge.end_light, is_end);
    let is_piece = (wedge.flags & PIECE) != 0u;
    let is_soft = (wedge.flags & SOFT) != 0u;
    let near = select(clip_position(caster.object, position_local), clip_from_light * vec4f(position_light, 1.0), is_piece);
    let far = select(far_position(caster, position_local), clip_from_light * vec4f(position_light, 0.0), is_piece);
    let ray = clip_from_light * vec4f(rim.xyz, 0.0);
    var out: Corner;
    let is_far = vertex == 2u || vertex == 3u;
    let is_ray = vertex >= 4u && vertex < 16u && is_soft;
    out.position_clip = select(select(near, far, is_far), ray, is_ray);
    out.start_light = wedge.start_light;
    out.end_light = wedge.end_light;
    out.light = wedge.light;
    out.hard = select(0.0, f32(wedge.flags & HARD), vertex < 4u);
    out.soft = select(0.0, select(-1.0, 1.0, rim_index >= 6u), is_soft);
    out.layers = wedge.flags >> 3u;
    return out;
}

@vertex
fn near_cap(@location(0) position_local: vec3f, @builtin(instance_index) instance: u32)
    -> @builtin(position) @invariant vec4f {
    return clip_position(casters[instance].object, position_local);
}

@vertex
fn far_cap(@location(0) position_local: vec3f, @builtin(instance_index) instance: u32)
    -> @builtin(position) @invariant vec4f {
    return far_position(casters[instance], position_local);
}

const ANGLE_STEPS: u32 = 1024u;
const SECTOR_STEPS: u32 = 256u;

// Turns, 0..1.
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

fn table_disc_coverage(chord: Chord) -> f32 {
    // The places of the chord, a quarter turn on: so that no angle is beyond a turn.
    let angle = abs(table_angle(vec2f(-chord.start, chord.distance)) - table_angle(vec2f(-chord.end, chord.distance)));
    let triangle = chord.distance * abs(chord.start - chord.end) * 0.15915494;
    return select(0.0, max(angle - triangle, 0.0), chord.is_visible);
}

const BORDER_STEPS: f32 = 256.0;
const NODES: u32 = 16u;

// The texture's integral from the border's start to a place on it.
fn sector_to(table: u32, place: f32) -> vec3f {
    let at = clamp((place - 8.0 * floor(place / 8.0)) * (BORDER_STEPS / 8.0), 0.0, BORDER_STEPS);
    let first = min(u32(at), u32(BORDER_STEPS) - 1u);
    return mix(tables[table + first].rgb, tables[table + first + 1u].rgb, at - f32(first));
}

// Interpolated along one end of the edge at a node of the other.
fn triangle_at(table: u32, node: u32, corner: vec2u, share: vec2f) -> vec3f {
    let first = table + u32(BORDER_STEPS) + 1u + node * NODES * NODES + corner.y * NODES + corner.x;
    let low = mix(tables[first].rgb, tables[first + 1u].rgb, share.x);
    let high = mix(tables[first + NODES].rgb, tables[first + NODES + 1u].rgb, share.x);
    return mix(low, high, share.y);
}

// By colour: the sector between the ends, counter-clockwise, less the triangle. A lookup in four dimensions.
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

// Share of the part that lies behind the edge, at the surface that the pixel shows.
fn coverage(in: Corner) -> vec4f {
    let pixel = in.position_clip.xy;
    let depth = textureLoad(receiver_depth, vec2u(pixel), 0).r;
    let relative = vec4f(relative_from_pixel(pixel, max(depth, 1e-30)), 1.0);
    let light = lights[in.light];
    let p = vec3f(
        dot(light.light_from_relative_x, relative),
        dot(light.light_from_relative_y, relative),
        dot(light.light_from_relative_z, relative),
    );
    var share = vec4f(0.0);
    if IS_SPHERE {
        let chord = project_to_disc(p, in.start_light, in.end_light, light.half_size.x);
        if LOOKS_UP {
            share = vec4f(table_disc_coverage(chord));
        } else {
            share = vec4f(disc_coverage(chord));
        }
    } else {
        let edge = project_to_rect(p, in.start_light, in.end_light, light.half_size);
        if LOOKS_UP {
            share = vec4f(table_rect_coverage(edge));
        } else {
            share = vec4f(rect_coverage(edge));
        }
        if IS_TEXTURED {
            share = vec4f(textured_coverage(light.table, edge), share.a);
        }
    }
    // Also against NaN, which compares to nothing.
    let is_usable = share.a > 0.0 && share.a < 1.0 && depth > 0.0 && in.soft != 0.0;
    return select(vec4f(0.0), round(min(share, vec4f(1.0)) * STEPS) / STEPS, is_usable);
}

// What the faces add. Behind the surface, outside of it: the front of a hard shadow's face gives back 1 to visibility,
// its back takes 1.
fn shell_value(in: Corner) -> vec4f {
    return in.soft * coverage(in);
}

fn separator_value(in: Corner, front_facing: bool) -> vec4f {
    return (2.0 * coverage(in) - in.hard) * select(1.0, -1.0, front_facing);
}

fn hard_value(in: Corner, front_facing: bool) -> vec4f {
    return vec4f(in.hard * select(-1.0, 1.0, front_facing));
}

fn cap_value(front_facing: bool) -> vec4f {
    return vec4f(select(-1.0, 1.0, front_facing));
}

// A sum a layer; the layers that a face belongs to.
struct Layers {
    @location(0) facing: vec4f,
    @location(1) averted: vec4f,
}

fn layered(value: vec4f, layers: u32) -> Layers {
    return Layers(value * f32(layers & 1u), value * f32(layers >> 1u));
}

@fragment
fn shell(in: Corner) -> Layers {
    return layered(shell_value(in), in.layers);
}

@fragment
fn separator(in: Corner, @builtin(front_facing) front_facing: bool) -> Layers {
    return layered(separator_value(in, front_facing), in.layers);
}

@fragment
fn hard_side(in: Corner, @builtin(front_facing) front_facing: bool) -> Layers {
    return layered(hard_value(in, front_facing), in.layers);
}

@fragment
fn half(in: Corner) -> Layers {
    return layered(HALF_SIGN * coverage(in), in.layers);
}

@fragment
fn cap(@builtin(front_facing) front_facing: bool) -> Layers {
    return layered(cap_value(front_facing), CAP_LAYERS);
}

// Twelve bits over four bytes, three in each; the upper five are for carries. What adds and what subtracts are apart.
struct Split {
    @location(0) facing_added: vec4f,
    @location(1) facing_subtracted: vec4f,
    @location(2) averted_added: vec4f,
    @location(3) averted_subtracted: vec4f,
}

fn split(value: f32, layers: u32) -> Split {
    let steps = u32(round(abs(value) * 4096.0));
    let digits = vec4f(vec4u(steps >> 9u, (steps >> 6u) & 7u, (steps >> 3u) & 7u, steps & 7u)) / 255.0;
    let added = select(vec4f(0.0), digits, value > 0.0);
    let subtracted = select(vec4f(0.0), digits, value < 0.0);
    let facing = f32(layers & 1u);
    let averted = f32(layers >> 1u);
    return Split(added * facing, subtracted * facing, added * averted, subtracted * averted);
}

@fragment
fn shell_split(in: Corner) -> Split {
    return split(shell_value(in).r, in.layers);
}

@fragment
fn separator_split(in: Corner, @builtin(front_facing) front_facing: bool) -> Split {
    return split(separator_value(in, front_facing).r, in.layers);
}

@fragment
fn hard_side_split(in: Corner, @builtin(front_facing) front_facing: bool) -> Split {
    return split(hard_value(in, front_facing).r, in.layers);
}

@fragment
fn half_split(in: Corner) -> Split {
    return split(HALF_SIGN * coverage(in).r, in.layers);
}

@fragment
fn cap_split(@builtin(front_facing) front_facing: bool) -> Split {
    return split(cap_value(front_facing).r, CAP_LAYERS);
}

@fragment
fn debug(in: Corner, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    return select(vec4f(0.02, 0.0, 0.02, 0.0), vec4f(0.0, 0.02, 0.02, 0.0), in.soft > 0.0)
        * select(0.5, 1.0, front_facing);
}
