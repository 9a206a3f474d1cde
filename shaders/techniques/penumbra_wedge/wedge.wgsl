// Wedges, separators and caps of one part of a light, blended into the visibility buffer.
// Host    src/techniques/penumbra_wedge/gpu/recorder.rs
// Groups  0 view, 1 receiver, 2 wedges
// Spaces  in: local (edges, caps) and light (rims, pieces); out: clip
//         Infinity is w = 0, depth 0. In orthographic views everything ends before it.
#import antumbra::view::{objects, clip_position}
#import antumbra::receiver::{Receiver, receiver_at}
#import antumbra::cut_surface::{cut_polygon, polygon_share, polygon_places}
#import antumbra::light_places::{Sampling, places_behind, PLACE_STEPS}
#import antumbra::wedge_faces::{faces, foot_of}
#import antumbra::wedge_light::{light, Maths, in_light, in_plane, seat, see, misses, above, covered}
#import antumbra::wedge_sums::{Layers, Targets, Value, Split, NOTHING, DIGITS, HARD_SHADOW, DEEP_HARD_SHADOW, doubled_less, is_nothing, layered, scaled, split, times}

struct WedgeCaster {                // mirror: techniques::penumbra_wedge::geometry::records::WedgeCaster
    light_local: vec4f,             // w = 1: a position; w = 0: xyz points towards the light
    end_local: vec4f,               // plane where rays end, local: dot(xyz, p) = w; xyz = 0: infinity
    end_light: vec4f,               // the same plane, light space
    object: u32,
    extrusion: f32,                 // factor on the distance, or metres if directional; 0: to the end
    padding: array<u32, 2>,
}

struct Wedge {                      // mirror: techniques::penumbra_wedge::geometry::records::Wedge
    start_local: vec3f,
    caster: u32,
    end_local: vec3f,
    flags: u32,                     // HARD, PIECE, SOFT; hard layers from bit 3 on, soft layers from bit 5 on, ONLY_*, CLOSED, CUT
    start_light: vec3f,
    padding_a: u32,
    end_light: vec3f,
    padding_b: u32,
    rims: array<vec4f, 12>,         // xyz: direction; w: 1 where the ray leaves from the edge's end, else 0
    sides: array<vec4f, 2>,         // planes of the triangles beside the edge, light space
}

@group(2) @binding(0) var<storage, read> casters: array<WedgeCaster>;
@group(2) @binding(1) var<storage, read> wedges: array<Wedge>;

const HARD: u32 = 1u;               // mirror: techniques::penumbra_wedge::geometry::records::HARD
const PIECE: u32 = 2u;              // mirror: techniques::penumbra_wedge::geometry::records::PIECE
const SOFT: u32 = 4u;               // mirror: techniques::penumbra_wedge::geometry::records::SOFT
// The whole shell is in this half, without a separator.
const ONLY_OUTER: u32 = 128u;       // mirror: techniques::penumbra_wedge::geometry::records::ONLY_OUTER
const ONLY_INNER: u32 = 256u;       // mirror: techniques::penumbra_wedge::geometry::records::ONLY_INNER
// Both layers are the averted triangles.
const CLOSED: u32 = 512u;           // mirror: techniques::penumbra_wedge::geometry::records::CLOSED
// A polygon that cuts the light; its corners are the start, the end and the first two rims.
const CUT: u32 = 1024u;             // mirror: techniques::penumbra_wedge::geometry::records::CUT
const LAYERS_SHIFT: u32 = 3u;       // mirror: techniques::penumbra_wedge::geometry::records::LAYERS_SHIFT
const SOFT_LAYERS_SHIFT: u32 = 5u;  // mirror: techniques::penumbra_wedge::geometry::records::SOFT_LAYERS_SHIFT

// Vertices of a wedge after its start, and the number of rim points of a half.
const END: u32 = 1u;                // mirror: techniques::penumbra_wedge::geometry::topology::END
const FAR_START: u32 = 2u;          // mirror: techniques::penumbra_wedge::geometry::topology::FAR_START
const FAR_END: u32 = 3u;            // mirror: techniques::penumbra_wedge::geometry::topology::FAR_END
const FIRST_RIM: u32 = 4u;          // mirror: techniques::penumbra_wedge::geometry::topology::FIRST_RIM
const FIRST_APEX: u32 = 16u;        // mirror: techniques::penumbra_wedge::geometry::topology::FIRST_APEX
const RIM: u32 = 6u;                // mirror: techniques::penumbra_wedge::geometry::shell::RIM

