//! Shaders of forward materials, extended by the lookup of our masks.
//!
//! Shader  `shaders/bevy/forward.wgsl`
//!
//! Overrides of naga_oil count in the root module alone, which for a forward mesh is the fragment shader of its
//! material. So each such shader gets a copy with our text at its end. The copy is an asset of its own: the
//! material, other cameras and other passes keep the original. When the original is reloaded, so is the copy.

use bevy::asset::{AssetEvent, AssetId, Assets, Handle};
use bevy::ecs::prelude::*;
use bevy::platform::collections::HashMap;
use bevy::render::{Extract, MainWorld};
use bevy::shader::{Shader, ShaderImport, Source};

const LOOKUP: &str = include_str!("../../shaders/bevy/forward.wgsl");

/// The extended copies of shaders. The resource is in the render world.
#[derive(Resource, Default)]
pub struct ForwardShaders {
    /// The copy of each shader; `None` if the shader is not WGSL and cannot be extended.
    extended: HashMap<AssetId<Shader>, Option<Handle<Shader>>>,
    /// Shaders whose copy must be made or renewed.
    wanted: Vec<AssetId<Shader>>,
}

impl ForwardShaders {
    /// Returns the extended copy of a shader; `None` if it is not made yet, or cannot be made.
    pub(super) fn get(&mut self, original: &Handle<Shader>) -> Option<Handle<Shader>> {
        let id = original.id();
        match self.extended.get(&id) {
            Some(copy) => copy.clone(),
            None => {
                if !self.wanted.contains(&id) {
                    self.wanted.push(id);
                }
                None
            }
        }
    }

    /// Whether a shader is known to have no extended copy.
    pub(super) fn is_refused(&self, original: &Handle<Shader>) -> bool {
        matches!(self.extended.get(&original.id()), Some(None))
    }
}

/// Lists the shaders that were reloaded.
///
/// Runs in `ExtractSchedule`.
pub(super) fn collect_reloaded(
    mut forward: ResMut<ForwardShaders>,
    mut events: Extract<MessageReader<AssetEvent<Shader>>>,
) {
    for event in events.read() {
        if let AssetEvent::Modified { id } = *event
            && forward.extended.contains_key(&id)
            && !forward.wanted.contains(&id)
        {
            forward.wanted.push(id);
        }
    }
}

/// Makes the copies that are wanted. A steady frame does nothing.
///
/// Runs in `ExtractSchedule`.
pub(super) fn extend_shaders(mut main: ResMut<MainWorld>, mut forward: ResMut<ForwardShaders>) {
    if forward.wanted.is_empty() {
        return;
    }
    let Some(mut shaders) = main.get_resource_mut::<Assets<Shader>>() else {
        return;
    };
    let ForwardShaders { extended, wanted } = &mut *forward;
    wanted.retain(|&id| {
        let Some(original) = shaders.get(id) else {
            return true; // it is not loaded yet
        };
        let copy = extend(original);
        let known = extended.get(&id).cloned().flatten();
        let handle = match (copy, known) {
            (None, _) => None,
            (Some(copy), Some(known)) => shaders.insert(known.id(), copy).is_ok().then_some(known),
            (Some(copy), None) => Some(shaders.add(copy)),
        };
        extended.insert(id, handle);
        false
    });
}

/// Returns a shader with the lookup at its end; `None` if the shader is not WGSL.
fn extend(original: &Shader) -> Option<Shader> {
    let Source::Wgsl(text) = &original.source else {
        return None;
    };
    let path = format!("{} with antumbra's masks", original.path);
    let extended = Shader::from_wgsl(format!("{text}\n{LOOKUP}"), path.clone());
    Some(Shader {
        // Nobody imports the copy, so it must not take the place of the original.
        import_path: ShaderImport::Custom(format!("antumbra::forward::{path}")),
        additional_imports: original.additional_imports.clone(),
        shader_defs: original.shader_defs.clone(),
        file_dependencies: original.file_dependencies.clone(),
        ..extended
    })
}
