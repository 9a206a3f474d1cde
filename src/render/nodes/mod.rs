//! The passes that no technique owns, one file each. Their shaders are in `shaders/passes/`.

pub(crate) mod ambient;
pub(crate) mod blended;
pub(crate) mod darker_mask;
pub(crate) mod depth_copy;
pub(crate) mod front_layer;
pub(crate) mod host_depth;
pub(crate) mod host_select;
pub(crate) mod host_weights;
#[cfg_attr(
    not(feature = "bevy"),
    allow(dead_code, reason = "Bevy's forward meshes alone read kept visibility")
)]
pub(crate) mod keep_visibility;
pub(crate) mod light_accumulate;
pub(crate) mod light_begin;
pub(crate) mod light_function;
pub(crate) mod pipelines;
pub(crate) mod receiver_plane;
pub(crate) mod surface_pass;
pub(crate) mod surfaces;
pub(crate) mod tonemap;
pub(crate) mod visibility;
