//! A material of a game's own, drawn deferred for cameras that show our shadows: stripes on Bevy's standard material.
//!
//! ```sh
//! cargo run --features bevy-window --example bevy_extension
//! cargo run --features bevy --example bevy_extension -- --headless --out DIR
//! ```
//!
//! The second command writes `DIR/bevy_extension.png`. The same shader draws both ways: forward for cameras without
//! `AntumbraCamera`, deferred for those with it. Without `deferred_fragment_shader` the material would keep its look,
//! show no shadows of ours, and be named in the log.

use antumbra::bevy_adapter::prelude::*;
use bevy::asset::uuid_handle;
use bevy::pbr::{ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::{Shader, ShaderRef};

#[path = "support/bevy_headless.rs"]
pub mod bevy_headless;

/// Handle of the shader of [`Stripes`].
pub const SHADER: Handle<Shader> = uuid_handle!("3b1f0f53-9a0c-4b0e-9d5c-0c2c3f1c7a55");

/// Red and green stripes.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug, Default)]
pub struct Stripes {
    /// Stripes per metre in x.
    #[uniform(100)]
    pub density: Vec4,
}

impl MaterialExtension for Stripes {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }
    fn deferred_fragment_shader() -> ShaderRef {
        SHADER.into()
    }
}

/// The shader of both ways.
pub const WGSL: &str = "
#import bevy_pbr::pbr_fragment::pbr_input_from_standard_material
#ifdef PREPASS_PIPELINE
#import bevy_pbr::{prepass_io::{VertexOutput, FragmentOutput}, pbr_deferred_functions::deferred_output}
#else
#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#import bevy_pbr::pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing}
#endif

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> density: vec4<f32>;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var surface = pbr_input_from_standard_material(in, is_front);
    let red = fract(in.world_position.x * density.x) < 0.5;
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

/// Adds the material to an app with Bevy's plugins.
pub fn add_stripes(app: &mut App) {
    let shader = Shader::from_wgsl(WGSL, "stripes.wgsl");
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    shaders.insert(&SHADER, shader).expect("a handle of its own");
    app.add_plugins(MaterialPlugin::<ExtendedMaterial<StandardMaterial, Stripes>>::default());
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<ExtendedMaterial<StandardMaterial, Stripes>>>,
) {
    let striped = materials.add(ExtendedMaterial {
        base: StandardMaterial::default(),
        extension: Stripes {
            density: Vec4::splat(3.0),
        },
    });
    let floor = meshes.add(Plane3d::default().mesh().size(10.0, 10.0));
    let cube = meshes.add(Cuboid::default());
    commands.spawn((Mesh3d(floor), MeshMaterial3d(striped.clone())));
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    commands.spawn((Mesh3d(cube), MeshMaterial3d(striped), place));
    let light = Transform::from_xyz(2.0, 4.0, 1.0);
    commands.spawn((PointLight::default(), StencilVolume::default(), light));
    let camera = Transform::from_xyz(-2.5, 4.5, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((Camera3d::default(), Msaa::Off, AntumbraCamera, camera));
}

fn main() {
    let mut app = bevy_headless::app_of_arguments("bevy_extension");
    add_stripes(&mut app);
    app.add_plugins(AntumbraPlugin).add_systems(Startup, setup);
    bevy_headless::run(app);
}
