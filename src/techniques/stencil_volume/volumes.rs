//! The frame's shadow volumes: which parts of which caster are drawn, and how they are counted.
//!
//! A light keeps its volumes while nothing changes that they are decided by, which `kept` finds out.
//!
//! This file and `volume_parts` decide which parts of its volume a caster of a light's set S needs.
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use bevy_ecs::prelude::*;
use glam::Vec4;

use super::caster_volume::CasterVolume;
use super::component::{Counting, Extent, StencilVolume};
use super::kept::{LightInputs, SharedInputs};
use super::volume_parts::PartCulling;
use crate::geometry::{Aabb, BoxReceivers};
use crate::sets::{CameraOcclusion, DepthReach, FrameLight, FrameLights, Objects, View, ViewData};
use crate::silhouettes::{CasterShape, LightSilhouettes, Silhouette, Silhouettes};
use crate::techniques::shared::extrude::{TO_INFINITY, finite_extrusion, volume_corners};
use crate::techniques::shared::finite_reach::{FiniteReach, NearestSurfaces, farthest_depth};
use crate::techniques::shared::inside_test::OcclusionPyramid;
use crate::techniques::shared::near_caps::NearCaps;

/// The shadow volumes in one light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightVolumes {
    /// Index into [`FrameLights`].
    pub light: usize,
    /// Entity of the light.
    pub entity: Entity,
    /// Volumes of the casters, ascending by object.
    pub casters: Vec<CasterVolume>,
    /// Number of casters of S without a volume, because it misses the view or the depths that the light
    /// reaches.
    pub culled: usize,
    /// The [`StencilVolumes::revision`] of the frame in which the volumes were computed. They are those of the frames since.
    pub revision: u64,
    /// Greatest view depth of the volumes; −∞ in a perspective view.
    deepest: f64,
    inputs: LightInputs,
}

impl LightVolumes {
    fn new(entity: Entity, light: usize, casters: Vec<CasterVolume>) -> Self {
        Self {
            light,
            entity,
            casters,
            culled: 0,
            revision: 0,
            deepest: f64::NEG_INFINITY,
            inputs: LightInputs::default(),
        }
    }
}

/// The volumes of this frame, for each light with a [`StencilVolume`] that lights something. Written by
/// `build_stencil_volumes`.
#[derive(Resource, Clone, Debug, Default)]
pub struct StencilVolumes {
    /// Volumes by light, ascending.
    pub lights: Vec<LightVolumes>,
    /// Increases when `lights` changed: when volumes of a light were computed again, or lights came, went or have other
    /// indices.
    pub revision: u64,
    previous: Vec<LightVolumes>,
    spare: Vec<Vec<CasterVolume>>,
    surfaces: NearestSurfaces,
    receivers: BoxReceivers,
    inputs: SharedInputs,
}

impl StencilVolumes {
    /// Returns the volumes in a light of [`FrameLights`].
    pub fn of_light(&self, light: usize) -> Option<&LightVolumes> {
        let at = self
            .lights
            .binary_search_by_key(&light, |entry| entry.light)
            .ok()?;
        Some(&self.lights[at])
    }
}

/// Decides for every caster of every light with a [`StencilVolume`] which parts are drawn and how they count. Lights
/// keep the volumes of the last frame if nothing changed that these are decided by.
///
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], [`Silhouettes`],
/// [`CameraOcclusion`]; writes [`StencilVolumes`] and, in an orthographic view, extends [`DepthReach`] to the
/// volumes. Cost: the lights, and two bits an object. For a light whose volumes are computed again, a pyramid test and a hull
/// test for each caster of S and, with [`Extent::Finite`] in a perspective view, its lit receivers for each of these casters,
/// eight at a time.
pub fn build_stencil_volumes(
    mut volumes: ResMut<StencilVolumes>,
    depth_reach: Res<DepthReach>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    silhouettes: Res<Silhouettes>,
    near_caps: NearCaps,
    occlusion: Res<CameraOcclusion>,
    components: Query<&StencilVolume>,
    casters: Query<CasterShape>,
) {
    let StencilVolumes {
        lights: out,
        revision,
        previous,
        spare,
        surfaces,
        receivers,
        inputs: shared,
    } = &mut *volumes;
    surfaces.begin_frame();
    let Some(view) = &view.data else {
        *revision += u64::from(!out.is_empty());
        spare.extend(out.drain(..).map(|light| light.casters));
        return;
    };
    let same_shared = shared.follow(view, &occlusion, &near_caps);
    std::mem::swap(out, previous);
    let mut old = previous.drain(..).peekable();
    let next_revision = *revision + 1;
    let mut changed = false;
    for (index, light) in lights.lights.iter().enumerate() {
        if !light.is_shadowed_by::<StencilVolume>() {
            continue;
        }
        let Ok(settings) = components.get(light.entity) else {
            continue;
        };
        if light.region.scissor.is_none() {
            continue; // no visible surface receives the light
        }
        while let Some(gone) = old.next_if(|entry| entry.entity < light.entity) {
            spare.push(gone.casters);
            changed = true;
        }
        let known = silhouettes.of_light(light.entity);
        let inputs = LightInputs {
            settings: *settings,
            silhouettes: known.map(|known| known.revision),
        };
        let last = old.next_if(|entry| entry.entity == light.entity);
        let is_kept =
            same_shared && !light.is_recomputed() && last.as_ref().is_some_and(|last| last.inputs == inputs);
        let mut entry =
            last.unwrap_or_else(|| LightVolumes::new(light.entity, index, spare.pop().unwrap_or_default()));
        changed |= !is_kept || entry.light != index;
        entry.light = index;
        if !is_kept {
            entry.inputs = inputs;
            entry.revision = next_revision;
            let near = &view.near_corners;
            let finite = FiniteReach::new(view, light, light.point_world);
            if finite.is_none() && settings.extent == Extent::Finite && light.point_world.w != 0.0 {
                receivers.set(light.point_world.truncate(), &light.region.lit_receivers);
            }
            let building = Building {
                light,
                settings,
                view,
                objects: &objects,
                near_caps: &near_caps,
                casters: &casters,
                pyramid: OcclusionPyramid::new(&[near[0], near[1], near[3], near[2]], light.point_world),
                parts: PartCulling::new(light, view, &occlusion.viewpoint),
                finite,
                receivers,
            };
            building.fill(&mut entry, known, surfaces);
        }
        if view.is_orthographic() {
            depth_reach.include(entry.deepest);
        }
        out.push(entry);
    }
    for gone in old {
        spare.push(gone.casters);
        changed = true;
    }
    *revision += u64::from(changed);
}

