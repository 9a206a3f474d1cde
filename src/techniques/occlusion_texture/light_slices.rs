//! The pictures of one light: what they show, and whether they changed.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::{DVec2, DVec3, UVec2, Vec3};

use super::component::{OcclusionTexture, SliceFilter};
use super::filter::{MOST_TAPS, level_count, tap_count};
use super::fit::{SceneBox, SliceFaces, SliceSettings, SlicedKind, SlicedLight, fit_faces};
use super::records::{OcclusionFace, OcclusionLight};
use crate::geometry::{Aabb, Emitter};
use crate::scene::LightKind;
use crate::sets::{FrameLight, LightVolume, Objects};

/// Half of the side of a square as large as a disc of radius 1.
const SQUARE_OF_DISC: f64 = 0.886_226_925_452_758;

/// Texels that stay empty along each side of a picture.
const GUARD_TEXELS: f64 = 2.0;

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
    /// Those of the casters whose fronts alone are drawn. A ray through a closed caster would otherwise count twice, if front
    /// and back lie in different slices.
    pub solid: FixedBitSet,
    /// Whether the pictures are looked up in this frame.
    pub is_active: bool,
    /// Changes when the pictures must be drawn again.
    pub revision: u64,
    pub(super) layout: u64,
    pub(super) volume: LightVolume,
    pub(super) sliced: Option<SlicedLight>,
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
            is_active: false,
            revision: 0,
            layout: 0,
            volume: LightVolume::Infinite,
            sliced: None,
        }
    }

    /// Takes over settings, casters and place of the light. Returns whether the pictures change.
    pub(super) fn follow(
        &mut self,
        light: &FrameLight,
        settings: &OcclusionTexture,
        objects: &Objects,
        exchanged: &FixedBitSet,
        is_closed: impl Fn(Entity) -> bool,
        scratch: &mut Scratch,
    ) -> bool {
        if scratch.casters.len() == objects.len() {
            scratch.casters.clear();
        } else {
            scratch.casters = FixedBitSet::with_capacity(objects.len()); // sets of unequal length are not equal
        }
        let sun = (f64::from(settings.angle_deg) * 0.5).to_radians().sin();
        let lit = light.sets.l.ones().map(|object| objects.boxes.get(object));
        let lit = lit.fold(Aabb::EMPTY, Aabb::union);
        for object in light.reached_casters(objects) {
            let shadows = !shadows_nothing(&objects.boxes.get(object), &lit, &light.emitter, sun);
            scratch.casters.set(object, shadows);
        }
        let sliced = sliced_light(light, settings);
        let moved = |set: &FixedBitSet| !set.is_disjoint(&objects.moved) || !set.is_disjoint(exchanged);
        let is_same = self.revision != 0
            && self.settings == *settings
            && self.sliced == Some(sliced)
            && self.volume == light.volume
            && self.layout == objects.layout_generation
            && self.casters == scratch.casters
            && !moved(&self.casters)
            && light.sets.l.is_disjoint(&objects.moved);
        if is_same {
            return false;
        }
        self.settings = *settings;
        self.sliced = Some(sliced);
        self.volume = light.volume;
        self.layout = objects.layout_generation;
        std::mem::swap(&mut self.casters, &mut scratch.casters);
        self.closing.clear();
        self.closing.grow(objects.len());
        for object in self.casters.ones() {
            let closes = objects.layers[object] & settings.close_leaks != 0;
            self.closing.set(object, closes);
        }
        let volume = light.volume.aabb();
        scratch.scene.clear();
        scratch.scene.extend(light.sets.l.ones().filter_map(|object| {
            let bounds = objects.boxes.get(object).intersection(volume);
            let scene = SceneBox {
                bounds,
                casts: self.casters.contains(object),
            };
            (!bounds.is_empty() && bounds.min.abs().max(bounds.max.abs()).max_element() < FARTHEST)
                .then_some(scene)
        }));
        let slice_settings = SliceSettings {
            count: settings.slices,
            weight: f64::from(settings.weight),
            guard: GUARD_TEXELS / f64::from(settings.resolution),
        };
        self.faces = fit_faces(&sliced, &slice_settings, &scratch.scene);
        self.solid.clear();
        self.solid.grow(objects.len());
        for object in self.casters.ones() {
            let is_solid = is_closed(objects.entities[object]) && self.is_clear_of(objects, object);
            self.solid.set(object, is_solid);
        }
        true
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
        match self.settings.filter {
            SliceFilter::NBuffers => groups * 8 * u64::from(level_count(self.settings.resolution)),
            SliceFilter::Mipmaps => groups * 11, // 8 and a third, rounded up
            SliceFilter::SummedAreas => groups * 40,
        }
    }

    /// Largest resolution at which the pictures fit into the layers of one texture.
    pub fn largest(&self, most_layers: u32) -> u32 {
        let mut resolution = self.settings.resolution;
        let layers = |resolution| {
            let levels = match self.settings.filter {
                SliceFilter::NBuffers => level_count(resolution),
                SliceFilter::Mipmaps | SliceFilter::SummedAreas => 1,
            };
            self.faces.len() as u32 * self.settings.groups() * levels
        };
        while resolution > 1 && layers(resolution) > most_layers {
            resolution /= 2;
        }
        resolution
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
            limits: [
                depths.0,
                depths.1,
                self.resolution as f32,
                (self.resolution as f32).recip(),
            ],
        }
    }

    /// Number of squares of which lookups in N-buffers put their rectangles together.
    pub fn taps(&self) -> u32 {
        let (Some(sliced), Some(face)) = (self.sliced, self.faces.first()) else {
            return 1;
        };
        let kernel = (sliced.half * face.scale).as_vec2();
        match sliced.kind {
            // Oblique kernels may have any shape; two squares follow most of them.
            SlicedKind::Sphere => (2 * tap_count(kernel)).min(MOST_TAPS),
            SlicedKind::Rect | SlicedKind::Directional => tap_count(kernel),
        }
    }

    /// Size of the light's texture arrays: texels along a side and layers, without levels.
    pub fn size(&self) -> UVec2 {
        UVec2::new(self.resolution, self.faces.len() as u32 * self.settings.groups())
    }
}

