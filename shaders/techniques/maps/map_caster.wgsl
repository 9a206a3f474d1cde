// Casters of one picture in a light's space.
// Spaces  in: local; out: clip of the picture
#define_import_path antumbra::map_caster

struct MapCaster {                  // mirror: techniques::maps::gpu::gpu_types::MapCaster
    clip_from_centered: mat4x4f,
    center_local: vec4f,
}

@group(0) @binding(0) var<storage, read> casters: array<MapCaster>;

// Coordinates of a mesh far from its own origin would cancel in the product, so they are taken from its centre first.
fn clip_position(position_local: vec3f, caster: u32) -> vec4f {
    return casters[caster].clip_from_centered * vec4f(position_local - casters[caster].center_local.xyz, 1.0);
}
