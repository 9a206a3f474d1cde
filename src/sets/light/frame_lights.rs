//! The lights of the frame.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;
use glam::{DVec3, DVec4, Vec3};
use smallvec::SmallVec;

use super::depth_bounds::DepthBounds;
use super::light_volume::LightVolume;
use super::scissor::ScissorRect;
use super::technique::{LightTechnique, Needs};
use crate::geometry::{Aabb, Emitter, LightHull, PlaneSet};
use crate::scene::{
    Cookie, Light, LightError, LightKind, LightModel, LightModelFault, LightModelParts, LightProfile,
    LightSelection, LightTextures, light,
};
use crate::sets::index::objects::Objects;

/// The lights of the frame. Written by [`collect_frame_lights`] and the systems after it.
#[derive(Resource, Clone, Debug, Default)]
pub struct FrameLights {
    /// All usable lights, in ascending order of their entities.
    pub lights: Vec<FrameLight>,
    /// All lights that cannot shine now, in ascending order of their entities.
    pub skipped: Vec<SkippedLight>,
    /// Parts of lights' models that are left out because their numbers cannot be used, in ascending order of
    /// the lights' entities.
    pub faults: Vec<(Entity, LightModelFault)>,
    /// Increases when lights were added to or removed from the list, which changes the meaning of indices
    /// into `lights`.
    pub generation: u64,
    candidates: Vec<Candidate>,
    previous: Vec<FrameLight>,
}

/// A light that cannot shine, and the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkippedLight {
    /// Entity of the light.
    pub entity: Entity,
    /// Why the light cannot shine.
    pub error: LightError,
}

/// One light of the frame: where it is, and its sets by dense object index.
#[derive(Clone, Debug)]
pub struct FrameLight {
    /// Entity of the light.
    pub entity: Entity,
    /// Copy of the entity's [`Light`].
    pub light: Light,
    /// Copy of the entity's [`GlobalTransform`].
    pub world_from_light: GlobalTransform,
    /// Place of the light in world space: its position with `w = 1`, or the unit direction towards a
    /// directional light with `w = 0`.
    pub point_world: DVec4,
    /// Place and extent of the source in world space.
    pub emitter: Emitter,
    /// Unit direction in which the light shines, world space. It is −Z for a point or sphere whose transform
    /// has no direction.
    pub direction: Vec3,
    /// Copy of the entity's [`LightSelection`].
    pub selection: LightSelection,
    /// The usable parts of the light model that stand beside the entity's [`Light`].
    pub model: LightModel,
    /// The usable textures of the light model: cookie and profile.
    pub textures: LightTextures,
    /// The technique that shadows the light; `None` without one, and if the technique does not fit the light.
    pub technique: Option<LightTechnique>,
    /// Whether the light's place, shape, range or selection changed in this frame. Colour and intensity do
    /// not count, except when the light goes dark or lights up.
    pub moved: bool,
    /// The region of space that the light reaches.
    pub volume: LightVolume,
    /// Objects within the volume, occluded from the light or not.
    pub reach: FixedBitSet,
    /// Set L: objects of `reach` that are not occluded from the light.
    pub l: FixedBitSet,
    /// Set I: objects that the light pass draws. If it is empty, the light is skipped.
    pub i: FixedBitSet,
    /// Objects of V within reach that were left out of I because the light sees none of their visible points.
    pub dark: FixedBitSet,
    /// Set S: casters whose shadow can reach a receiver of I.
    pub s: FixedBitSet,
    /// Convex hull of the light and the view frustum, from the last frame in which I was not empty.
    pub hull: LightHull,
    /// Convex hull of the light and the receivers of I within its volume, from the last frame in which I was
    /// not empty.
    pub receiver_hull: LightHull,
    /// Whether the whole light lies within the view frustum.
    pub inside_frustum: bool,
    /// Pixels that the light can reach; `None` if the light is skipped.
    pub scissor: Option<ScissorRect>,
    /// View depths that the light can reach; `None` if the light is skipped.
    pub depth_bounds: Option<DepthBounds>,
    /// Boxes, none of them empty, that hold every visible point of the receivers of I within the box of the
    /// volume.
    pub lit_receivers: Vec<Aabb>,
    /// Bounds of the receivers of I, each cut by the box of the volume.
    pub receiver_bounds: Aabb,
    /// Words in which `reach`, and therefore L, I or S, may be other than 0.
    pub(in crate::sets) touched: FixedBitSet,
    /// Whether I and everything derived from it must be computed in this frame.
    pub(in crate::sets) stale: bool,
    /// Casters of S that some receiver needs. Working memory.
    pub(in crate::sets) kept: FixedBitSet,
    /// Whether `reach`, or the place of one of its objects, may have changed in this frame.
    pub(in crate::sets) reach_written: bool,
    /// Work that was done for the light in this frame.
    pub(in crate::sets) work: LightWork,
    /// Words found by the last query. Working memory, kept for its allocation.
    pub(in crate::sets) found: FixedBitSet,
    pub(in crate::sets) cutting: PlaneSet,
    pub(in crate::sets) seen: Option<Seen>,
}

