//! One light of the frame.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;
use glam::{DVec4, Vec3};
use smallvec::SmallVec;

use super::candidate::{Candidate, is_dark};
use super::companion::{ActsOn, CompanionOf};
use super::depth_bounds::DepthBounds;
use super::light_volume::LightVolume;
use super::lit_region::LitRegion;
use super::placing::Shining;
use super::scissor::ScissorRect;
use super::technique::{LightTechnique, Needs};
use crate::geometry::{Aabb, Emitter, LightHull, PlaneSet};
use crate::scene::{Light, LightModel, LightSelection, LightTextures};
use crate::sets::index::objects::Objects;

/// One light of the frame: its place, its sets, and the part of the picture that it can reach.
#[derive(Clone, Debug)]
pub struct FrameLight {
    /// Entity of the light.
    pub entity: Entity,
    /// The light whose shadow this one completes, for a companion, which gives no light; `None` for a light of the scene.
    pub companion_of: Option<CompanionOf>,
    /// The objects that a companion acts on; all for a light of the scene.
    pub acts_on: ActsOn,
    /// Copy of the entity's [`Light`]. Its range is that of the light's shadows: the distance from their place
    /// beyond which nothing is lit.
    pub light: Light,
    /// Copy of the entity's [`GlobalTransform`].
    pub world_from_light: GlobalTransform,
    /// The place from which the light shines. All other places here are those from which its shadows are cast,
    /// which are the same unless the light's model moves or softens them.
    pub shining: Shining,
    /// Place from which shadows are cast, world space: a position with `w = 1`, or the unit direction towards a
    /// directional light with `w = 0`.
    pub point_world: DVec4,
    /// Place and extent from which shadows are cast, world space.
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
    /// not count, except when the light goes dark or lights up. For a companion, the objects that it acts on do.
    pub moved: bool,
    /// Distance from the light within which surfaces do not block it, metres
    /// ([`LightClearance`](super::clearance::LightClearance)). It is 0 for a directional light, and is not known for a
    /// light without a technique.
    pub clearance: f64,
    /// The region of space that holds what the light lights and the casters that may shadow it.
    pub volume: LightVolume,
    /// Planes of barn doors that bound the same region, beside the volume.
    pub doors: PlaneSet,
    /// The region of space that the light lights.
    pub lit: LitRegion,
    /// The sets of objects that the light reaches, lights, and lets cast.
    pub sets: LightSets,
    /// The convex regions in which casters matter.
    pub hulls: LightHulls,
    /// The part of the picture and of the scene that the light can change.
    pub region: LightRegion,
    /// Results that are known for the light, and those that must be computed again.
    pub(in crate::sets) progress: LightProgress,
    /// Memory that is kept for its allocation.
    pub(in crate::sets) scratch: LightScratch,
}

/// The sets of one light, by dense object index.
#[derive(Clone, Debug, Default)]
pub struct LightSets {
    /// Objects within the light's volume, occluded from the light or not.
    pub reach: FixedBitSet,
    /// Set L: objects of `reach` that are not occluded from the light.
    pub l: FixedBitSet,
    /// Set I: objects that the light pass draws. If it is empty, the light is skipped.
    pub i: FixedBitSet,
    /// Objects of V within reach that were left out of I because the light sees none of their visible points.
    pub dark: FixedBitSet,
    /// Set S: casters whose shadow can reach a receiver of I.
    pub s: FixedBitSet,
}

/// The convex hulls of one light, world space, from the last frame in which set I was not empty.
#[derive(Clone, Debug, Default)]
pub struct LightHulls {
    /// Convex hull of the light and the view frustum.
    pub view: LightHull,
    /// Convex hull of the light and the receivers of I within its volume.
    pub receivers: LightHull,
    /// Whether the whole light lies within the view frustum.
    pub inside_frustum: bool,
}

/// The part of the picture and of the scene that one light can change.
#[derive(Clone, Debug)]
pub struct LightRegion {
    /// Pixels that the light can reach; `None` if the light is skipped.
    pub scissor: Option<ScissorRect>,
    /// View depths that the light can reach; `None` if the light is skipped.
    pub depth_bounds: Option<DepthBounds>,
    /// Boxes, none of them empty, that hold every visible point of the receivers of I within the box of the
    /// volume, world space.
    pub lit_receivers: Vec<Aabb>,
    /// Bounds of the receivers of I, each cut by the box of the volume, world space.
    pub receiver_bounds: Aabb,
}

impl Default for LightRegion {
    /// Returns the region of a skipped light.
    fn default() -> Self {
        Self {
            scissor: None,
            depth_bounds: None,
            lit_receivers: Vec::new(),
            receiver_bounds: Aabb::EMPTY,
        }
    }
}

/// Results that are known for one light, and those that must be computed again.
#[derive(Clone, Debug)]
pub(in crate::sets) struct LightProgress {
    /// Whether I and everything derived from it must be computed in this frame.
    pub stale: bool,
    /// Whether the set `reach`, or the place of one of its objects, may have changed in this frame.
    pub reach_written: bool,
    /// The share for which the clearance was computed; NaN if it must be computed again.
    pub clearance_share: f64,
    /// Generations of what I was last computed from; `None` before the first time.
    pub seen: Option<Seen>,
    /// Work that was done for the light in this frame.
    pub work: LightWork,
}

