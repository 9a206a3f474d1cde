//! The conventions of the whole crate, written once. `shaders/common/conventions.wgsl` mirrors the
//! constants that WGSL needs too (`tests/layout_contract.rs` holds the two equal).
//!
//! - **Space**: right-handed, Y up, cameras and lights look along local −Z. Metres, radians.
//! - **Matrices** are named `b_from_a` and multiply column vectors; points carry their space in their name
//!   (`eye_world`, `light_local`).
//! - **Depth** is reversed and infinite: `z_clip = near`, `w_clip = −z_view`, so depth is `near / distance`:
//!   1 on the near plane, 0 at infinity, and a vertex with `w = 0` lands exactly on 0. Orthographic views have a linear
//!   depth from 1 to 0, with an end beyond all that is drawn ([`ViewDepth`](crate::sets::ViewDepth)).
//! - **Winding**: a triangle's front is where its corners appear counter-clockwise.
//! - **Light points are homogeneous**: `w = 1` a position, `w = 0` the direction *towards* the light.
//! - **Visibility** is 1 where a surface point sees the whole light and 0 where it sees none.
//! - **Intensity** is candela (luminous intensity); lux for directional lights.

/// Depth of the near plane in normalised device coordinates.
pub const DEPTH_NEAR: f32 = 1.0;

/// Depth at infinity or at the end of an orthographic view, and the clear value of the depth buffer.
pub const DEPTH_INFINITY: f32 = 0.0;

/// Largest finite radiance that the half floats of the radiance target hold.
pub const RADIANCE_MAX: f32 = 65504.0;

/// How near to a light surfaces do not block it, as a share of its reach: the default of
/// [`LightClearance`](crate::silhouettes::LightClearance), of the near plane of maps, and of where the ray caster ends its rays.
/// `f32` tells positions apart to 10⁻⁷ of their coordinates, editors print them to 10⁻⁶.
pub const LIGHT_CLEARANCE: f32 = 1e-5;

/// Stencil count of a surface point that no shadow volume covers.
pub const STENCIL_LIT: u32 = 0;

/// Stencil bit that marks pixels whose depth lies inside the light's depth bounds.
pub const STENCIL_IN_BOUNDS: u32 = 0x80;

/// Stencil bits that count shadow volumes, modulo 128.
pub const STENCIL_COUNT_MASK: u32 = 0x7f;

/// Triangles of one cluster of an [`EdgeMesh`](crate::geometry::edge_mesh::EdgeMesh): one facing word.
pub const CLUSTER_TRIANGLES: usize = 64;
