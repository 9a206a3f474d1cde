//! The frame's shadow volumes: which parts of which caster are drawn, and how they are counted.
//!
//! This file and `volume_parts` decide which parts of its volume a caster of a light's set S needs.
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use bevy_ecs::prelude::*;
use glam::Vec4;

use super::caster_volume::CasterVolume;
use super::component::{Counting, Extent, StencilVolume};
use super::volume_parts::PartCulling;
use crate::geometry::Aabb;
use crate::sets::{CameraOcclusion, DepthReach, FrameLight, FrameLights, Objects, View};
use crate::silhouettes::{CasterShape, Silhouette, Silhouettes};
use crate::techniques::shared::extrude::{TO_INFINITY, finite_extrusion, volume_corners};
use crate::techniques::shared::finite_reach::{FiniteReach, NearestSurfaces, include_points};
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
}

/// The volumes of this frame, for each light with a [`StencilVolume`] that lights something. Written by
/// `build_stencil_volumes`.
#[derive(Resource, Clone, Debug, Default)]
pub struct StencilVolumes {
    /// Volumes by light, ascending.
    pub lights: Vec<LightVolumes>,
    spare: Vec<Vec<CasterVolume>>,
    surfaces: NearestSurfaces,
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

/// Decides for every caster of every light with a [`StencilVolume`] which parts are drawn and how they count.
///
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], [`Silhouettes`],
/// [`CameraOcclusion`]; writes [`StencilVolumes`] and, in an orthographic view, extends [`DepthReach`] to the
/// volumes. Cost: one pyramid test and one hull test for each caster of S.
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
        spare,
        surfaces,
    } = &mut *volumes;
    surfaces.begin_frame();
    spare.extend(out.drain(..).map(|light| light.casters));
    let Some(view) = &view.data else {
        return;
    };
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
        let mut entry = LightVolumes {
            light: index,
            entity: light.entity,
            casters: spare.pop().unwrap_or_default(),
            culled: 0,
        };
        entry.casters.clear();
        let near = &view.near_corners;
        let building = Building {
            light,
            settings,
            objects: &objects,
            near_caps: &near_caps,
            casters: &casters,
            pyramid: OcclusionPyramid::new(&[near[0], near[1], near[3], near[2]], light.point_world),
            parts: PartCulling::new(light, view, &occlusion.viewpoint),
            finite: FiniteReach::new(view, light, light.point_world),
        };
        if let Some(known) = silhouettes.of_light(light.entity) {
            for object in light.sets.s.ones() {
                let Some((slot, silhouette)) = known.of_object(object) else {
                    continue;
                };
                if silhouette.contour.edge_count() == 0 && silhouette.contour.caps.is_empty() {
                    continue;
                }
                match building.volume(object, slot, silhouette, surfaces) {
                    Some((volume, corners)) => {
                        if building.finite.is_some() {
                            include_points(&depth_reach, view, corners);
                        }
                        entry.casters.push(volume);
                    }
                    None => entry.culled += 1,
                }
            }
        }
        out.push(entry);
    }
}

/// Everything that the volumes of one light are decided by.
struct Building<'a, 'w, 's> {
    light: &'a FrameLight,
    settings: &'a StencilVolume,
    objects: &'a Objects,
    near_caps: &'a NearCaps<'w>,
    casters: &'a Query<'w, 's, CasterShape>,
    pyramid: OcclusionPyramid,
    parts: PartCulling<'a>,
    /// `Some` in a view in which volumes must end.
    finite: Option<FiniteReach>,
}

impl Building<'_, '_, '_> {
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
            None if self.settings.extent == Extent::Finite => finite_extrusion(
                light.point_world,
                light.light.range,
                &bounds,
                &light.region.lit_receivers,
            )?,
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
