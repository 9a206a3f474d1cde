//! The passes that no technique owns, one file each; `shaders/passes/` has their other halves.

pub mod ambient;
pub mod blended;
pub mod depth_copy;
pub mod front_layer;
pub mod host_depth;
pub mod host_select;
pub mod light_accumulate;
pub mod light_begin;
pub mod receiver_plane;
pub mod surfaces;
pub mod tonemap;
pub mod visibility;
