//! Two extensions of Bevy's standard material, striped: one is drawn forward alone, the other in both ways.

use bevy::asset::uuid_handle;
use bevy::pbr::{ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::{Shader, ShaderRef};

const SHADER: Handle<Shader> = uuid_handle!("3b1f0f53-9a0c-4b0e-9d5c-0c2c3f1c7a55");

/// It has no deferred shader.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug, Default)]
pub struct ForwardStripes {
    #[uniform(100)]
    unused: Vec4,
}

impl MaterialExtension for ForwardStripes {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }
}

/// It has both.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug, Default)]
pub struct Stripes {
    #[uniform(100)]
    unused: Vec4,
}

impl MaterialExtension for Stripes {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }
    fn deferred_fragment_shader() -> ShaderRef {
        SHADER.into()
    }
}

/// Adds both to an app with Bevy's plugins.
pub fn add(app: &mut App) {
    let shader = Shader::from_wgsl(WGSL, "stripes.wgsl");
    app.world_mut()
        .resource_mut::<Assets<Shader>>()
        .insert(&SHADER, shader)
        .expect("the handle is ours");
    app.add_plugins((
        MaterialPlugin::<ExtendedMaterial<StandardMaterial, ForwardStripes>>::default(),
        MaterialPlugin::<ExtendedMaterial<StandardMaterial, Stripes>>::default(),
    ));
}

const WGSL: &str = "
#import bevy_pbr::pbr_fragment::pbr_input_from_standard_material
#ifdef PREPASS_PIPELINE
#import bevy_pbr::{prepass_io::{VertexOutput, FragmentOutput}, pbr_deferred_functions::deferred_output}
#else
#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#import bevy_pbr::pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing}
#endif

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var surface = pbr_input_from_standard_material(in, is_front);
    let red = fract(in.world_position.x * 3.0) < 0.5;
    surface.material.base_color = select(vec4(0.1, 0.9, 0.1, 1.0), vec4(0.9, 0.1, 0.1, 1.0), red);
#ifdef PREPASS_PIPELINE
    return deferred_output(in, surface);
#else
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(surface, apply_pbr_lighting(surface));
    return out;
#endif
}
";
