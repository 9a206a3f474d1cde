//! The part of a light that its slices depend on.

use glam::{DVec2, DVec3};

use super::component::OcclusionTexture;
use crate::scene::LightKind;
use crate::sets::FrameLight;

/// Half of the side of a square as large as a disc of radius 1.
const SQUARE_OF_DISC: f64 = 0.886_226_925_452_758;

/// The part of a light that its pictures depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicedLight {
    /// Position of the light; for a directional light any point.
    pub origin: DVec3,
    /// Axes of the light: right, up, the direction in which it shines.
    pub axes: [DVec3; 3],
    /// Half of the kernel's sides on the light, metres; tangents for a directional light.
    pub half: DVec2,
    /// Kind of the light.
    pub kind: SlicedKind,
}

/// Kinds of lights with slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlicedKind {
    /// The light shines to one side, in the direction of its third axis.
    Rect,
    /// The light shines in all directions.
    Sphere,
    /// The light shines in parallel along its third axis.
    Directional,
}

impl SlicedLight {
    /// Returns the place and extent from which a light's shadows are cast.
    pub(super) fn new(light: &FrameLight, settings: &OcclusionTexture) -> Self {
        let emitter = &light.emitter;
        let mut axes = light.shining.axes;
        let point = emitter.point.truncate();
        if emitter.point.w == 0.0 {
            let z = -point.normalize();
            let along = axes[2].dot(z);
            if along < 1.0 - 1e-12 {
                let (x, y) = z.any_orthonormal_pair();
                axes = [x, y, z];
            }
            let tangent = (f64::from(settings.angle_deg) * 0.5).to_radians().tan() * SQUARE_OF_DISC;
            return Self {
                origin: DVec3::ZERO,
                axes,
                half: DVec2::splat(tangent),
                kind: SlicedKind::Directional,
            };
        }
        let (half, kind) = match light.light.kind {
            LightKind::Rect { .. } => {
                let sides = emitter.half_sides.map(|side| side.length());
                let axis = |side: DVec3, own: DVec3| side.try_normalize().unwrap_or(own);
                let [x, y] = [0, 1].map(|side| axis(emitter.half_sides[side], axes[side]));
                axes = [x, y, axes[2]];
                (DVec2::from_array(sides), SlicedKind::Rect)
            }
            _ => (DVec2::splat(emitter.radius * SQUARE_OF_DISC), SlicedKind::Sphere),
        };
        Self {
            origin: point,
            axes,
            half,
            kind,
        }
    }

    /// Half of the sides of the largest kernel at a depth, for receivers no farther than `farthest`, metres.
    ///
    /// Source: Eisemann & Décoret 2008, "Occlusion Textures for Plausible Soft Shadows", eq. 4.
    pub fn kernel_half(&self, plane: f64, farthest: f64) -> DVec2 {
        match self.kind {
            SlicedKind::Directional => self.half * (farthest - plane).max(0.0),
            SlicedKind::Rect | SlicedKind::Sphere => {
                self.half * (1.0 - plane / farthest.max(1e-30)).clamp(0.0, 1.0)
            }
        }
    }
    /// How much longer kernels are that see the light at an angle, for the tangent of that angle along each axis. A sphere
    /// that is seen at an angle casts a longer cone on a slice.
    pub fn lengthening(&self, slope: DVec2) -> DVec2 {
        match self.kind {
            SlicedKind::Sphere => DVec2::new(1.0_f64.hypot(slope.x), 1.0_f64.hypot(slope.y)),
            SlicedKind::Rect | SlicedKind::Directional => DVec2::ONE,
        }
    }
}
