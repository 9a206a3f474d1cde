//! The view of the frame.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DMat4, DVec3, UVec2};

use super::stored_depth::ViewDepth;
use crate::geometry::{Frustum, FrustumShape};
use crate::scene::Camera;
use crate::scene::camera::CameraTurns;
use crate::sets::work::SetWork;

/// Size of the picture, pixels. The owner of the render target writes it. With 0 × 0 (the default) nothing is
/// drawn.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewportSize(pub UVec2);

/// The view of the frame. Written by [`collect_view`].
#[derive(Resource, Clone, Debug, Default)]
pub struct View {
    /// The view, or `None` without a usable camera or with a picture of size zero. All sets are then empty.
    pub data: Option<ViewData>,
    /// Increases when `data` changed.
    pub generation: u64,
    seen: Option<Input>,
}

/// The inputs that determine a view.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Input {
    entity: Entity,
    camera: Camera,
    world_from_camera: GlobalTransform,
    viewport: UVec2,
}

/// A view that can be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewData {
    /// Entity of the camera.
    pub camera: Entity,
    /// The region that the camera sees.
    pub frustum: Frustum,
    /// Transform from world to view space.
    pub view_from_world: DMat4,
    /// Reversed projection, view to clip space. In an orthographic view its depth is final only from the set
    /// `PrepareGpu` on.
    pub clip_from_view: DMat4,
    /// Transform from world to clip space.
    pub clip_from_world: DMat4,
    /// Position of the camera in world space, metres.
    pub eye: DVec3,
    /// Corners of the near rectangle in world space, metres. Bit 0 of the index is right, bit 1 is top.
    pub near_corners: [DVec3; 4],
    /// Distance of the near plane, in units of view space.
    pub near: f64,
    /// How depth is stored.
    pub depth: ViewDepth,
    /// Whether the view mirrors, so that front faces appear clockwise.
    pub mirrored: bool,
    /// Size of the picture, pixels. Neither component is 0.
    pub viewport: UVec2,
}

impl ViewData {
    /// The view of a camera. `None` if its numbers, its transform or the picture's size make no view.
    pub fn new(
        entity: Entity,
        camera: &Camera,
        world_from_camera: &GlobalTransform,
        viewport: UVec2,
    ) -> Option<Self> {
        if !camera.is_valid() || viewport.x == 0 || viewport.y == 0 {
            return None;
        }
        let view_from_world = Camera::view_from_world(world_from_camera)?;
        let affine = world_from_camera.affine();
        let axis = |v: glam::Vec3A| glam::Vec3::from(v).as_dvec3();
        let (half_right, half_up) = camera.half_extent_at_unit_distance();
        let shape = FrustumShape {
            eye: axis(affine.translation),
            right: axis(affine.matrix3.x_axis),
            up: axis(affine.matrix3.y_axis),
            forward: -axis(affine.matrix3.z_axis),
            half_right,
            half_up,
            center: -camera.shift.as_dvec2(),
            near: f64::from(camera.near),
        };
        let near = shape.near;
        let (frustum, depth) = match camera.orthographic {
            None => (Frustum::new(&shape)?, ViewDepth::Infinite { near }),
            Some(orthographic) => {
                let far = f64::from(orthographic.far);
                (
                    Frustum::orthographic(&shape, far)?,
                    ViewDepth::Finite { near, far },
                )
            }
        };
        let clip_from_view = camera.clip_from_view();
        let clip_from_world = clip_from_view * view_from_world;
        clip_from_world.is_finite().then(|| Self {
            camera: entity,
            eye: frustum.eye(),
            near_corners: frustum.near_corners(),
            mirrored: frustum.is_mirrored(),
            frustum,
            view_from_world,
            clip_from_view,
            clip_from_world,
            near,
            depth,
            viewport,
        })
    }

    /// Whether all lines of sight are parallel.
    pub fn is_orthographic(&self) -> bool {
        self.frustum.far().is_some()
    }

    /// Changes how the depth of an orthographic view is stored.
    pub(in crate::sets) fn set_depth(&mut self, depth: ViewDepth) {
        self.depth = depth;
        if let ViewDepth::Finite { near, far } = depth {
            self.clip_from_view.z_axis.z = 1.0 / (far - near);
            self.clip_from_view.w_axis.z = far / (far - near);
            self.clip_from_world = self.clip_from_view * self.view_from_world;
        }
    }
}

/// Takes the view from the entity with the lowest index among those with a usable [`Camera`].
///
/// Set: `CollectSets`. Reads [`Camera`], `GlobalTransform` and [`ViewportSize`]. A camera with
/// [`IgnoresScale`](crate::scene::IgnoresScale) is placed without the scale of its transform. The lowest index
/// belongs to the camera that was spawned first, unless indices were reused; it does not depend on the order of
/// the query. If nothing changed, this computes nothing.
pub fn collect_view(
    mut view: ResMut<View>,
    mut work: ResMut<SetWork>,
    viewport: Res<ViewportSize>,
    cameras: Query<(Entity, &Camera, &GlobalTransform)>,
    turns: CameraTurns,
) {
    let usable = |(_, camera, world_from_camera): &(Entity, &Camera, GlobalTransform)| {
        camera.is_valid() && Camera::view_from_world(world_from_camera).is_some()
    };
    let chosen = cameras
        .iter()
        .map(|(entity, camera, at)| (entity, camera, turns.place(entity, at)))
        .filter(usable)
        .min_by_key(|&(entity, _, _)| entity.index_u32())
        .map(|(entity, camera, world_from_camera)| Input {
            entity,
            camera: *camera,
            world_from_camera,
            viewport: viewport.0,
        });
    if chosen == view.seen {
        return;
    }
    view.seen = chosen;
    view.data = chosen.and_then(|input| {
        ViewData::new(
            input.entity,
            &input.camera,
            &input.world_from_camera,
            input.viewport,
        )
    });
    view.generation += 1;
    work.views += 1;
}