/// Memory of one light that is kept for its allocation.
#[derive(Clone, Debug)]
pub(in crate::sets) struct LightScratch {
    /// Words in which `reach`, and therefore L, I or S, may be other than 0.
    pub touched: FixedBitSet,
    /// Casters of S that some receiver needs.
    pub kept: FixedBitSet,
    /// Words found by the last query.
    pub found: FixedBitSet,
    /// Planes by which the last query was cut.
    pub cutting: PlaneSet,
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

impl FrameLight {
    /// Whether the light draws nothing in this frame.
    pub fn is_skipped(&self) -> bool {
        self.sets.i.is_clear()
    }

    /// Whether set I, set S and the region were computed again in this frame, because something that they depend on changed.
    pub fn is_recomputed(&self) -> bool {
        self.progress.stale
    }

    /// Whether the technique whose component is `T` shadows the light.
    pub fn is_shadowed_by<T: 'static>(&self) -> bool {
        self.technique
            .is_some_and(|technique| technique.component == TypeId::of::<T>())
    }

    /// The order of the lights of a frame: lights of the scene by their entities, then companions by the light that they
    /// complete.
    pub(in crate::sets) fn order(&self) -> (Option<CompanionOf>, Entity) {
        (self.companion_of, self.entity)
    }

    /// Whether the light shadows anything: a companion without a technique stands for nothing.
    pub(in crate::sets) fn is_in_use(&self) -> bool {
        self.companion_of.is_none() || self.technique.is_some()
    }

    /// Whether an object casts for the light, if it is a caster.
    pub fn casts(&self, objects: &Objects, object: usize) -> bool {
        objects.layers[object] & self.selection.casts_for != 0 && self.acts_on.casters.contains(object)
    }

    /// Bits of those objects of a word that cast for the light, if they are casters.
    pub(crate) fn casting(&self, objects: &Objects, word: usize, bits: usize) -> usize {
        let bits = self.acts_on.casters.among(word, bits);
        objects.selected(word, bits, self.selection.casts_for)
    }

    /// Returns the needs of the light's technique; an unshadowed light has none.
    pub fn needs(&self) -> Needs {
        self.technique.map_or(Needs::NOTHING, |technique| technique.needs)
    }

    /// The factor by which an artist's softness scales the extent of a rectangle, for its shadows.
    pub fn softened(&self) -> f64 {
        let radius = self.shining.emitter.bounding_radius();
        match self.model.softness {
            Some(softness) if radius > 0.0 => f64::from(softness) / radius,
            _ => 1.0,
        }
    }

    /// All casters of set L that cast for the light, by dense object index: those of S and those whose shadow is not
    /// seen in this frame.
    pub fn reached_casters<'a>(&'a self, objects: &'a Objects) -> impl Iterator<Item = usize> + 'a {
        let casts = |&object: &usize| self.casts(objects, object);
        self.sets.l.intersection(&objects.casters).filter(casts)
    }

    pub(super) fn new(candidate: &Candidate) -> Self {
        Self {
            entity: candidate.entity,
            companion_of: candidate.companion_of,
            acts_on: ActsOn::default(),
            light: candidate.light.clone(),
            world_from_light: candidate.world_from_light,
            shining: candidate.placed.shining,
            point_world: candidate.placed.emitter.point,
            emitter: candidate.placed.emitter,
            direction: candidate.placed.direction,
            selection: candidate.selection,
            model: candidate.model,
            textures: candidate.textures.clone(),
            technique: None,
            moved: true,
            clearance: 0.0,
            volume: candidate.placed.volume,
            doors: candidate.placed.doors.clone(),
            lit: candidate.placed.lit,
            sets: LightSets::default(),
            hulls: LightHulls::default(),
            region: LightRegion::default(),
            progress: LightProgress {
                stale: true,
                reach_written: true,
                clearance_share: f64::NAN,
                seen: None,
                work: LightWork::default(),
            },
            scratch: LightScratch {
                touched: FixedBitSet::new(),
                kept: FixedBitSet::new(),
                found: FixedBitSet::new(),
                // Two hulls have some ten planes each.
                cutting: PlaneSet {
                    planes: SmallVec::with_capacity(32),
                },
            },
        }
    }

    pub(super) fn refresh(&mut self, candidate: &Candidate) {
        self.textures.clone_from(&candidate.textures);
        if candidate.is_kept {
            self.moved = false;
            return;
        }
        let (old, new) = (&self.light, &candidate.light);
        self.moved = old.kind != new.kind
            || old.range != new.range
            || is_dark(old) != is_dark(new)
            || self.world_from_light != candidate.world_from_light
            || self.selection != candidate.selection
            || self.model.bounds() != candidate.model.bounds();
        self.light.clone_from(new);
        self.model = candidate.model;
        // The light fades towards its own range, even where its shadows end nearer and stay as they are.
        self.shining = candidate.placed.shining;
        if self.moved {
            self.world_from_light = candidate.world_from_light;
            self.selection = candidate.selection;
            self.point_world = candidate.placed.emitter.point;
            self.emitter = candidate.placed.emitter;
            self.direction = candidate.placed.direction;
            self.volume = candidate.placed.volume;
            self.doors.clone_from(&candidate.placed.doors);
            self.lit = candidate.placed.lit;
        }
    }
}
