//! Shadow techniques, one folder each: its component, its CPU geometry and systems, its recorder.
//!
//! A technique is a component on the light; lights choose separately, and any mix renders in one frame. What a
//! technique leaves is visibility (1 where a surface point sees the whole light, 0 where it sees none), and the light
//! pass multiplies by it and knows nothing else about techniques.

pub mod maps;
pub mod omni_map;
pub mod penumbra_wedge;
pub(crate) mod report;
pub mod shadow_map;
pub(crate) mod shared;
pub mod stencil_volume;

pub use omni_map::OmniMap;
pub use penumbra_wedge::{PenumbraWedge, PenumbraWedges};
pub use shadow_map::ShadowMap;
pub use stencil_volume::StencilVolume;

/// Holds maps to the size that the device allows.
///
/// Set: `BuildTechniques`, before `build_maps`.
#[cfg(feature = "render")]
pub fn limit_maps_to_device(
    renderer: bevy_ecs::prelude::Res<crate::render::Renderer>,
    mut settings: bevy_ecs::prelude::ResMut<maps::MapSettings>,
) {
    let limit = renderer.context().device.limits().max_texture_dimension_2d;
    if settings.largest > limit {
        settings.largest = limit;
    }
}

/// Gives a renderer the crate's own techniques, unless techniques of these names were added to it.
///
/// Set: `PrepareGpu`, before `prepare_techniques`. Here and not in the renderer, which knows no technique by name.
/// Compares names; only the first frame of a renderer does more.
#[cfg(feature = "render")]
pub fn add_builtin_techniques(mut renderer: bevy_ecs::prelude::ResMut<crate::render::Renderer>) {
    use maps::gpu::recorder::MapNode;
    use maps::request::MapComponent;
    use penumbra_wedge::gpu::recorder as wedge;
    use stencil_volume::gpu::recorder as volume;
    let (context, shaders, layouts) = (renderer.context(), renderer.shaders(), renderer.layouts());
    let mut made: Vec<Result<Box<dyn crate::render::recorder::Recorder>, _>> = Vec::new();
    if !renderer.has_technique(volume::NAME) {
        let node = volume::StencilVolumeNode::new(context, shaders, layouts);
        made.push(node.map(|node| Box::new(node) as _));
    }
    if !renderer.has_technique(wedge::NAME) {
        let node = wedge::PenumbraWedgeNode::new(context, shaders, layouts);
        made.push(node.map(|node| Box::new(node) as _));
    }
    for component in [MapComponent::Shadow, MapComponent::Omni] {
        if !renderer.has_technique(component.name()) {
            let node = MapNode::new(component, context, shaders, layouts);
            made.push(node.map(|node| Box::new(node) as _));
        }
    }
    for technique in made {
        match technique {
            Ok(technique) => renderer.add_technique(technique),
            Err(error) => renderer.fail(error),
        }
    }
}
