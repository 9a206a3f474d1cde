//! The decision which materials are drawn deferred for marked cameras, and advice about those that are not.
//!
//! Bevy decides once for all cameras whether a prepared material is forward or deferred. We leave that
//! decision alone and make another one for marked cameras (`deferred_views`). A `StandardMaterial` is
//! deferred there if its method is `Auto` and Bevy's G-buffer holds all of its features. A prepared material
//! of another type no longer shows whether its method was `Auto` or `Forward`. Such a material is deferred if
//! it has its own shaders for deferred drawing or has no shaders of its own.

use std::any::TypeId;

use bevy::asset::{AssetEvent, AssetId, AssetPath, Assets, Handle, UntypedAssetId};
use bevy::color::LinearRgba;
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::material::{MaterialProperties, OpaqueRendererMethod};
use bevy::pbr::{
    DeferredFragmentShader, DeferredVertexShader, Material, MaterialFragmentShader, MaterialVertexShader,
    StandardMaterial,
};
use bevy::platform::collections::HashSet;
use bevy::reflect::structs::Struct;
use bevy::render::Extract;
use bevy::render::sync_world::MainEntity;
use bevy::shader::{Shader, ShaderRef};

use super::camera::named;

/// The reason why a material is drawn forward for marked cameras too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Forward {
    /// The material is a `StandardMaterial` whose method is `Forward`, which transmits light, or which has a
    /// feature that Bevy's G-buffer does not hold.
    Chosen,
    /// The mesh has a lightmap. Bevy's deferred shading adds the light that the lightmap holds a second time.
    Lightmapped,
    /// As `Chosen`, but no mask fits the mesh: light shines through it from behind, or the depth prepass lacks it.
    ChosenUnmasked,
    /// The material's `enable_prepass` is false.
    NoPrepass,
    /// The named fragment shader has no deferred counterpart.
    FragmentShader(String),
    /// The named vertex shader has no deferred counterpart.
    VertexShader(String),
}

impl Forward {
    /// Whether the visible share of lights can be looked up while the mesh is drawn forward. It belongs to the
    /// surface that the depth prepass shows, and to the side of the surface that is seen.
    pub(super) fn allows_masks(&self) -> bool {
        !matches!(self, Self::NoPrepass | Self::ChosenUnmasked)
    }

    /// Returns advice for the log; `None` if the game has chosen forward drawing.
    fn advice(&self) -> Option<String> {
        match self {
            Self::Chosen | Self::ChosenUnmasked => None,
            Self::Lightmapped => {
                Some("Bevy's deferred shading would add the light of the mesh's lightmap twice".to_owned())
            }
            Self::NoPrepass => Some("its `enable_prepass` is false".to_owned()),
            Self::FragmentShader(shader) => Some(format!(
                "its fragment shader{shader} has no deferred counterpart; return one from `deferred_fragment_shader`"
            )),
            Self::VertexShader(shader) => Some(format!(
                "its vertex shader{shader} has no deferred counterpart; return one from `deferred_vertex_shader`"
            )),
        }
    }
}

/// Facts about the game's materials that decide whether they are deferred. It is in the render world.
#[derive(Resource, Debug)]
pub(super) struct Deferral {
    /// Bevy's deferred shader of `StandardMaterial`. A material that inherits it beside a fragment shader of
    /// its own has no deferred counterpart of that shader.
    standard_shader: Option<AssetPath<'static>>,
    /// Standard materials whose render method is `Forward`.
    chosen_forward: HashSet<AssetId<StandardMaterial>>,
    /// Materials with diffuse transmission: light that shines on them from behind passes through.
    transmitting: HashSet<AssetId<StandardMaterial>>,
    /// Materials with a feature that Bevy's G-buffer does not hold ([`exceeds_g_buffer`]).
    exceeding: HashSet<AssetId<StandardMaterial>>,
    /// Types of materials that have been named in the log because they stay forward.
    told: HashSet<TypeId>,
    /// Entities whose material stays forward, with advice. The next frame names them in the log.
    to_tell: Vec<(MainEntity, String)>,
}

impl Default for Deferral {
    fn default() -> Self {
        let standard_shader = match StandardMaterial::deferred_fragment_shader() {
            ShaderRef::Path(path) => Some(path),
            ShaderRef::Default | ShaderRef::Handle(_) => None,
        };
        Self {
            standard_shader,
            chosen_forward: HashSet::default(),
            transmitting: HashSet::default(),
            exceeding: HashSet::default(),
            told: HashSet::default(),
            to_tell: Vec::new(),
        }
    }
}