/// Coordinates from which on a box says nothing about the scene, metres.
const FARTHEST: f32 = 1e9;

/// Memory that is kept for its allocation.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    casters: FixedBitSet,
    scene: Vec<SceneBox>,
}

/// How deep objects may be sunk into a ground that shadows nothing, as a share of the extent of everything lit. It is less than
/// a slice, within which nothing is shadowed either.
const SUNK: f64 = 0.05;

/// Whether everything that a light lights lies on the light's side of a caster, as it does for a flat ground. Slices are
/// not spent on such a caster. `sun` is the sine of half the angle of a directional light.
fn shadows_nothing(caster: &Aabb, lit: &Aabb, emitter: &Emitter, sun: f64) -> bool {
    DVec3::AXES.into_iter().any(|axis| {
        let slack = SUNK * axis.dot((lit.max - lit.min).as_dvec3());
        [axis, -axis].into_iter().any(|outward| {
            let along = |a: Vec3, b: Vec3| outward.dot(a.as_dvec3()).max(outward.dot(b.as_dvec3()));
            let side = along(caster.min, caster.max);
            let nearest = -(-outward)
                .dot(lit.min.as_dvec3())
                .max((-outward).dot(lit.max.as_dvec3()));
            let point = emitter.point;
            let light = outward.dot(point.truncate());
            let is_outside = if point.w == 0.0 {
                light > sun
            } else {
                light - emitter.extent(outward) > side + slack
            };
            is_outside && nearest >= side - slack
        })
    })
}

/// Returns the place and extent of a light's shadows.
fn sliced_light(light: &FrameLight, settings: &OcclusionTexture) -> SlicedLight {
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
        return SlicedLight {
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
    SlicedLight {
        origin: point,
        axes,
        half,
        kind,
    }
}

impl LightSlices {
    /// Returns the extent of the scene that the pictures show: the sizes of the last slice's picture, metres.
    pub fn extent(&self) -> Vec3 {
        let Some(face) = self.faces.first() else {
            return Vec3::ZERO;
        };
        let slices = &face.slices;
        let bottom = slices.bottoms[slices.count - 1];
        let across = 2.0 * (face.divisor.x * bottom + face.divisor.y) / face.scale;
        across.extend(bottom - slices.top).as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grounds_shadow_nothing_and_what_stands_on_them_does() {
        let ground = Aabb::around(Vec3::ZERO, Vec3::new(10.0, 0.0, 10.0));
        let cube = Aabb::around(Vec3::Y, Vec3::ONE);
        let lit = ground.union(cube);
        let lamp = |y: f64| Emitter {
            radius: 0.5,
            ..Emitter::point(DVec3::new(3.0, y, 0.0).extend(1.0))
        };
        let sun = |y: f64| Emitter::point(DVec3::new(0.6, y, 0.0).normalize().extend(0.0));
        for high in [lamp(4.0), sun(1.0)] {
            assert!(shadows_nothing(&ground, &lit, &high, 0.1));
            assert!(!shadows_nothing(&cube, &lit, &high, 0.1));
            let cellar = lit.union(Aabb::around(Vec3::NEG_Y, Vec3::ONE));
            assert!(!shadows_nothing(&ground, &cellar, &high, 0.1));
        }
        // Some of the light is below the ground.
        assert!(!shadows_nothing(&ground, &lit, &lamp(0.4), 0.1));
        assert!(!shadows_nothing(&ground, &lit, &sun(0.05), 0.1));
        // A wall behind everything.
        let wall = Aabb::around(Vec3::new(-10.0, 5.0, 0.0), Vec3::new(0.0, 5.0, 10.0));
        assert!(shadows_nothing(&wall, &lit.union(wall), &lamp(4.0), 0.1));
    }
}
