//! What a shadow technique is.

use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;

use super::refusal::Refusal;
use super::statistics::Statistics;
#[cfg(feature = "render")]
use crate::render::RenderError;
#[cfg(feature = "render")]
use crate::render::recorder::Recorder;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::Needs;

/// A shadow technique: a component that a user puts on a light, and all that the crate must know to shadow the light by
/// it. What has a default need not be there.
pub trait Technique: Component<Mutability = Mutable> + Clone + PartialEq + Default {
    /// Name in scene files, statistics, reports and labels, in snake case. No two techniques of a world share one.
    const NAME: &'static str;

    /// What the stages before and after this technique do for its lights.
    const NEEDS: Needs;

    /// Whether a light can be shadowed with these settings. A light that is refused shines without a shadow, and the
    /// crate reports why.
    ///
    /// # Errors
    /// What is wrong, and what to use instead.
    fn check(&self, _light: &Light) -> Result<(), Refusal> {
        Ok(())
    }

    /// Inserts the resources that the technique's systems need, those that are missing.
    fn init(_world: &mut World) {}

    /// Adds the technique's systems, in [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques). A light is
    /// the technique's own if [`FrameLight::is_shadowed_by`](crate::sets::FrameLight::is_shadowed_by) says so.
    fn add_systems(_schedule: &mut Schedule) {}

    /// Sets what is known of one light of [`FrameLights`](crate::sets::FrameLights), whose index is `light`. Called for
    /// lights of other techniques too, so that every light has the same names.
    fn statistics(_world: &World, _light: usize, _out: &mut Statistics) {}

    /// Sets what is known of the frame as a whole.
    fn frame_statistics(_world: &World, _out: &mut Statistics) {}

    /// Raises what the technique cannot do in this frame for lights that [`Technique::check`] lets through. The topic is
    /// [`Technique::NAME`].
    fn report(_world: &World, _round: &mut Round) {}

    /// Reads settings from a file.
    ///
    /// The default refuses all. With [`serde::Deserialize`] on the component it is `erased_serde::deserialize(from)`.
    ///
    /// # Errors
    /// Names the setting that is wrong.
    #[cfg(feature = "serde")]
    fn parse(_from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        let reason = format!("settings of {} cannot be read from files", Self::NAME);
        Err(serde::de::Error::custom(reason))
    }

    /// Makes the component known to Bevy's reflection. The default does nothing; with `derive(Reflect)` it is
    /// `types.register::<Self>()`.
    #[cfg(feature = "bevy")]
    fn register_type(_types: &mut bevy_reflect::TypeRegistry) {}

    /// The technique's WGSL files, each after those that it imports.
    #[cfg(feature = "render")]
    const SHADERS: &'static [ShaderFile] = &[];

    /// The GPU side of the technique. Techniques with one type here share one recorder in each view.
    #[cfg(feature = "render")]
    type Recorder: Recorder;

    /// Makes the recorder of a view. The shaders of `gpu` know [`Technique::SHADERS`].
    ///
    /// # Errors
    /// A shader that does not compose, or what the device refuses.
    #[cfg(feature = "render")]
    fn recorder(gpu: &crate::render::Gpu) -> Result<Self::Recorder, RenderError>;
}
