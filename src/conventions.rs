//! The conventions of the whole crate, written once. `shaders/common/conventions.wgsl` mirrors the constants
//! that WGSL also needs; `tests/gpu/layout_contract.rs` holds the two equal.
//!
//! - **Space** is right-handed with Y up. Cameras and lights look along local −Z. Lengths are in metres,
//!   angles in radians.
//! - **Matrices** are named `b_from_a` and multiply column vectors. Points carry their space in their name
//!   (`eye_world`, `light_local`).
//! - **Depth** is reversed and infinite: `z_clip = near` and `w_clip = −z_view`, so depth is
//!   `near / distance`. It is 1 on the near plane and 0 at infinity, and a vertex with `w = 0` lands exactly
//!   on 0. The depth of an orthographic view runs linearly from 1 to 0 and ends beyond everything drawn
//!   ([`ViewDepth`](crate::sets::ViewDepth)).
//! - **Winding**: the front of a triangle is the side from which its corners appear counter-clockwise.
//! - **Light points are homogeneous**: with `w = 1` they are a position, with `w = 0` the direction *towards*
//!   the light.
//! - **Visibility** is 1 where a surface point sees the whole light and 0 where it sees none of it.
//! - **Intensity** is luminous intensity in candela; for directional lights it is illuminance in lux.

/// Depth of the near plane in normalised device coordinates.
pub const DEPTH_NEAR: f32 = 1.0;

/// Depth at infinity or at the end of an orthographic view. It is also the clear value of the depth buffer.
pub const DEPTH_INFINITY: f32 = 0.0;

/// Largest finite radiance that the half floats of the radiance target can hold.
pub const RADIANCE_MAX: f32 = 65504.0;

/// Distance from a light within which surfaces do not block it, as a share of the size of its
/// [`Surroundings`](crate::sets::Surroundings): the default of [`LightClearance`](crate::sets::LightClearance), which the
/// ray caster uses too. It lies above the precision of `f32` positions (10⁻⁷ of their coordinates) and of editors
/// (10⁻⁶), and leaves room between a lamp that is a hundredth of a millimetre behind a surface, which is free, and one
/// that is a millimetre behind it in a room, which is not.
pub const LIGHT_CLEARANCE: f32 = 4e-5;

/// Stencil count of a surface point that no shadow volume covers.
pub const STENCIL_LIT: u32 = 0;

/// Stencil bit that marks pixels whose depth lies inside the light's depth bounds.
pub const STENCIL_IN_BOUNDS: u32 = 0x80;

/// Stencil bits that count shadow volumes, modulo 128.
pub const STENCIL_COUNT_MASK: u32 = 0x7f;

/// Number of triangles in a full cluster of an [`EdgeMesh`](crate::geometry::edge_mesh::EdgeMesh). One facing
/// word has a bit for each.
pub const CLUSTER_TRIANGLES: usize = 64;
