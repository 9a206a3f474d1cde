// Shadow volumes of one light: sides from silhouette edges, near and far caps from the caster's own
// triangles.
// The passes write only the stencil; the fragment stage is for the debug view.
// Host    src/techniques/stencil_volume/gpu/recorder.rs
// Twin    techniques::shared::extrude, held equal by tests/gpu/cpu_gpu_parity.rs
// Groups  0 view, 2 casters, 3 positions of the caster's mesh
// Spaces  in: local (position and light); out: clip
#import antumbra::view::clip_position
#import antumbra::view::objects

struct Caster {                     // mirror: techniques::stencil_volume::gpu::gpu_types::Caster
    light_local: vec4f,             // w = 1: a position; w = 0: xyz points towards the light
    object: u32,
    extrusion: f32,                 // factor on the distance, or metres if directional; 0: to infinity
    corners_per_edge: u32,          // 4: a quad; 3: all far corners coincide (directional light, to infinity)
    first_edge: u32,
    single_count: u32,              // edges that count once; those after them count twice
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(2) @binding(0) var<storage, read> casters: array<Caster>;
// The vertices of each edge, in the direction of the near cap.
@group(2) @binding(1) var<storage, read> edges: array<vec2u>;
// Three floats per vertex, local space.
@group(3) @binding(0) var<storage, read> positions: array<f32>;

// Colours of the debug view. The stencil passes have no colour target.
override DEBUG_FRONT: u32 = 0u;
override DEBUG_BACK: u32 = 0u;

struct Corner {
    @builtin(position) @invariant position_clip: vec4f,
}

// Pushes a vertex away from the light: to infinity (w = 0), or by a factor on its distance, or by metres for
// a light at infinity. All three keep the plane of every side.
// Source: McGuire 2004, "Efficient Shadow Volume Rendering", GPU Gems, listing 9-3 and section 9.6.1.
fn far_position(caster: Caster, position_local: vec3f) -> vec4f {
    let from_light = position_local * caster.light_local.w - caster.light_local.xyz;
    if caster.extrusion > 0.0 {
        let base = caster.light_local.xyz * caster.light_local.w + position_local * (1.0 - caster.light_local.w);
        let pushed = base + from_light * caster.extrusion;
        return clip_position(caster.object, pushed);
    }
    return objects[caster.object].clip_from_local * vec4f(from_light, 0.0);
}

fn position_of(vertex: u32) -> vec3f {
    let first = vertex * 3u;
    return vec3f(positions[first], positions[first + 1u], positions[first + 2u]);
}

// The edge of a caster's side `side`. A single edge has one side; a double edge has two in one place.
fn edge_of(caster: Caster, side: u32) -> vec2u {
    let of_double = caster.single_count + (side - caster.single_count) / 2u;
    return edges[caster.first_edge + select(side, of_double, side >= caster.single_count)];
}

// Side s has the vertices from 4 s on (quads with indices: b a a∞, b a∞ b∞) or from 3 s on (triangles). All
// wind outward.
@vertex
fn side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    let caster = casters[instance];
    let edge = edge_of(caster, vertex / caster.corners_per_edge);
    let corner = vertex % caster.corners_per_edge;
    let is_far = corner >= 2u;
    let is_end = corner == 0u || corner == 3u;
    let position_local = position_of(select(edge.x, edge.y, is_end));
    if is_far {
        return Corner(far_position(caster, position_local));
    }
    return Corner(clip_position(caster.object, position_local));
}

@vertex
fn near_cap(@location(0) position_local: vec3f, @builtin(instance_index) instance: u32) -> Corner {
    return Corner(clip_position(casters[instance].object, position_local));
}

@vertex
fn far_cap(@location(0) position_local: vec3f, @builtin(instance_index) instance: u32) -> Corner {
    let caster = casters[instance];
    return Corner(far_position(caster, position_local));
}

@fragment
fn debug(@builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    return unpack4x8unorm(select(DEBUG_BACK, DEBUG_FRONT, front_facing));
}

// Writes nothing: the colour target's write mask is empty.
@fragment
fn no_color() -> @location(0) vec4f {
    return vec4f(0.0);
}
