//! Which materials are drawn deferred for marked cameras, and what the others miss.
//!
//! Bevy decides once for all cameras: a prepared material is forward or deferred. We leave that decision alone and make
//! our own for each marked camera (`deferred_views`). A `StandardMaterial` is deferred there if its method is `Auto`; a
//! material of another type, whose method can no longer be told from `Forward` once it is prepared, if it has shaders
//! for deferred drawing of its own or needs none.

use std::any::TypeId;

use bevy::asset::{AssetEvent, AssetId, AssetPath, Assets, UntypedAssetId};
use bevy::ecs::prelude::*;
use bevy::material::{MaterialProperties, OpaqueRendererMethod};
use bevy::pbr::{
    DeferredFragmentShader, DeferredVertexShader, Lightmap, Material, MaterialFragmentShader,
    MaterialVertexShader, StandardMaterial,
};
use bevy::platform::collections::HashSet;
use bevy::render::Extract;
use bevy::render::sync_world::{MainEntity, MainEntityHashSet};
use bevy::shader::{Shader, ShaderRef};

use super::camera::named;

/// Why a material is drawn forward for marked cameras too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Forward {
    /// A `StandardMaterial` that asks for it, or lets light through, which Bevy's deferred shading cannot show.
    Chosen,
    /// `enable_prepass` is false.
    NoPrepass,
    /// The named fragment shader has no deferred counterpart.
    FragmentShader(String),
    /// The named vertex shader has no deferred counterpart.
    VertexShader(String),
}

impl Forward {
    /// What to do about it, if there is something to do.
    fn advice(&self) -> Option<String> {
        match self {
            Self::Chosen => None,
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

/// What is known of the game's materials; in the render world.
#[derive(Resource, Debug)]
pub(super) struct Deferral {
    /// Bevy's shader of `StandardMaterial`, which draws deferred whatever it does not know.
    standard_shader: Option<AssetPath<'static>>,
    /// Standard materials that are not to be deferred.
    chosen_forward: HashSet<AssetId<StandardMaterial>>,
    /// Entities whose lightmap is sampled bicubically, which only the game's world tells.
    pub bicubic_lightmaps: MainEntityHashSet,
    /// Types of materials that were named, for they stay forward.
    told: HashSet<TypeId>,
    /// Entities with such a material, to be named in the next frame, and the advice.
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
            bicubic_lightmaps: MainEntityHashSet::default(),
            told: HashSet::default(),
            to_tell: Vec::new(),
        }
    }
}

impl Deferral {
    /// Whether a material that Bevy draws forward is deferred for marked cameras.
    pub(super) fn check(&self, id: UntypedAssetId, material: &MaterialProperties) -> Result<(), Forward> {
        if let Ok(id) = id.try_typed::<StandardMaterial>()
            && self.chosen_forward.contains(&id)
        {
            return Err(Forward::Chosen);
        }
        if !material.prepass_enabled {
            return Err(Forward::NoPrepass);
        }
        let fragment = material.get_shader(MaterialFragmentShader);
        let deferred = material.get_shader(DeferredFragmentShader);
        let is_standard = |shader: &ShaderHandle| shader.path() == self.standard_shader.as_ref();
        let has_counterpart = match (&fragment, &deferred) {
            (_, None) => false, // Bevy's default writes no surface
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

    /// Notes a material that stays forward, the first of its type.
    pub(super) fn report(&mut self, entity: MainEntity, id: UntypedAssetId, why: &Forward) {
        if let Some(advice) = why.advice()
            && self.told.insert(id.type_id())
        {
            self.to_tell.push((entity, advice));
        }
    }
}

type ShaderHandle = bevy::asset::Handle<Shader>;

/// A blank and the name of a shader, if it has one.
fn name_of(shader: Option<&ShaderHandle>) -> String {
    match shader.and_then(ShaderHandle::path) {
        Some(path) => format!(" `{path}`"),
        None => String::new(), // made in code
    }
}

/// Follows the render methods of standard materials, and lightmaps. `ExtractSchedule`.
pub(super) fn collect_methods(
    mut deferral: ResMut<Deferral>,
    mut events: Extract<MessageReader<AssetEvent<StandardMaterial>>>,
    materials: Extract<Res<Assets<StandardMaterial>>>,
    lightmaps: Extract<Query<(Entity, &Lightmap), Changed<Lightmap>>>,
    mut unmapped: Extract<RemovedComponents<Lightmap>>,
) {
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let method = materials.get(id).map(Material::opaque_render_method);
                if method == Some(OpaqueRendererMethod::Forward) {
                    deferral.chosen_forward.insert(id);
                } else {
                    deferral.chosen_forward.remove(&id);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                deferral.chosen_forward.remove(&id);
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    for entity in unmapped.read() {
        deferral.bicubic_lightmaps.remove(&MainEntity::from(entity));
    }
    for (entity, lightmap) in &lightmaps {
        if lightmap.bicubic_sampling {
            deferral.bicubic_lightmaps.insert(entity.into());
        } else {
            deferral.bicubic_lightmaps.remove(&MainEntity::from(entity));
        }
    }
}

/// Names the materials that stay forward. `ExtractSchedule`, where entities have names.
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
