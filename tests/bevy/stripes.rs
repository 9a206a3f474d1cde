//! Two extensions of Bevy's standard material, striped: one is drawn forward alone, the other, which is the example's, in
//! both ways.

use bevy::pbr::{ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::ShaderRef;

#[path = "../../examples/bevy_extension.rs"]
#[allow(dead_code, reason = "its main is for the command line")]
mod example;

pub use example::Stripes;

/// It has no deferred shader.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug, Default)]
pub struct ForwardStripes {
    #[uniform(100)]
    density: Vec4,
}

impl MaterialExtension for ForwardStripes {
    fn fragment_shader() -> ShaderRef {
        example::SHADER.into()
    }
}

/// Stripes as wide as the tests want them, drawn in both ways.
pub fn both() -> ExtendedMaterial<StandardMaterial, Stripes> {
    ExtendedMaterial {
        extension: Stripes {
            density: Vec4::splat(3.0),
        },
        ..default()
    }
}

/// The same, drawn forward alone.
pub fn forward() -> ExtendedMaterial<StandardMaterial, ForwardStripes> {
    ExtendedMaterial {
        extension: ForwardStripes {
            density: Vec4::splat(3.0),
        },
        ..default()
    }
}

/// Adds both to an app with Bevy's plugins.
pub fn add(app: &mut App) {
    example::add_stripes(app);
    app.add_plugins(MaterialPlugin::<ExtendedMaterial<StandardMaterial, ForwardStripes>>::default());
}