impl Deferral {
    /// Checks whether a material that Bevy draws forward can be deferred for marked cameras. Where forward meshes
    /// have no masks, shadows are worth more than the features that Bevy's G-buffer does not hold.
    ///
    /// # Errors
    /// The reason why the material stays forward.
    pub(super) fn check(
        &self,
        id: UntypedAssetId,
        material: &MaterialProperties,
        has_masks: bool,
    ) -> Result<(), Forward> {
        let standard = id.try_typed::<StandardMaterial>().ok();
        if standard.is_some_and(|id| self.chosen_forward.contains(&id)) {
            if standard.is_some_and(|id| self.transmitting.contains(&id)) || !material.prepass_enabled {
                return Err(Forward::ChosenUnmasked);
            }
            return Err(Forward::Chosen);
        }
        if !material.prepass_enabled {
            return Err(Forward::NoPrepass);
        }
        if has_masks && standard.is_some_and(|id| self.exceeding.contains(&id)) {
            return Err(Forward::Chosen);
        }
        let fragment = material.get_shader(MaterialFragmentShader);
        let deferred = material.get_shader(DeferredFragmentShader);
        let is_standard = |shader: &ShaderHandle| shader.path() == self.standard_shader.as_ref();
        let has_counterpart = match (&fragment, &deferred) {
            (_, None) => false, // Bevy's default deferred shader writes no surface
            (Some(fragment), Some(deferred)) => fragment == deferred || !is_standard(deferred),
            (None, Some(_)) => true,
        };
        if !has_counterpart {
            return Err(Forward::FragmentShader(name_of(fragment.as_ref())));
        }
        let vertex = material.get_shader(MaterialVertexShader);
        if vertex.is_some() && material.get_shader(DeferredVertexShader).is_none() {
            return Err(Forward::VertexShader(name_of(vertex.as_ref())));
        }
        Ok(())
    }

    /// Records a material that stays forward, to be named in the log. Only the first of each type is
    /// recorded.
    pub(super) fn report(&mut self, entity: MainEntity, id: UntypedAssetId, why: &Forward) {
        if let Some(advice) = why.advice()
            && self.told.insert(id.type_id())
        {
            self.to_tell.push((entity, advice));
        }
    }
}

type ShaderHandle = Handle<Shader>;

/// Returns a space and the path of a shader in backticks, or nothing if the shader has no path.
fn name_of(shader: Option<&ShaderHandle>) -> String {
    match shader.and_then(ShaderHandle::path) {
        Some(path) => format!(" `{path}`"),
        None => String::new(), // the shader was made in code
    }
}

/// Whether a material has a feature that Bevy's G-buffer does not hold: anisotropy, coloured reflectance, a
/// clearcoat with a roughness above 0.5, or a clearcoat whose normals are not those of the base.
fn exceeds_g_buffer(material: &StandardMaterial) -> bool {
    let tint = LinearRgba::from(material.specular_tint);
    let is_grey = tint.red == tint.green && tint.green == tint.blue;
    let has_own_normals = has_texture(material, "normal_map_texture") // which the coat does not follow
        || has_texture(material, "clearcoat_normal_texture");
    material.anisotropy_strength > 0.0
        || !is_grey
        || has_texture(material, "specular_tint_texture")
        || material.clearcoat > 0.0 && (material.clearcoat_perceptual_roughness > 0.5 || has_own_normals)
}

/// Whether a material has a texture in a named field. Some of these fields are there only with a feature of Bevy's,
/// which the game may turn on.
fn has_texture(material: &StandardMaterial, field: &str) -> bool {
    let texture = material.field(field);
    let texture = texture.and_then(|field| field.try_downcast_ref::<Option<Handle<Image>>>());
    texture.is_some_and(Option::is_some)
}

/// Updates the render methods and features of standard materials.
///
/// Runs in `ExtractSchedule`.
pub(super) fn collect_methods(
    mut deferral: ResMut<Deferral>,
    mut events: Extract<MessageReader<AssetEvent<StandardMaterial>>>,
    materials: Extract<Res<Assets<StandardMaterial>>>,
) {
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let material = materials.get(id);
                if material.is_some_and(|material| material.diffuse_transmission > 0.0) {
                    deferral.transmitting.insert(id);
                } else {
                    deferral.transmitting.remove(&id);
                }
                if material.is_some_and(exceeds_g_buffer) {
                    deferral.exceeding.insert(id);
                } else {
                    deferral.exceeding.remove(&id);
                }
                let method = material.map(Material::opaque_render_method);
                if method == Some(OpaqueRendererMethod::Forward) {
                    deferral.chosen_forward.insert(id);
                } else {
                    deferral.chosen_forward.remove(&id);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                deferral.chosen_forward.remove(&id);
                deferral.transmitting.remove(&id);
                deferral.exceeding.remove(&id);
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

/// Names the recorded materials that stay forward in the log.
///
/// Runs in `ExtractSchedule`, where the names of entities can be read.
pub(super) fn tell_of_forward(mut deferral: ResMut<Deferral>, names: Extract<Query<&Name>>) {
    if deferral.to_tell.is_empty() {
        return;
    }
    for (entity, advice) in deferral.to_tell.drain(..) {
        let entity = entity.id();
        let named = named(entity, names.get(entity).ok());
        tracing::warn!(
            "the material of {named} stays forward for cameras with `AntumbraCamera`, and shows no shadows of ours: {advice}"
        );
    }
}