/// Work for one light. It may have been done on any thread.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::sets) struct LightWork {
    pub words: u64,
    pub projected: u64,
    pub illuminations: u64,
    pub shadows: u64,
}

/// Generations of everything that set I of a light depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::sets) struct Seen {
    pub layout: u64,
    pub flags: u64,
    pub view: u64,
    pub visible: u64,
}

/// The state of a light's entity in this frame.
#[derive(Clone, Debug)]
struct Candidate {
    entity: Entity,
    light: Light,
    world_from_light: GlobalTransform,
    selection: LightSelection,
    model: LightModel,
    textures: LightTextures,
    placed: Placed,
}

/// The parts of a light that follow from its components and its transform.
#[derive(Clone, Copy, Debug)]
struct Placed {
    emitter: Emitter,
    direction: Vec3,
    volume: LightVolume,
}

impl FrameLights {
    /// The light of an entity, if it shines in this frame.
    pub fn of_entity(&self, entity: Entity) -> Option<&FrameLight> {
        let at = self
            .lights
            .binary_search_by_key(&entity, |light| light.entity)
            .ok()?;
        Some(&self.lights[at])
    }
}

impl FrameLight {
    /// Whether the light draws nothing in this frame.
    pub fn is_skipped(&self) -> bool {
        self.i.is_clear()
    }

    /// Whether the technique whose component is `T` shadows the light.
    pub fn is_shadowed_by<T: 'static>(&self) -> bool {
        self.technique
            .is_some_and(|technique| technique.component == TypeId::of::<T>())
    }

    /// Returns the needs of the light's technique; an unshadowed light has none.
    pub fn needs(&self) -> Needs {
        self.technique.map_or(Needs::NOTHING, |technique| technique.needs)
    }

    /// All casters of set L that cast for the light, by dense object index: those of S and those whose shadow is not
    /// seen in this frame.
    pub fn reached_casters<'a>(&'a self, objects: &'a Objects) -> impl Iterator<Item = usize> + 'a {
        let casts = |&object: &usize| objects.layers[object] & self.selection.casts_for != 0;
        self.l.intersection(&objects.casters).filter(casts)
    }

    fn new(candidate: &Candidate) -> Self {
        Self {
            entity: candidate.entity,
            light: candidate.light.clone(),
            world_from_light: candidate.world_from_light,
            point_world: candidate.placed.emitter.point,
            emitter: candidate.placed.emitter,
            direction: candidate.placed.direction,
            selection: candidate.selection,
            model: candidate.model,
            textures: candidate.textures.clone(),
            technique: None,
            moved: true,
            volume: candidate.placed.volume,
            reach: FixedBitSet::new(),
            l: FixedBitSet::new(),
            i: FixedBitSet::new(),
            dark: FixedBitSet::new(),
            s: FixedBitSet::new(),
            hull: LightHull::default(),
            receiver_hull: LightHull::default(),
            inside_frustum: false,
            scissor: None,
            depth_bounds: None,
            lit_receivers: Vec::new(),
            receiver_bounds: Aabb::EMPTY,
            touched: FixedBitSet::new(),
            stale: true,
            kept: FixedBitSet::new(),
            reach_written: true,
            work: LightWork::default(),
            found: FixedBitSet::new(),
            // Two hulls have some ten planes each.
            cutting: PlaneSet {
                planes: SmallVec::with_capacity(32),
            },
            seen: None,
        }
    }

    fn refresh(&mut self, candidate: &Candidate) {
        let (old, new) = (&self.light, &candidate.light);
        self.moved = old.kind != new.kind
            || old.range != new.range
            || is_dark(old) != is_dark(new)
            || self.world_from_light != candidate.world_from_light
            || self.selection != candidate.selection
            || self.model.bounds() != candidate.model.bounds();
        self.light.clone_from(new);
        self.model = candidate.model;
        self.textures.clone_from(&candidate.textures);
        if self.moved {
            self.world_from_light = candidate.world_from_light;
            self.selection = candidate.selection;
            self.point_world = candidate.placed.emitter.point;
            self.emitter = candidate.placed.emitter;
            self.direction = candidate.placed.direction;
            self.volume = candidate.placed.volume;
        }
    }
}

