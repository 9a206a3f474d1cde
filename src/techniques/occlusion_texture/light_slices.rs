//! The pictures of one light: what they show, and whether they changed.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::{DVec2, DVec3, Vec3};

use super::casters::{FrameObjects, Scratch};
use super::coarse::Coarse;
use super::component::{OcclusionTexture, SliceFilter};
use super::face::{SliceFace, Slices};
use super::filter::{DENSE_LEVEL, MOST_TAPS, level_count, reached_levels, tap_count};
use super::fit::{SliceFaces, SliceSettings, fit_faces};
use super::records::{OcclusionFace, OcclusionLight};
use super::sliced_light::{SlicedKind, SlicedLight};
use crate::sets::{FrameLight, LightVolume, Objects};

/// Texels that stay empty along each side of a picture.
const GUARD_TEXELS: f64 = 2.0;

/// Returns the share of a picture's side that stays empty on each side.
fn guard(resolution: u32) -> f64 {
    GUARD_TEXELS / f64::from(resolution.max(8))
}

/// The pictures of one light.
#[derive(Clone, Debug)]
pub struct LightSlices {
    /// Entity of the light.
    pub entity: Entity,
    /// Index of the light in [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// Settings of the light.
    pub settings: OcclusionTexture,
    /// Texels along a side of a picture; 0 if the light gets no memory.
    pub resolution: u32,
    /// The pictures.
    pub faces: SliceFaces,
    /// Casters, by dense object index.
    pub casters: FixedBitSet,
    /// Those of the casters that fill the next slice too.
    pub closing: FixedBitSet,
    /// The closed casters: every ray enters them through a front and leaves them through a back. Combinations that take slices
    /// to be independent draw their fronts alone: a ray would otherwise count twice, if front and back lie in different slices.
    pub solid: FixedBitSet,
    /// Whether the pictures are too coarse for most casters at the resolution that was asked for.
    pub coarse: Option<Coarse>,
    /// Whether the pictures are looked up in this frame.
    pub is_active: bool,
    /// Changes when the pictures must be drawn again.
    pub revision: u64,
    /// Resolution for whose texels the borders of the pictures are wide enough.
    guarded: u32,
    /// Set L of the light, when the pictures were fitted.
    reached: FixedBitSet,
    /// Layers whose casters cast for the light.
    casts_for: u32,
    /// [`ActsOn::revision`](crate::sets::ActsOn::revision) of the light.
    acts_on: u64,
    flags: u64,
    volume: LightVolume,
    sliced: Option<SlicedLight>,
}

impl LightSlices {
    /// Makes the state of a light without pictures.
    pub(super) fn new(entity: Entity) -> Self {
        Self {
            entity,
            light: 0,
            settings: OcclusionTexture::default(),
            resolution: 0,
            faces: SliceFaces::new(),
            casters: FixedBitSet::new(),
            closing: FixedBitSet::new(),
            solid: FixedBitSet::new(),
            coarse: None,
            is_active: false,
            revision: 0,
            guarded: 0,
            reached: FixedBitSet::new(),
            casts_for: 0,
            acts_on: 0,
            flags: 0,
            volume: LightVolume::Infinite,
            sliced: None,
        }
    }

