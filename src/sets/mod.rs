//! The sets of a frame: which objects are drawn, which objects each light lights, and which casters matter to
//! it.
//!
//! All sets are bitsets over the dense index of [`Objects`], so that I = V ∩ L is a word-wise AND.
//!
//! | set | holds | written by | error allowed |
//! | --- | --- | --- | --- |
//! | F [`FrustumSet`] | objects whose bounds touch the view frustum, occluded or not | [`collect_frustum_set`] | may keep too many |
//! | V [`VisibleSet`] | F without objects that are occluded from the camera | [`collect_visible_set`] | may keep too many |
//! | L [`LightSets::l`] | objects within the light's volume ([`LightSets::reach`], by [`collect_light_sets`]) that are not occluded from the light | [`collect_light_occlusion`] | may keep too many |
//! | I [`LightSets::i`] | objects that the light pass draws: V ∩ L, drawn and affected, without objects whose visible part ([`VisibleParts`]) is dark. If I is empty, the light is skipped | [`collect_illumination`] | may keep too many |
//! | S [`LightSets::s`] | casters in L that cast for the light and whose shadow can reach a receiver of I | [`collect_shadow_sets`] | may keep too many, never drops one that matters |
//!
//! S depends on F and the light's hulls but not on V, because a hidden caster can still throw its shadow into
//! view (chapter 15, figure 15-2).
//!
//! Beside the sets, [`collect_view`] writes [`View`], and [`collect_illumination`] writes [`ScissorRect`] and
//! [`DepthBounds`].
//!
//! The index is in spatial order, so that a word of a bitset stands for 64 neighbours with a box around them
//! ([`Clusters`]). Every set is found by testing boxes around boxes first and objects last, so its cost is in
//! proportion to what it touches. If there is more than one thread (bevy's `ComputeTaskPool`), lights and
//! pieces of the index are shared among them, with the same result.
//!
//! Each step recomputes only what its inputs changed. A frame in which nothing moved computes no set and
//! allocates nothing ([`SetWork`] counts the work).
//!
//! Limits: coordinates are clamped to ±1e15 m. Bounds grow by eight `f32` epsilons of their coordinates, so
//! 1000 km from the origin the sets are about a metre too large, and still never drop anything.
//!
//! Source: O'Rorke 2004, "Managing Visibility for Per-Pixel Lighting", GPU Gems ch. 15; McGuire 2004,
//! "Efficient Shadow Volume Rendering", GPU Gems ch. 9; Everitt & Kilgard 2003, "Optimized Stencil Shadow
//! Volumes".

pub(crate) mod index;
pub(crate) mod light;
pub(crate) mod occlusion;
pub(crate) mod report;
pub(crate) mod view;
pub(crate) mod work;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleConfigs;
use bevy_ecs::system::ScheduleSystem;

pub use index::box_tests::Touch;
pub use index::boxes::Boxes;
pub use index::clusters::{Clusters, Found};
pub use index::collect_objects::collect_objects;
pub use index::objects::Objects;
pub use light::clearance::{LightClearance, Surroundings};
pub use light::companion::{ActsOn, CompanionOf, CompanionPart, LeftObjects, ObjectFilter};
pub use light::depth_bounds::{DepthBounds, shadow_depth_range};
pub use light::frame_light::{FrameLight, LightHulls, LightRegion, LightSets};
pub use light::frame_lights::{FrameLights, SkippedLight, collect_frame_lights};
pub use light::illumination::collect_illumination;
pub use light::light_occlusion::{LightOcclusion, collect_light_occlusion};
pub use light::light_volume::LightVolume;
pub use light::lit_region::LitRegion;
pub use light::placing::Shining;
pub use light::reach::collect_light_sets;
pub use light::scissor::ScissorRect;
pub use light::shadow::collect_shadow_sets;
pub use light::technique::{LightTechnique, NeededSilhouettes, Needs};
pub use occlusion::{
    AutoOccluders, CellIssue, Cells, Occluders, OcclusionSettings, collect_cells, collect_occluders,
};
pub use view::frame_view::{View, ViewData, ViewportSize, collect_view};
pub use view::frustum::{FrustumSet, collect_frustum_set};
pub use view::inverted_hulls::{InvertedHulls, find_inverted_hulls};
pub use view::invisible::{InvisibleObjects, find_invisible_objects};
pub use view::left_out::leave_out_submeshes;
pub use view::screen::{Projector, ScreenBounds};
pub use view::seen_into::{SeeThrough, SeenInto, collect_seen_into};
pub use view::stored_depth::ViewDepth;
pub use view::view_depth::{DepthReach, begin_depth_reach, fit_view_depth};
pub use view::visible::{CameraOcclusion, VisibleSet, collect_visible_set};
pub use view::visible_parts::VisibleParts;
pub use work::SetWork;

use crate::scene::changes::{AppearanceCount, count_appearances};
use crate::scene::{CulledCasters, FaceCulling, ObjectChurn};

/// Inserts the resources of the sets that are missing.
pub fn init_set_resources(world: &mut World) {
    world.init_resource::<SetWork>();
    world.init_resource::<ObjectChurn>();
    world.init_resource::<AppearanceCount>();
    world.init_resource::<InvertedHulls>();
    world.init_resource::<InvisibleObjects>();
    world.init_resource::<FaceCulling>();
    world.init_resource::<CulledCasters>();
    world.init_resource::<Objects>();
    world.init_resource::<ViewportSize>();
    world.init_resource::<View>();
    world.init_resource::<DepthReach>();
    world.init_resource::<FrustumSet>();
    world.init_resource::<OcclusionSettings>();
    world.init_resource::<Occluders>();
    world.init_resource::<Cells>();
    world.init_resource::<CameraOcclusion>();
    world.init_resource::<VisibleSet>();
    world.init_resource::<VisibleParts>();
    world.init_resource::<FrameLights>();
    world.init_resource::<LightClearance>();
    world.init_resource::<LightOcclusion>();
}

/// The systems of the sets, chained. They belong in `AntumbraSystems::CollectSets`.
pub fn collect_sets() -> ScheduleConfigs<ScheduleSystem> {
    (
        count_appearances, // once for all that collect appearances
        begin_depth_reach,
        collect_view,
        find_invisible_objects, // what has no alpha is neither drawn nor casts
        find_inverted_hulls,    // what is culled as a whole does not cast
        leave_out_submeshes,    // both of them, where only parts of an object are meant
        collect_objects,
        collect_frustum_set,
        (collect_cells, collect_occluders),
        collect_visible_set, // what the camera does not see costs nothing from here on
        collect_frame_lights,
        collect_light_sets,
        collect_light_occlusion, // what a light does not see is dark already
        collect_illumination,    // also scissor and depth bounds: an empty one skips the light
        collect_shadow_sets,     // last, because it depends on which receivers are left
    )
        .chain()
}
