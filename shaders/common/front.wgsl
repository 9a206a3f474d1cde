// The depth of the nearest surfaces, blended ones included: bind group 3 of the passes that skip the nearest
// surface.
// Host    src/render/nodes/front_layer.rs
#define_import_path antumbra::front

@group(3) @binding(0) var front_depth: texture_depth_2d;

// Whether a fragment is the nearest at its pixel. `position` is the fragment's, with depth in z. The
// tolerance is needed because depth of 24 bits is stored rounded.
fn is_front(position: vec4f) -> bool {
    let nearest = textureLoad(front_depth, vec2u(position.xy), 0);
    return position.z >= nearest * (1.0 - 1e-6) - 6e-8;
}
