//! The trait of shadow techniques.

use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;

use super::refusal::{FileError, Refusal};
use super::statistics::Statistics;
use super::texels::TexelLookup;
use crate::debug_lines::DebugLines;
#[cfg(feature = "render")]
use crate::render::RenderError;
#[cfg(feature = "render")]
use crate::render::recorder::Recorder;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::{LeftObjects, Needs};

/// A shadow technique: a component that a user puts on a light, with everything that the crate must know to
/// shadow the light. Items with a default are optional.
pub trait Technique: Component<Mutability = Mutable> + Clone + PartialEq + Default {
    /// Name of the technique in scene files, statistics, reports and labels, in snake case. No two techniques
    /// of a world may have the same name.
    const NAME: &'static str;

    /// Work that the stages before and after this technique do for its lights.
    const NEEDS: Needs;

    /// Whether the technique knows only a part of the scene and leaves the rest to another technique: a light with this
    /// component may then have one more. On receivers that this technique knows, the darker visibility of both counts, and the
    /// other technique shadows by casters that this one does not know. On all other receivers the other technique shadows
    /// alone, by all casters. The mask is 1 there, or less where the light shines less. Default: false.
    const LEAVES_OTHERS: bool = false;

    /// Returns the objects that the technique leaves to another technique of a light in this frame, if it leaves any
    /// ([`Technique::LEAVES_OTHERS`]). `light` is the light's index in [`FrameLights`](crate::sets::FrameLights). Systems that
    /// find them belong in the set [`LeavingSystems`](crate::techniques::LeavingSystems). The default leaves all objects.
    fn left_to_others(_world: &World, _light: usize) -> LeftObjects<'_> {
        LeftObjects::All
    }

    /// Names of the settings that are paths of files or folders. A shot file has them relative to itself. The default is no
    /// paths.
    const PATHS: &'static [&'static str] = &[];

    /// Reads the files that a light's settings name, so that faults in them are errors of whoever loads a scene. Without
    /// this call the technique reads them in the first frame that needs them, and reports faults. The default reads
    /// nothing.
    ///
    /// # Errors
    /// The setting, and what is wrong with its file.
    fn load_files(_world: &mut World, _light: Entity) -> Result<(), FileError> {
        Ok(())
    }

    /// Checks whether a light can be shadowed with these settings. A light that is refused shines without a
    /// shadow, and the crate reports the reason. The default accepts every light.
    ///
    /// # Errors
    /// The reason why the light is refused, and what to use instead.
    fn check(&self, _light: &Light) -> Result<(), Refusal> {
        Ok(())
    }

    /// Inserts the missing ones of the resources that the technique's systems need.
    fn init(_world: &mut World) {}

    /// Adds the technique's systems to the set [`TechniqueSystems`](crate::techniques::TechniqueSystems). The
    /// systems must handle the lights for which
    /// [`FrameLight::is_shadowed_by`](crate::sets::FrameLight::is_shadowed_by) is true for this technique,
    /// and leave the others alone.
    fn add_systems(_schedule: &mut Schedule) {}

    /// Sets statistics of one light. `light` is its index in [`FrameLights`](crate::sets::FrameLights). The
    /// function is called for lights of other techniques too, so that the statistics of every light have the
    /// same names.
    fn statistics(_world: &World, _light: usize, _out: &mut Statistics) {}

    /// Sets statistics of the whole frame.
    fn frame_statistics(_world: &World, _out: &mut Statistics) {}

    /// Adds lines that show how the technique shadows a light, such as the faces of its map. `light` is an index into
    /// [`FrameLights`](crate::sets::FrameLights) of a light that this technique shadows. The default adds none.
    fn debug_lines(_world: &World, _light: usize, _out: &mut DebugLines) {}

    /// Returns a function that counts the texels that a part of a surface covers in the technique's pictures, as they were
    /// drawn last; the playground shows it as texels per pixel. `light` is an index into
    /// [`FrameLights`](crate::sets::FrameLights) of a light that this technique shadows. `None`, the default: the technique
    /// looks up no picture of the light.
    fn texels(_world: &World, _light: usize) -> Option<TexelLookup<'_>> {
        None
    }

    /// Raises reports about lights that [`Technique::check`] accepts but that the technique cannot shadow as
    /// asked in this frame. The topic is [`Technique::NAME`].
    fn report(_world: &World, _round: &mut Round) {}

    /// Reads settings of the technique from a file.
    ///
    /// The default always fails. A component that implements [`serde::Deserialize`] can return
    /// `erased_serde::deserialize(from)`.
    ///
    /// # Errors
    /// The error names the setting that is wrong.
    #[cfg(feature = "serde")]
    fn parse(_from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        let reason = format!("settings of {} cannot be read from files", Self::NAME);
        Err(serde::de::Error::custom(reason))
    }

    /// Describes the settings that [`Technique::parse`] reads, as a JSON Schema of an object. Editors complete
    /// shot files from it, and the playground makes a widget of each property: its description is the help,
    /// and its `minimum` and `maximum` bound the values.
    ///
    /// The default describes nothing. A component that derives [`schemars::JsonSchema`] can return
    /// `Some(Self::json_schema(of))`.
    #[cfg(feature = "schema")]
    fn schema(_of: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
        None
    }

    /// Registers the component for Bevy's reflection. The default does nothing. A component that derives
    /// `Reflect` calls `types.register::<Self>()`.
    #[cfg(feature = "bevy")]
    fn register_type(_types: &mut bevy_reflect::TypeRegistry) {}

    /// WGSL files of the technique. Each file comes after the files that it imports. The default is no files.
    #[cfg(feature = "render")]
    const SHADERS: &'static [ShaderFile] = &[];

    /// The GPU side of the technique. Techniques with the same recorder type share one recorder in each view.
    #[cfg(feature = "render")]
    type Recorder: Recorder;

    /// Makes the recorder of a view. [`Technique::SHADERS`] have already been added to the shaders of `gpu`.
    ///
    /// # Errors
    /// A shader does not compose, or the device refuses a resource.
    #[cfg(feature = "render")]
    fn recorder(gpu: &crate::render::Gpu) -> Result<Self::Recorder, RenderError>;
}
