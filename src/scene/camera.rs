//! The camera component.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DMat4, DVec4, Mat4, Quat, Vec2};

/// A camera at its `GlobalTransform`, looking along local −Z. Its depth is reversed; in perspective it is
/// also infinite ([`conventions`](crate::conventions)). A transform that mirrors gives a mirrored view. If a world has several, the
/// frame shows the view of the one that was spawned first ([`collect_view`](crate::sets::collect_view)).
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform)]
pub struct Camera {
    /// Vertical field of view, radians; 0 < fov < π, default π/4. An orthographic view ignores it.
    pub vertical_fov: f32,
    /// Distance of the near plane, metres; default 0.1. It must be greater than 0 in perspective and may have
    /// any sign in an orthographic view.
    pub near: f32,
    /// Width of the picture divided by its height; greater than 0, default 16/9.
    pub aspect: f32,
    /// Offset of the picture to the right and up, in normalised device coordinates; default zero. It serves
    /// for an off-centre lens or the jitter of temporal anti-aliasing.
    pub shift: Vec2,
    /// Size of an orthographic view, or `None` (the default) for a perspective view.
    pub orthographic: Option<Orthographic>,
}

/// The parameters that replace the field of view in an orthographic view. All its lines of sight run along
/// local −Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthographic {
    /// Height of the visible region, metres; greater than 0.
    pub height: f32,
    /// Distance of the far plane, metres; greater than `near`. Objects beyond it are not seen. Of an object
    /// that the plane cuts, the part beyond it may or may not be seen and lit.
    pub far: f32,
}

/// Makes a [`Camera`] ignore the scale of its own transform and of all its parents. The product of their rotations turns
/// it, and its position is that of its `GlobalTransform`. Cameras of glTF files have this component.
///
/// A parent with a negative scale therefore moves such a camera and does not turn it. Where a root mirrors a whole scene, write
/// that root as a matrix, or keep the camera out of it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IgnoresScale;

/// Reads the transforms of cameras, and those of their parents where [`IgnoresScale`] needs them.
#[derive(SystemParam)]
pub struct CameraTurns<'w, 's> {
    marked: Query<'w, 's, (), With<IgnoresScale>>,
    chain: Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>,
}

impl CameraTurns<'_, '_> {
    /// The transform of a camera, without scale if that is ignored.
    pub fn place(&self, camera: Entity, world_from_camera: &GlobalTransform) -> GlobalTransform {
        if !self.marked.contains(camera) {
            return *world_from_camera;
        }
        let link = |entity| {
            let (transform, parent) = self.chain.get(entity).ok()?;
            Some((transform.rotation, parent.map(ChildOf::parent)))
        };
        unscaled(camera, world_from_camera, link)
    }
}

/// Returns a camera's `GlobalTransform`, without scale if it has [`IgnoresScale`]. `None` for an entity without a
/// transform.
pub fn camera_place(world: &World, camera: Entity) -> Option<GlobalTransform> {
    let world_from_camera = world.get::<GlobalTransform>(camera)?;
    if world.get::<IgnoresScale>(camera).is_none() {
        return Some(*world_from_camera);
    }
    let link = |entity| {
        let rotation = world.get::<Transform>(entity)?.rotation;
        Some((rotation, world.get::<ChildOf>(entity).map(ChildOf::parent)))
    };
    Some(unscaled(camera, world_from_camera, link))
}

/// The product of the rotations from an entity up to its root, at the entity's place. `link` gives the rotation of an entity
/// and its parent.
fn unscaled(
    camera: Entity,
    world_from_camera: &GlobalTransform,
    link: impl Fn(Entity) -> Option<(Quat, Option<Entity>)>,
) -> GlobalTransform {
    let mut rotation = Quat::IDENTITY;
    let mut next = Some(camera);
    while let Some((turn, parent)) = next.and_then(&link) {
        rotation = turn * rotation;
        next = parent;
    }
    let rotation = rotation.normalize();
    GlobalTransform::from(Transform {
        translation: world_from_camera.translation(),
        rotation: if rotation.is_finite() { rotation } else { Quat::NAN },
        ..Transform::IDENTITY
    })
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            vertical_fov: std::f32::consts::FRAC_PI_4,
            near: 0.1,
            aspect: 16.0 / 9.0,
            shift: Vec2::ZERO,
            orthographic: None,
        }
    }
}

impl Camera {
    /// An orthographic camera with the given height of the visible region and the distances of its two
    /// planes, all in metres.
    pub fn orthographic(height: f32, near: f32, far: f32, aspect: f32) -> Self {
        Self {
            near,
            aspect,
            orthographic: Some(Orthographic { height, far }),
            ..Self::default()
        }
    }

    /// Whether the numbers make a projection.
    pub fn is_valid(&self) -> bool {
        let spans = match self.orthographic {
            None => self.vertical_fov > 0.0 && self.vertical_fov < std::f32::consts::PI && self.near > 0.0,
            Some(Orthographic { height, far }) => {
                height > 0.0 && height.is_finite() && far > self.near && far.is_finite()
            }
        };
        spans
            && self.near.is_finite()
            && self.aspect > 0.0
            && self.aspect.is_finite()
            && self.shift.is_finite()
    }

    /// Half the size of the picture as (right, up), metres. In perspective it is measured at distance 1; in
    /// an orthographic view it is the same at any distance. The centre of the picture lies at minus `shift`
    /// times this half size.
    pub fn half_extent_at_unit_distance(&self) -> (f64, f64) {
        let up = match self.orthographic {
            None => (f64::from(self.vertical_fov) * 0.5).tan(),
            Some(Orthographic { height, .. }) => f64::from(height) * 0.5,
        };
        (up * f64::from(self.aspect), up)
    }

    /// The reversed projection. In perspective it is infinite, with `z_clip = near` and `w_clip = −z_view`.
    /// In an orthographic view its depth is 1 on the near plane and 0 on the far plane.
    pub fn clip_from_view(&self) -> DMat4 {
        let (right, up) = self.half_extent_at_unit_distance();
        let (near, shift) = (f64::from(self.near), self.shift.as_dvec2());
        let mut m = DMat4::ZERO;
        m.x_axis.x = 1.0 / right;
        m.y_axis.y = 1.0 / up;
        match self.orthographic {
            None => {
                m.z_axis.x = -shift.x;
                m.z_axis.y = -shift.y;
                m.z_axis.w = -1.0;
                m.w_axis.z = near;
            }
            Some(Orthographic { far, .. }) => {
                let far = f64::from(far);
                m.z_axis.z = 1.0 / (far - near);
                m.w_axis = DVec4::new(shift.x, shift.y, far / (far - near), 1.0);
            }
        }
        m
    }

    /// World to view for a camera at `world_from_camera`. `None` if that transform is singular or not finite.
    pub fn view_from_world(world_from_camera: &GlobalTransform) -> Option<DMat4> {
        let world_from_view = Mat4::from(world_from_camera.affine()).as_dmat4();
        let determinant = world_from_view.determinant();
        (determinant.is_finite() && determinant != 0.0)
            .then(|| world_from_view.inverse())
            .filter(|m| m.is_finite())
    }
}
