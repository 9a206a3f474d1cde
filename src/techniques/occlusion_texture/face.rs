//! One picture of the casters: where its slices end, and from where it is drawn.
//!
//! Light space has its origin at the light, x to the right, y up and z away from the light. For a directional light the
//! origin is the middle of the scene.

use glam::{DMat4, DVec2, DVec3, DVec4, Vec4};

use super::component::MOST_SLICES;
use super::kernel::WIDER;
use super::records::OcclusionFace;
use super::sliced_light::SlicedLight;
use crate::techniques::maps::face::{FaceProjection, MapFace};

/// Depth at which the slices of a face without casters end, metres: beyond every receiver.
const NOWHERE: f64 = 1e30;

/// The slices of one picture, in light space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slices {
    /// Depth at which the first slice begins, metres.
    pub top: f64,
    /// Depth at which each slice ends, metres.
    pub bottoms: [f64; MOST_SLICES as usize],
    /// Number of slices.
    pub count: usize,
}

impl Slices {
    /// No slice casts on any receiver.
    pub const NONE: Self = Self {
        top: NOWHERE,
        bottoms: [NOWHERE; MOST_SLICES as usize],
        count: 1,
    };

    /// Cuts a range of depths into slices. `weight` is that of the component: 0 cuts evenly, 1 makes slices thinner with
    /// the distance from the light.
    pub fn new(range: [f64; 2], count: u32, weight: f64) -> Self {
        let [top, bottom] = range;
        let count = count.clamp(1, MOST_SLICES) as usize;
        let bottoms = std::array::from_fn(|slice| {
            let share = ((slice + 1) as f64 / count as f64).min(1.0);
            top + (bottom - top) * (share + weight * share * (1.0 - share))
        });
        Self { top, bottoms, count }
    }

    /// Thickness of an imaginary slice behind the last, metres: the depth over which the last slice fades in.
    pub fn thickness_behind(&self) -> f64 {
        let before = match self.count {
            0 | 1 => self.top,
            count => self.bottoms[count - 2],
        };
        self.bottoms[self.count - 1] - before
    }

    /// Returns the least depth at which a caster at some depth is taken to be: the middle of its slice.
    pub fn least_plane(&self, depth: f64) -> f64 {
        let last = self.count - 1;
        let slice = self.bottoms[..last].iter().position(|bottom| depth <= *bottom);
        let slice = slice.unwrap_or(last);
        let top = slice
            .checked_sub(1)
            .map_or(self.top, |before| self.bottoms[before]);
        0.5 * (top + self.bottoms[slice])
    }
}

/// One picture of the casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceFace {
    /// Origin of light space, world space, metres.
    pub origin: DVec3,
    /// Axes of light space, world space: right, up, away from the light.
    pub axes: [DVec3; 3],
    /// Scale of x and y, before the division.
    pub scale: DVec2,
    /// Offset of x and y in normalized device coordinates.
    pub offset: DVec2,
    /// The divisor at depth z is `x z + y`: `z + d` for a centre of projection `d` metres behind the light, 1 for a
    /// directional light.
    pub divisor: DVec2,
    /// The slices.
    pub slices: Slices,
    /// Depth of the farthest object, metres.
    pub farthest: f64,
}

impl SliceFace {
    /// Returns the sides of the largest kernel of a light, as shares of the picture's side.
    pub fn widest_kernel(&self, light: &SlicedLight) -> DVec2 {
        self.widest_at(light, self.slices.least_plane(self.slices.top))
    }

    /// Returns the sides of the largest rectangle that is looked up where depths of casters are known, as shares of the picture's
    /// side: a kernel at the nearest caster, or the surroundings of one in the middle of the first slice.
    pub fn widest_measured(&self, light: &SlicedLight) -> DVec2 {
        let nearest = self.widest_at(light, self.slices.top);
        let around = f64::from(WIDER) * self.widest_kernel(light);
        nearest.max(around).min(DVec2::ONE)
    }

    /// Returns the sides of the largest kernel at a depth, as shares of the picture's side.
    fn widest_at(&self, light: &SlicedLight, plane: f64) -> DVec2 {
        if self.slices == Slices::NONE {
            return DVec2::ZERO;
        }
        let across = light.kernel_half(plane, self.farthest) * self.scale;
        let steepest = (1.0 + self.offset.abs()) / self.scale;
        let longer = light.lengthening(steepest * (1.0 + self.divisor.y / plane));
        (across * longer / (self.divisor.x * plane + self.divisor.y)).min(DVec2::ONE)
    }

    /// Widens or narrows the empty border of a picture: `from` and `to` are its width as a share of the picture's side.
    pub fn change_guard(&mut self, from: f64, to: f64) {
        let factor = (1.0 - 2.0 * to) / (1.0 - 2.0 * from);
        self.scale *= factor;
        self.offset *= factor;
    }

    /// Transforms a point from world space to light space.
    pub fn light_from_world(&self, point: DVec3) -> DVec3 {
        let from_origin = point - self.origin;
        let [x, y, z] = self.axes;
        DVec3::new(x.dot(from_origin), y.dot(from_origin), z.dot(from_origin))
    }

    /// Projects a point of light space to normalized device coordinates.
    pub fn project(&self, point: DVec3) -> DVec2 {
        let divisor = self.divisor.x * point.z + self.divisor.y;
        point.truncate() * self.scale / divisor + self.offset
    }

    /// Whether the picture shows the scene as in a mirror, so that fronts are drawn clockwise.
    pub fn is_mirrored(&self) -> bool {
        let [x, y, z] = self.axes;
        x.cross(y).dot(z) > 0.0
    }

    /// Returns the face as it is drawn: the third row of the clip space is the depth in metres, from which the shader
    /// chooses the slice. Nothing is clipped by depth.
    pub fn drawn(&self) -> MapFace {
        let DVec2 {
            x: slope,
            y: constant,
        } = self.divisor;
        let row = |scale: DVec3, offset: f64| (scale + DVec3::Z * (offset * slope)).extend(offset * constant);
        let rows = [
            row(DVec3::X * self.scale.x, self.offset.x),
            row(DVec3::Y * self.scale.y, self.offset.y),
            DVec4::Z,
            DVec4::new(0.0, 0.0, slope, constant),
        ];
        MapFace {
            origin: self.origin,
            axes: self.axes,
            projection: FaceProjection::Matrix {
                clip_from_face: DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose(),
                parallel: slope == 0.0,
            },
        }
    }

    /// Returns the record of the face for the GPU.
    pub fn record(&self, eye: DVec3) -> OcclusionFace {
        let [row_x, row_y, row_z] = self
            .axes
            .map(|axis| axis.extend(axis.dot(eye - self.origin)).as_vec4().to_array());
        let slices = &self.slices;
        OcclusionFace {
            row_x,
            row_y,
            row_z,
            projection: [self.scale.x, self.scale.y, self.offset.x, self.offset.y].map(|x| x as f32),
            depth: Vec4::new(
                self.divisor.x as f32,
                self.divisor.y as f32,
                slices.top as f32,
                slices.thickness_behind() as f32,
            )
            .to_array(),
            bottoms: std::array::from_fn(|group| {
                std::array::from_fn(|channel| slices.bottoms[4 * group + channel] as f32)
            }),
        }
    }
}