// The light is a sphere; otherwise it is a rectangle.
override IS_SPHERE: bool = false;
// Sign of the half that is shaded: 1 for the inner half, −1 for the outer.
override HALF_SIGN: f32 = 1.0;
// −1 where faces in front of the surface count instead of those behind it.
override FACE_SIGN: f32 = 1.0;
// Angles and areas come from tables.
override LOOKS_UP: bool = false;
// The light is a textured rectangle.
override IS_TEXTURED: bool = false;
// Layers to which a cap belongs. Bit 0: facing; bit 1: averted.
override CAP_LAYERS: u32 = 3u;
// Number of coverage steps in 1. Sums of their multiples are exact, so the order of blending does not show.
override STEPS: f32 = 16384.0;
// Besides the share, hard shadows and places on the light are counted.
override IS_SAMPLED: bool = false;
// Twenty-one places are counted instead of nine, in one more texture for each layer.
override IS_DENSE: bool = false;
// More casters may lie one behind the other than the digits of places have room for in steps, so places are
// either hidden or not.
override IS_DEEP: bool = false;

// Polygons that cut the light are drawn. Otherwise their fragments are discarded.
override DRAWS_CUTS: bool = false;

struct Corner {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) @interpolate(flat) start_light: vec3f,
    @location(1) @interpolate(flat) end_light: vec3f,
    @location(2) @interpolate(flat) hard: f32,  // 1: bounds the hard shadow
    @location(3) @interpolate(flat) soft: f32,  // 1 in the inner half, −1 in the outer; 0 without a shell
    @location(4) @interpolate(flat) flags: u32,
    @location(5) @interpolate(flat) side: vec4f,
    @location(6) @interpolate(flat) other_side: vec4f,
    @location(7) @interpolate(flat) third_light: vec3f, // third corner of a polygon that cuts the light
    @location(8) @interpolate(flat) fourth_light: vec3f, // its fourth corner
}

// The homogeneous point where a ray meets the plane at which it ends; at infinity without a plane.
fn end_of(plane: vec4f, start: vec3f, direction: vec3f) -> vec4f {
    let along = dot(plane.xyz, direction);
    return vec4f(start * along + direction * (plane.w - dot(plane.xyz, start)), along);
}

fn far_position(caster: WedgeCaster, position_local: vec3f) -> vec4f {
    let from_light = position_local * caster.light_local.w - caster.light_local.xyz;
    let base = caster.light_local.xyz * caster.light_local.w + position_local * (1.0 - caster.light_local.w);
    let pushed = vec4f(base + from_light * caster.extrusion, 1.0);
    let far = select(end_of(caster.end_local, position_local, from_light), pushed, caster.extrusion > 0.0);
    return objects[caster.object].clip_from_local * far;
}

// Vertices are numbered as in topology.rs.
@vertex
fn wedge_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    return wedge_corner(vertex, instance);
}

fn wedge_corner(vertex: u32, instance: u32) -> Corner {
    // Fields are read one by one, because a copy of the record would copy all its rims.
    let caster = casters[wedges[instance].caster];
    let flags = wedges[instance].flags;
    let clip_from_light = light.clip_from_light;
    let only = flags & (ONLY_OUTER | ONLY_INNER);
    let is_far = vertex == FAR_START || vertex == FAR_END;
    // Without a separator, the far ends of the rays that both rims share replace its far ends.
    let shared_ray = select(0u, RIM - 1u, vertex == FAR_END);
    let rim_index = select(shared_ray, (vertex - FIRST_RIM) % (2u * RIM), vertex >= FIRST_RIM);
    let rim = wedges[instance].rims[rim_index];
    let start_light = wedges[instance].start_light;
    let end_light = wedges[instance].end_light;
    let is_shared = is_far && only != 0u;
    let is_end = select(vertex == END || vertex == FAR_END, rim.w > 0.5, vertex >= FIRST_RIM || is_shared);
    let position_local = select(wedges[instance].start_local, wedges[instance].end_local, is_end);
    let position_light = select(start_light, end_light, is_end);
    let is_piece = (flags & PIECE) != 0u;
    let is_soft = (flags & SOFT) != 0u;
    let near = select(clip_position(caster.object, position_local), clip_from_light * vec4f(position_light, 1.0), is_piece);
    let is_finite = light.reach > 0.0;
    let away = vec4f(normalize(position_light) * light.reach, 1.0);
    let far_piece = select(end_of(caster.end_light, position_light, position_light), away, is_finite);
    let far = select(far_position(caster, position_local), clip_from_light * far_piece, is_piece);
    let along_ray = vec4f(position_light + rim.xyz * light.reach, 1.0);
    let ray = clip_from_light * select(end_of(caster.end_light, position_light, rim.xyz), along_ray, is_finite);
    var out: Corner;
    let is_ray = ((vertex >= FIRST_RIM && vertex < FIRST_APEX) || is_shared) && is_soft;
    out.position_clip = select(select(near, far, is_far), ray, is_ray);
    out.start_light = start_light;
    out.end_light = end_light;
    out.hard = select(0.0, f32(flags & HARD), vertex < FIRST_RIM);
    let is_inner = (rim_index >= RIM || only == ONLY_INNER) && only != ONLY_OUTER;
    out.soft = select(0.0, select(-1.0, 1.0, is_inner), is_soft);
    out.flags = flags;
    out.side = wedges[instance].sides[0];
    out.other_side = wedges[instance].sides[1];
    if (flags & CUT) != 0u {
        out.position_clip = over_all(vertex);
        out.third_light = wedges[instance].rims[0].xyz;
        out.fourth_light = wedges[instance].rims[1].xyz;
        out.soft = -1.0; // it hides
        out.hard = 0.0;
    }
    return out;
}

