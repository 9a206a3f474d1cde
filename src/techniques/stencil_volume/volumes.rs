//! The frame's shadow volumes: which parts of which caster are drawn, and how they are counted.
//!
//! This file and `volume_parts` decide which parts of its volume a caster of a light's set S needs.
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use bevy_ecs::prelude::*;

use super::caster_volume::CasterVolume;
use super::component::{Counting, Extent, StencilVolume};
use super::volume_parts::PartCulling;
use crate::sets::{CameraOcclusion, DepthReach, FrameLights, Objects, View};
use crate::silhouettes::{CasterShape, Silhouettes};
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
        let around = [near[0], near[1], near[3], near[2]];
        let pyramid = OcclusionPyramid::new(&around, light.point_world);
        let parts = PartCulling::new(light, view, &occlusion.viewpoint);
        let finite = FiniteReach::new(view, light, light.point_world);
        if let Some(known) = silhouettes.of_light(light.entity) {
            for object in light.sets.s.ones() {
                let Some((slot, silhouette)) = known.of_object(object) else {
                    continue;
                };
                if silhouette.contour.edge_count() == 0 && silhouette.contour.caps.is_empty() {
                    continue;
                }
                let caster = casters.get(objects.entities[object]);
                let shows_fronts_alone = || {
                    caster
                        .as_ref()
                        .is_ok_and(|caster| caster.edges.0.shows_fronts_alone)
                };
                let hides_cap = near_caps.are_hidden(&objects, object, shows_fronts_alone);
                let depth_pass = settings.counting == Counting::Auto
                    && hides_cap
                    && pyramid.excludes(&objects.boxes.get(object));
                let entity = objects.entities[object];
                let bounds = objects.boxes.get(object);
                let extrusion = match &finite {
                    Some(finite) => finite.extrusion(&bounds, || {
                        let key = (light.entity, 0, entity);
                        surfaces.get(
                            key,
                            silhouette.revision,
                            light.point_world,
                            &casters.get(entity).ok()?,
                        )
                    }),
                    None if settings.extent == Extent::Finite => finite_extrusion(
                        light.point_world,
                        light.light.range,
                        &bounds,
                        &light.region.lit_receivers,
                    ),
                    None => Some(TO_INFINITY),
                };
                let Some(extrusion) = extrusion else {
                    entry.culled += 1; // it shadows nothing that receives the light
                    continue;
                };
                let volume = CasterVolume {
                    object: object as u32,
                    slot: slot as u32,
                    light_local: silhouette.light_local,
                    extrusion,
                    depth_pass,
                    sides: true,
                    near_cap: !depth_pass,
                    far_cap: true,
                };
                let corners = volume_corners(light.point_world, extrusion, &bounds);
                match parts.cull(volume, &corners, &bounds) {
                    Some(volume) => {
                        if finite.is_some() {
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