/// Everything that the volumes of one light are decided by.
struct Building<'a, 'w, 's> {
    light: &'a FrameLight,
    settings: &'a StencilVolume,
    view: &'a ViewData,
    objects: &'a Objects,
    near_caps: &'a NearCaps<'w>,
    casters: &'a Query<'w, 's, CasterShape>,
    pyramid: OcclusionPyramid,
    parts: PartCulling<'a>,
    /// `Some` in a view in which volumes must end.
    finite: Option<FiniteReach>,
    /// The boxes of the objects that receive the light, at which finite volumes of a perspective view end.
    receivers: &'a BoxReceivers,
}

impl Building<'_, '_, '_> {
    /// Computes the volumes of all casters of S.
    fn fill(&self, out: &mut LightVolumes, known: Option<&LightSilhouettes>, surfaces: &mut NearestSurfaces) {
        out.casters.clear();
        (out.culled, out.deepest) = (0, f64::NEG_INFINITY);
        let Some(known) = known else {
            return;
        };
        for object in self.light.sets.s.ones() {
            let Some((slot, silhouette)) = known.of_object(object) else {
                continue;
            };
            if silhouette.contour.edge_count() == 0 && silhouette.contour.caps.is_empty() {
                continue;
            }
            match self.volume(object, slot, silhouette, surfaces) {
                Some((volume, corners)) => {
                    if self.finite.is_some() {
                        out.deepest = out.deepest.max(farthest_depth(self.view, corners));
                    }
                    out.casters.push(volume);
                }
                None => out.culled += 1,
            }
        }
    }

    /// Returns the volume of one caster with the corners around it, world space. It is `None` for a caster that
    /// shadows nothing which receives the light, or nothing in view.
    fn volume(
        &self,
        object: usize,
        slot: usize,
        silhouette: &Silhouette,
        surfaces: &mut NearestSurfaces,
    ) -> Option<(CasterVolume, [Vec4; 16])> {
        let light = self.light;
        let bounds = self.objects.boxes.get(object);
        let depth_pass = self.counts_depth_pass(object, &bounds);
        let extrusion = match &self.finite {
            Some(finite) => finite.extrusion(&bounds, || {
                let entity = self.objects.entities[object];
                let caster = self.casters.get(entity).ok()?;
                let key = (light.entity, 0, entity);
                surfaces.get(key, silhouette.revision, light.point_world, &caster)
            })?,
            None if self.settings.extent == Extent::Finite => {
                finite_extrusion(light.point_world, light.light.range, &bounds, self.receivers)?
            }
            None => TO_INFINITY,
        };
        let volume = CasterVolume {
            object: object as u32,
            slot: slot as u32,
            light_local: silhouette.light_local,
            extrusion,
            depth_pass,
            near_cap: !depth_pass,
            far_cap: true,
        };
        let corners = volume_corners(light.point_world, extrusion, &bounds);
        let volume = self.parts.cull(volume, &corners, &bounds)?;
        Some((volume, corners))
    }

    /// Whether the volume of a caster counts where the depth test passes: the view lies outside of it, and the caster
    /// itself hides the near cap, which is then left out.
    fn counts_depth_pass(&self, object: usize, bounds: &Aabb) -> bool {
        let shows_fronts_alone = || {
            let caster = self.casters.get(self.objects.entities[object]);
            caster.is_ok_and(|caster| caster.edges.0.shows_fronts_alone)
        };
        self.settings.counting == Counting::Auto
            && self
                .near_caps
                .are_hidden(self.objects, object, shows_fronts_alone)
            && self.pyramid.excludes(bounds)
    }
}