/// Whether a light gives no light at all.
pub(in crate::sets) fn is_dark(light: &Light) -> bool {
    light.intensity == 0.0 || light.color == Vec3::ZERO
}

fn place(light: &Light, world_from_light: &GlobalTransform) -> Result<Placed, LightError> {
    light.validate()?;
    let point = light.point_world(world_from_light)?;
    let direction = light::light_direction(world_from_light);
    let needs_direction = !matches!(light.kind, LightKind::Point | LightKind::Sphere { .. });
    let direction = match direction {
        Some(direction) => direction,
        None if needs_direction => return Err(LightError::Transform),
        None => Vec3::NEG_Z,
    };
    let mut emitter = Emitter::point(point);
    match light.kind {
        LightKind::Sphere { radius } => emitter.radius = f64::from(radius),
        LightKind::Rect { width, height } => {
            let affine = world_from_light.affine();
            let axis = |axis: glam::Vec3A| Vec3::from(axis).as_dvec3().try_normalize();
            let right: DVec3 = axis(affine.matrix3.x_axis).ok_or(LightError::Transform)?;
            let up: DVec3 = axis(affine.matrix3.y_axis).ok_or(LightError::Transform)?;
            emitter.half_sides = [right * f64::from(width) * 0.5, up * f64::from(height) * 0.5];
        }
        LightKind::Point | LightKind::Spot { .. } | LightKind::Directional => {}
    }
    let extent = emitter.bounding_radius() as f32;
    let center = point.truncate().as_vec3();
    Ok(Placed {
        emitter,
        direction,
        volume: LightVolume::new(light.kind, light.range, center, direction, extent),
    })
}

/// The components that [`collect_frame_lights`] reads of one light.
type LightItem<'a> = (
    Entity,
    &'a Light,
    &'a GlobalTransform,
    Option<&'a LightSelection>,
    LightModelParts<'a>,
    Option<&'a Cookie>,
    Option<&'a LightProfile>,
);

/// Lists the usable lights and compares each with the frame before.
///
/// Set: `CollectSets`. Reads [`Light`], `GlobalTransform`, [`LightSelection`]. O(lights log lights). Lights
/// are in the order of their entities, and keep their sets and allocations as long as they exist.
pub fn collect_frame_lights(mut frame: ResMut<FrameLights>, lights: Query<LightItem<'static>>) {
    let frame = &mut *frame;
    frame.candidates.clear();
    frame.skipped.clear();
    frame.faults.clear();
    for (entity, light, world_from_light, selection, parts, cookie, profile) in &lights {
        let faults = &mut frame.faults;
        let model = LightModel::of(parts, light.kind, |fault| faults.push((entity, fault)));
        let textures = LightTextures::of(cookie, profile, light.kind, |fault| faults.push((entity, fault)));
        match place(light, world_from_light) {
            Ok(placed) => frame.candidates.push(Candidate {
                entity,
                light: light.clone(),
                world_from_light: *world_from_light,
                selection: selection.copied().unwrap_or_default(),
                model,
                textures,
                placed,
            }),
            Err(error) => frame.skipped.push(SkippedLight { entity, error }),
        }
    }
    frame.skipped.sort_unstable_by_key(|skipped| skipped.entity);
    frame.faults.sort_by_key(|(entity, _)| *entity);
    frame
        .candidates
        .sort_unstable_by_key(|candidate| candidate.entity);
    let same_members = frame.candidates.len() == frame.lights.len()
        && frame
            .candidates
            .iter()
            .zip(&frame.lights)
            .all(|(new, old)| new.entity == old.entity);
    if same_members {
        for (light, candidate) in frame.lights.iter_mut().zip(&frame.candidates) {
            light.refresh(candidate);
        }
        return;
    }
    frame.generation += 1;
    std::mem::swap(&mut frame.lights, &mut frame.previous);
    let mut old = frame.previous.drain(..).peekable();
    for candidate in &frame.candidates {
        while old.next_if(|light| light.entity < candidate.entity).is_some() {}
        let light = match old.next_if(|light| light.entity == candidate.entity) {
            Some(mut light) => {
                light.refresh(candidate);
                light
            }
            None => FrameLight::new(candidate),
        };
        frame.lights.push(light);
    }
}