// Vertices of two triangles over the whole picture, at infinity. They are one triangle seen from both sides, of which
// culling leaves one. All other triangles of the shell are degenerate.
fn over_all(vertex: u32) -> vec4f {
    let corner = select(0u, vertex + 1u - FIRST_RIM, vertex == FIRST_RIM || vertex == FIRST_RIM + 1u);
    return vec4f(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Vertices of the separator; all in one point, which draws nothing, where there is no separator.
@vertex
fn separator_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    var out = wedge_corner(vertex, instance);
    if (wedges[instance].flags & (ONLY_OUTER | ONLY_INNER | CUT)) != 0u {
        out.position_clip = vec4f(0.0, 0.0, 0.0, 1.0);
    }
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

// Value of a whole hard shadow: a count in sampled sums, otherwise the share of the part above the horizon.
fn whole(pixel: vec2f) -> vec4f {
    if IS_SAMPLED {
        return vec4f(select(HARD_SHADOW, DEEP_HARD_SHADOW, IS_DEEP), 0.0, 0.0, 0.0);
    }
    let own_seat = seat(receiver_at(pixel), IS_SPHERE);
    return rounded(above(own_seat.horizon, Maths(IS_SPHERE, LOOKS_UP, IS_TEXTURED)));
}

fn rounded(share: vec4f) -> vec4f {
    return round(clamp(share, vec4f(0.0), vec4f(1.0)) * STEPS) / STEPS;
}

fn targets(value: Layers) -> Targets {
    if IS_DENSE {
        return Targets(value.facing.sums, value.facing.more, value.averted.sums, value.averted.more);
    }
    return Targets(value.facing.sums, value.averted.sums, vec4f(0.0), vec4f(0.0));
}

// Coverage of an edge at the surface that the pixel shows: the share of the part behind the edge, with the
// places if sampled, times the multiplicity with which the edge is a silhouette edge from there.
//
// The surface of most fragments is not in the wedge, although the wedge's back is behind it, so that is
// tested first.
fn coverage(in: Corner) -> Layers {
    let receiver = receiver_at(in.position_clip.xy);
    let position_light = in_light(in_plane(receiver));
    if (in.flags & CUT) != 0u {
        return cut_coverage(in, receiver, position_light);
    }
    let seen = see(position_light, in.start_light, in.end_light, IS_SPHERE);
    if in.soft == 0.0 || receiver.depth <= 0.0 || misses(seen, IS_SPHERE) {
        return NOTHING;
    }
    let foot = foot_of(receiver, position_light);
    let by_layer = faces(in.side, foot) - faces(in.other_side, foot);
    let is_closed = (in.flags & CLOSED) != 0u;
    let factors = select(by_layer, by_layer.yy, is_closed) * vec2f(f32(in.flags >> SOFT_LAYERS_SHIFT & 1u), f32(in.flags >> (SOFT_LAYERS_SHIFT + 1u) & 1u));
    if all(factors == vec2f(0.0)) {
        return NOTHING;
    }
    let own_seat = seat(receiver, IS_SPHERE);
    let share = covered(own_seat.horizon, seen, Maths(IS_SPHERE, LOOKS_UP, IS_TEXTURED));
    // The comparisons also reject NaN.
    let is_usable = share.a >= 0.0 && share.a < 1.0;
    if !is_usable {
        return NOTHING;
    }
    var value = Value(rounded(share), vec4f(0.0));
    if IS_SAMPLED {
        let sampling = Sampling(IS_SPHERE, IS_DENSE, select(PLACE_STEPS, 1.0, IS_DEEP));
        let places = places_behind(seen, sampling);
        value = Value(vec4f(value.sums.a, DIGITS * places.first), DIGITS * places.more);
    }
    return Layers(times(value, factors.x), times(value, factors.y));
}

// Coverage of a polygon that cuts the light, in the layer to which it belongs as seen from the surface. It hides nothing
// from points in its own plane, nor from those of the surface for which it stands.
fn cut_coverage(in: Corner, receiver: Receiver, position_light: vec3f) -> Layers {
    let foot = foot_of(receiver, position_light);
    let height = dot(in.side.xyz, position_light) + in.side.w;
    if receiver.depth <= 0.0 || abs(height) < foot.rounding + in.other_side.x {
        return NOTHING;
    }
    let corners = array<vec3f, 4>(in.start_light, in.end_light, in.third_light, in.fourth_light);
    let polygon = cut_polygon(position_light, height, in.side, corners, in.other_side.y, IS_SPHERE);
    if polygon.count < 3u {
        return NOTHING;
    }
    let own_seat = seat(receiver, IS_SPHERE);
    let share = polygon_share(polygon, own_seat.horizon, Maths(IS_SPHERE, LOOKS_UP, IS_TEXTURED));
    var value = Value(round(share * STEPS) / STEPS, vec4f(0.0));
    if IS_SAMPLED {
        let places = polygon_places(polygon, Sampling(IS_SPHERE, IS_DENSE, select(PLACE_STEPS, 1.0, IS_DEEP)));
        value = Value(vec4f(value.sums.a, DIGITS * places.first), DIGITS * places.more);
    }
    let is_front = f32(height < 0.0);
    return Layers(times(value, is_front), times(value, 1.0 - is_front));
}

// Values that the faces add. Behind the surface, the front of a hard shadow's face adds 1 to visibility and
// its back subtracts 1. In front of the surface it is the other way round.
fn shell_value(in: Corner) -> Layers {
    return scaled(coverage(in), in.soft);
}

fn separator_value(in: Corner, front_facing: bool) -> Layers {
    let hard = layered(select(vec4f(0.0), whole(in.position_clip.xy), in.hard > 0.0), in.flags >> LAYERS_SHIFT);
    let soft = coverage(in);
    let sum = Layers(doubled_less(soft.facing, hard.facing), doubled_less(soft.averted, hard.averted));
    return scaled(sum, FACE_SIGN * select(1.0, -1.0, front_facing));
}

fn is_left_out(in: Corner) -> bool {
    return (in.flags & CUT) != 0u && !DRAWS_CUTS;
}

fn hard_value(in: Corner, front_facing: bool) -> Layers {
    return layered(in.hard * whole(in.position_clip.xy) * (FACE_SIGN * select(-1.0, 1.0, front_facing)), in.flags >> LAYERS_SHIFT);
}

fn cap_value(position: vec4f, front_facing: bool) -> Layers {
    return layered(whole(position.xy) * select(-1.0, 1.0, front_facing), CAP_LAYERS);
}

// Discards fragments that add nothing, which saves the blending.
@fragment
fn shell(in: Corner) -> Targets {
    let value = shell_value(in);
    if is_nothing(value) {
        discard;
    }
    return targets(value);
}

@fragment
fn separator(in: Corner, @builtin(front_facing) front_facing: bool) -> Targets {
    let value = separator_value(in, front_facing);
    if is_nothing(value) {
        discard;
    }
    return targets(value);
}

@fragment
fn hard_side(in: Corner, @builtin(front_facing) front_facing: bool) -> Targets {
    if is_left_out(in) {
        discard;
    }
    return targets(hard_value(in, front_facing));
}

@fragment
fn half(in: Corner) -> Targets {
    return targets(scaled(coverage(in), HALF_SIGN));
}

@fragment
fn cap(@builtin(position) position: vec4f, @builtin(front_facing) front_facing: bool) -> Targets {
    return targets(cap_value(position, front_facing));
}

@fragment
fn shell_split(in: Corner) -> Split {
    return split(shell_value(in));
}

@fragment
fn separator_split(in: Corner, @builtin(front_facing) front_facing: bool) -> Split {
    return split(separator_value(in, front_facing));
}

@fragment
fn hard_side_split(in: Corner, @builtin(front_facing) front_facing: bool) -> Split {
    if is_left_out(in) {
        discard;
    }
    return split(hard_value(in, front_facing));
}

@fragment
fn half_split(in: Corner) -> Split {
    return split(scaled(coverage(in), HALF_SIGN));
}

@fragment
fn cap_split(@builtin(position) position: vec4f, @builtin(front_facing) front_facing: bool) -> Split {
    return split(cap_value(position, front_facing));
}

@fragment
fn debug(in: Corner, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    if is_left_out(in) {
        discard;
    }
    return select(vec4f(0.02, 0.0, 0.02, 0.0), vec4f(0.0, 0.02, 0.02, 0.0), in.soft > 0.0)
        * select(0.5, 1.0, front_facing);
}