    /// Takes over settings, casters and place of the light. Returns whether the pictures change.
    pub(super) fn follow(
        &mut self,
        light: &FrameLight,
        settings: &OcclusionTexture,
        frame: &FrameObjects,
        scratch: &mut Scratch,
    ) -> bool {
        let objects = frame.objects;
        let sliced = SlicedLight::new(light, settings);
        let is_same = self.revision != 0
            && self.settings == *settings
            && self.sliced == Some(sliced)
            && self.volume == light.volume
            && self.casts_for == light.selection.casts_for
            && self.acts_on == light.acts_on.revision
            && self.flags == objects.flags_generation
            && self.reached == light.sets.l
            && self.reached.is_disjoint(&objects.moved)
            && self.casters.is_disjoint(frame.exchanged);
        if is_same {
            return false;
        }
        self.settings = *settings;
        self.sliced = Some(sliced);
        self.volume = light.volume;
        self.casts_for = light.selection.casts_for;
        self.acts_on = light.acts_on.revision;
        self.flags = objects.flags_generation;
        self.reached.clone_from(&light.sets.l);
        let sun = (f64::from(settings.angle_deg) * 0.5).to_radians().sin();
        scratch.collect(light, sun, frame, &mut self.casters);
        self.closing.clear();
        self.closing.grow(objects.len());
        for object in self.casters.ones() {
            let closes = objects.layers[object] & self.settings.close_leaks != 0;
            self.closing.set(object, closes);
        }
        self.guarded = settings.resolution;
        let slice_settings = SliceSettings {
            count: settings.slices,
            weight: f64::from(settings.weight),
            guard: guard(self.guarded),
        };
        self.faces = fit_faces(&sliced, &slice_settings, &scratch.scene);
        self.coarse = Coarse::new(&self.faces, &scratch.scene, settings.resolution);
        self.solid.clear();
        self.solid.grow(objects.len());
        for object in self.casters.ones() {
            let is_solid = (frame.is_closed)(objects.entities[object]) && self.is_clear_of(objects, object);
            self.solid.set(object, is_solid);
        }
        true
    }

    /// Takes over the resolution that the light gets, and makes the empty borders of the pictures as wide as its texels
    /// need. Returns whether the pictures change.
    pub(super) fn set_resolution(&mut self, resolution: u32) -> bool {
        if resolution > 0 && self.guarded != resolution {
            let (from, to) = (guard(self.guarded), guard(resolution));
            for face in &mut self.faces {
                face.change_guard(from, to);
            }
            self.guarded = resolution;
        }
        let changes = self.resolution != resolution;
        self.resolution = resolution;
        changes
    }

    /// Whether a picture may show an object. One of six pictures around a sphere shows a pyramid.
    pub fn shows(&self, face: &SliceFace, objects: &Objects, object: usize) -> bool {
        let (center, half) = objects.boxes.center_half(object);
        let [x, y, z] = face.axes.map(|axis| {
            let (middle, half) = (axis.dot(center - face.origin), axis.abs().dot(half));
            DVec2::new(middle - half, middle + half)
        });
        let widest = z.y + face.divisor.y;
        let is_beside = |across: DVec2| across.x >= widest || across.y <= -widest;
        self.faces.len() == 1 || !(z.y <= 0.0 || is_beside(x) || is_beside(y))
    }

    /// Whether a closed caster fills slices of a picture: overlaps are measured, and the top of a slice may lie inside of the
    /// caster. A ray may then enter and leave it through other slices.
    pub fn fills(&self, face: &SliceFace, objects: &Objects, object: usize) -> bool {
        let (center, half) = objects.boxes.center_half(object);
        let z = face.axes[2];
        let (middle, half) = (z.dot(center - face.origin), z.abs().dot(half));
        let is_inside = |top: &f64| (top - middle).abs() < half;
        let inner = &face.slices.bottoms[..face.slices.count - 1];
        self.settings.measures() && (is_inside(&face.slices.top) || inner.iter().any(is_inside))
    }

    /// Whether an object lies wholly before the centre of projection and the light, so that every ray from there enters it
    /// through a front.
    fn is_clear_of(&self, objects: &Objects, object: usize) -> bool {
        let (center, half) = objects.boxes.center_half(object);
        let Some(face) = self.faces.first() else {
            return false;
        };
        if face.divisor.x == 0.0 {
            return true;
        }
        let from_light = center - face.origin;
        if self.faces.len() == 1 {
            let z = face.axes[2];
            return z.dot(from_light) - z.abs().dot(half) > 0.0;
        }
        let distance = (from_light.abs() - half).max(DVec3::ZERO).length();
        distance > 3.0 * face.divisor.y
    }

