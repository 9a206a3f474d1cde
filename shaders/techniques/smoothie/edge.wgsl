// Smoothie edges and corners of the casters that one face of a map shows.
// Host    src/techniques/smoothie/gpu/recorder.rs
// Twin    techniques::smoothie::expand, for the vertices; techniques::smoothie::shade, for the values
// Groups  0 edges, 1 face, 2 depths
// Spaces  anchored: world axes, origin at the light (directional: at the first face's origin)
//         face: of the map; clip: of the face. Depth is not tested: the fragment stage compares distances.
#import antumbra::smoothie::{CLEAR, resolve_from_point, resolve_parallel}

struct SmoothieEdge {               // mirror: techniques::smoothie::records::SmoothieEdge
    start: vec3f,                   // anchored; the caster is on the left, as the light sees it
    width_start: f32,               // metres
    end: vec3f,
    width_end: f32,
    next: vec3f,                    // end of the next edge of the loop
    kind: f32,                      // SECTOR, DISC or DISC_ALONE
}

struct SmoothieFace {               // mirror: techniques::smoothie::records::SmoothieFace
    row_x: vec4f,                   // rows of the transform from anchored to face
    row_y: vec4f,
    row_z: vec4f,
    projection: vec4f,              // half side at distance 1, near, texel at distance 1, 0; parallel: half side, length, texel, 1
    limits: vec4f,                  // scale of reciprocals of distances, drop of a directional light, zw unused
}

@group(0) @binding(0) var<storage, read> edges: array<SmoothieEdge>;
@group(1) @binding(0) var<uniform> face: SmoothieFace;
@group(2) @binding(0) var all_depth: texture_depth_2d;
@group(2) @binding(1) var still_depth: texture_depth_2d;

// Values of SmoothieEdge::kind.
const SECTOR: f32 = 0.0;            // mirror: techniques::smoothie::records::SECTOR
const DISC: f32 = 1.0;              // mirror: techniques::smoothie::records::DISC
const DISC_ALONE: f32 = 2.0;        // mirror: techniques::smoothie::records::DISC_ALONE

// Triangles of a corner.
const CORNER_TRIANGLES: f32 = 6.0;  // mirror: techniques::smoothie::expand::CORNER_TRIANGLES
// Radians by which a sector overlaps the edges beside it: no pixel centre falls between them.
const OVERLAP: f32 = 0.05;          // mirror: techniques::smoothie::expand::OVERLAP
// A turn to the right by more than this, radians, counts as a half turn: rounding decides its sign.
const HALF_TURN: f32 = 3.1;         // mirror: techniques::smoothie::expand::HALF_TURN
// Texels by which an edge reaches inside the caster: no pixel centre falls between them.
const INSIDE_TEXELS: f32 = 1.5;     // mirror: techniques::smoothie::expand::INSIDE_TEXELS

struct Corner {
    @builtin(position) position_clip: vec4f,
    @location(0) offset: vec2f,     // from the silhouette, metres
    @location(1) width: f32,        // metres
    @location(2) along: f32,        // z in the face's space
}

// Unit vector away from the light.
fn away(position: vec3f) -> vec3f {
    return select(normalize(position), face.row_z.xyz, face.projection.w == 1.0);
}

// Unit vector out of the caster, at right angles to an edge and to the rays that meet it.
fn outward(start: vec3f, end: vec3f) -> vec3f {
    return normalize(cross(select(start, face.row_z.xyz, face.projection.w == 1.0), end - start));
}

// A unit vector at right angles to another.
fn across(direction: vec3f) -> vec3f {
    let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(direction.x) > 0.7);
    return normalize(cross(direction, axis));
}

fn place(position: vec3f, offset: vec2f, width: f32) -> Corner {
    let p = vec4f(position, 1.0);
    let x = dot(face.row_x, p);
    let y = dot(face.row_y, p);
    let z = dot(face.row_z, p);
    let projection = face.projection;
    let side = vec2f(x, y) / projection.x;
    let perspective = vec4f(side, projection.y, z);
    return Corner(select(perspective, vec4f(side, 0.5, 1.0), projection.w == 1.0), offset, width, z);
}

fn of_edge(edge: SmoothieEdge, vertex: u32) -> Corner {
    let at_end = vertex == 1u || vertex == 2u || vertex == 4u;
    let outside = vertex == 2u || vertex >= 4u;
    let position = select(edge.start, edge.end, at_end);
    let width = select(edge.width_start, edge.width_end, at_end);
    let distance = select(length(position), 1.0, face.projection.w == 1.0);
    let inside = -INSIDE_TEXELS * face.projection.z * distance;
    let offset = select(inside, width, outside);
    return place(position + outward(edge.start, edge.end) * offset, vec2f(offset, 0.0), width);
}

fn of_corner(edge: SmoothieEdge, vertex: u32) -> Corner {
    let direction = away(edge.end);
    var normal: vec3f;
    if edge.kind == DISC_ALONE {
        normal = across(direction);
    } else {
        normal = outward(edge.start, edge.end);
    }
    let tangent = cross(normal, direction);
    var first = 0.0;
    var last = 6.2831853;
    if edge.kind == SECTOR {
        let next = outward(edge.end, edge.next);
        var turn = atan2(dot(next, tangent), dot(next, normal));
        turn = select(turn, 3.14159265, turn < -HALF_TURN);
        if turn <= 0.0 {            // the edges overlap
            return place(edge.end, vec2f(0.0), edge.width_end);
        }
        first = -OVERLAP;
        last = turn + OVERLAP;
    }
    if vertex % 3u == 0u {
        return place(edge.end, vec2f(0.0), edge.width_end);
    }
    let step = (last - first) / CORNER_TRIANGLES;
    let angle = first + step * f32(vertex / 3u + vertex % 3u - 1u);
    let offset = vec2f(cos(angle), sin(angle)) * (edge.width_end / cos(0.5 * step));
    return place(edge.end + normal * offset.x + tangent * offset.y, offset, edge.width_end);
}

fn smoothie_vertex(edge: SmoothieEdge, vertex: u32) -> Corner {
    if vertex >= 6u {
        return of_corner(edge, vertex - 6u);
    }
    if edge.kind == DISC_ALONE {
        return place(edge.end, vec2f(0.0), edge.width_end);
    }
    return of_edge(edge, vertex);
}

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) index: u32) -> Corner {
    return smoothie_vertex(edges[index], vertex);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4f {
    let texel = vec2u(in.position_clip.xy);
    let nearest = textureLoad(all_depth, texel, 0);
    let still = textureLoad(still_depth, texel, 0);
    let alpha = length(in.offset) / in.width;
    let size = face.projection.y;
    var stored: vec2f;
    var own: f32;
    if face.projection.w == 1.0 {
        own = 1.0 - in.along / size;
        stored = resolve_parallel(alpha, in.along, (1.0 - still) * size, face.limits.y);
    } else {
        own = size / in.along;
        stored = resolve_from_point(alpha, in.along, still / size, face.limits.x);
    }
    // Beyond the rim, or behind a caster, where everything is dark.
    if alpha >= 1.0 || own < nearest {
        stored = CLEAR;
    }
    return vec4f(stored, 0.0, 1.0);
}
