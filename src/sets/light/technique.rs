//! The shadow technique of a light, as far as the sets, the silhouettes and the renderer must know it.

use std::any::TypeId;

/// The casters whose silhouettes a technique is built on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NeededSilhouettes {
    /// The technique reads no silhouettes, and none are extracted for its lights.
    #[default]
    None,
    /// The casters of set S: those whose shadow can reach what is seen in this frame.
    Shadowing,
    /// All casters in set L that cast for the light, in view or not: a picture that is kept from frame to frame needs
    /// them. Costs more wherever the light reaches casters whose shadow is not seen.
    Reached,
}

/// Needs of a technique: work that the stages before and after it do for its lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Needs {
    /// The casters whose silhouettes are extracted.
    pub silhouettes: NeededSilhouettes,
    /// Objects that something hides from the light are left out of set L, and are not drawn for the light: the technique
    /// would find them dark anyway. A technique that keeps pictures of the casters in L leaves this off, or its pictures
    /// would change with every occluder that moves. Lights with an extent are never occluded, nor are companions.
    pub light_occlusion: bool,
    /// The planes of the visible triangles are drawn before the mask is resolved.
    pub receiver_planes: bool,
    /// The technique draws the receivers into the mask and reads no texture of their depth. The copy of the depth is not made
    /// for its lights.
    pub draws_receivers: bool,
    /// The technique shows the picture that an area light's entity has
    /// ([`EmitterTexture`](crate::techniques::penumbra_wedge::EmitterTexture)).
    pub emitter_texture: bool,
    /// The technique moves the light along the path that the light's entity has
    /// ([`LightPath`](crate::scene::LightPath)).
    pub light_path: bool,
}

impl Needs {
    /// Nothing beyond set S.
    pub const NOTHING: Self = Self {
        silhouettes: NeededSilhouettes::None,
        light_occlusion: false,
        receiver_planes: false,
        draws_receivers: false,
        emitter_texture: false,
        light_path: false,
    };
}

/// The technique that shadows a light in this frame.
///
/// Found anew in every frame from the components of the light
/// ([`choose_techniques`](crate::techniques::choose_techniques)), so that nothing is left over when a technique is
/// removed or exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightTechnique {
    /// Index of the technique in the list of the world's techniques.
    pub row: usize,
    /// Name of the technique, in snake case.
    pub name: &'static str,
    /// Type of the technique's component.
    pub component: TypeId,
    /// Needs of the technique.
    pub needs: Needs,
}
