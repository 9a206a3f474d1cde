//! Whatever needs a GPU: frames against the ray caster, shaders against what Rust says of them, input that is bad.

mod area_lights;
mod bad_input;
mod blended_receivers;
mod cpu_gpu_parity;
mod faults;
mod harness;
mod hosted;
mod layout_contract;
mod light_model;
mod light_textures;
mod maps;
mod mask_contract;
mod occlusion_pictures;
mod orthographic;
mod penumbra_wedge;
mod receivers;
mod recorder_stages;
mod reference_match;
mod reports;
mod set_sizes;
mod shader_validation;
mod simple_scenes;
mod steady_frame;
mod stencil_identity;
mod technique_changes;
mod third_party;