    /// Bytes of all pictures of a light for each squared resolution.
    pub fn bytes_per_square(&self) -> u64 {
        let groups = self.faces.len() as u64 * u64::from(self.settings.groups());
        // Dense levels, and a third of a level of 8 bytes for the sparse ones, rounded up.
        let n_buffers = |bytes: u64| bytes * u64::from(DENSE_LEVEL + 1) + 3;
        let (covers, precise, shared) = match self.settings.filter {
            SliceFilter::NBuffers => (n_buffers(4), n_buffers(8), 0),
            SliceFilter::Mipmaps => (8 + 3, 8 + 3, 0),
            SliceFilter::SummedAreas => (24, 24, 16),
        };
        // Overlaps need unions, and depths with a coverage that is as precise.
        let sets = if self.settings.measures() {
            covers + 2 * precise
        } else {
            covers
        };
        groups * (sets + shared)
    }

    /// Returns the record of the light for the GPU. `depths` are the nearest and farthest depth that it reaches.
    pub fn record(&self, light: &FrameLight, eye: DVec3, depths: (f32, f32)) -> OcclusionLight {
        let mut faces = [OcclusionFace::default(); 6];
        for (record, face) in faces.iter_mut().zip(&self.faces) {
            *record = face.record(eye);
        }
        let half = self.sliced.map_or(DVec2::ZERO, |sliced| sliced.half);
        let emitter = &light.emitter;
        let [right, up] = emitter.half_sides.map(|side| side.as_vec3());
        let point = emitter.point;
        let point_relative = (point.truncate() - eye * point.w).extend(point.w);
        let is_sphere = self
            .sliced
            .is_some_and(|sliced| sliced.kind == SlicedKind::Sphere);
        let radius = match point.w {
            0.0 => (f64::from(self.settings.angle_deg) * 0.5).to_radians().sin(),
            _ => emitter.radius,
        };
        OcclusionLight {
            faces,
            kernel: [
                half.x as f32,
                half.y as f32,
                point.w as f32,
                f32::from(u8::from(is_sphere)),
            ],
            point_relative: point_relative.as_vec4().to_array(),
            half_right: right.extend(radius as f32).to_array(),
            half_up: up.extend(self.taps() as f32).to_array(),
            limits: [depths.0, depths.1, self.resolution as f32, self.levels() as f32],
        }
    }

    /// Number of squares of which lookups in N-buffers put their rectangles together.
    pub fn taps(&self) -> u32 {
        let Some(sliced) = self.sliced else {
            return 1;
        };
        let of_face = |face: &SliceFace| {
            let squares = tap_count((sliced.half * face.scale).as_vec2());
            match sliced.kind {
                // Oblique kernels may have any shape; two squares follow most of them.
                SlicedKind::Sphere => (2 * squares).min(MOST_TAPS),
                SlicedKind::Rect | SlicedKind::Directional => squares,
            }
        };
        self.faces.iter().map(of_face).max().unwrap_or(1)
    }

    /// Number of levels of the filter that lookups reach. N-buffers above them are not built.
    pub fn levels(&self) -> u32 {
        let Some(sliced) = self.sliced else {
            return 1;
        };
        let all = level_count(self.resolution);
        let side = f64::from(self.resolution);
        let of_face = |face: &SliceFace| {
            let widest = if self.settings.measures() {
                face.widest_measured(&sliced)
            } else {
                face.widest_kernel(&sliced)
            };
            reached_levels((widest * side).as_vec2(), self.taps()).min(all)
        };
        self.faces.iter().map(of_face).max().unwrap_or(all)
    }

    /// Returns the extent of the scene that the pictures show: the sizes of the last slice's picture, metres, in the first
    /// picture with casters. It is 0 without casters.
    pub fn extent(&self) -> Vec3 {
        let Some(face) = self.faces.iter().find(|face| face.slices != Slices::NONE) else {
            return Vec3::ZERO;
        };
        let slices = &face.slices;
        let bottom = slices.bottoms[slices.count - 1];
        let across = 2.0 * (face.divisor.x * bottom + face.divisor.y) / face.scale;
        across.extend(bottom - slices.top).as_vec3()
    }
}
