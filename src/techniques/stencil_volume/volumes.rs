//! The frame's shadow volumes: which parts of which caster are drawn, and how they are counted.
//!
//! What a caster of a light's set S has of them is decided here and in [`parts`](super::volume_parts).
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use bevy_ecs::prelude::*;
use glam::Vec4;

use super::component::{Counting, Extent, StencilVolume};
use super::volume_parts::PartCulling;
use crate::scene::placement::Placement;
use crate::scene::{PosedMesh, SceneMesh};
use crate::sets::{CameraOcclusion, DepthReach, FrameLights, Objects, View};
use crate::silhouettes::{CasterEdges, Silhouettes};
use crate::techniques::shared::extrude::{TO_INFINITY, finite_extrusion, volume_corners};
use crate::techniques::shared::finite_reach::{FiniteReach, NearestSurfaces, include_points};
use crate::techniques::shared::inside_test::OcclusionPyramid;
use crate::techniques::shared::near_caps::NearCaps;

/// The volume of one caster in one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterVolume {
    /// Dense index of the caster.
    pub object: u32,
    /// Slot of its silhouette in the light's [`LightSilhouettes`](crate::silhouettes::LightSilhouettes).
    pub slot: u32,
    /// The light in the caster's space.
    pub light_local: Vec4,
    /// See [`far_position`](crate::techniques::shared::extrude::far_position).
    pub extrusion: f32,
    /// Counted towards the viewer (depth-pass); else away from it (depth-fail).
    pub depth_pass: bool,
    /// The sides are drawn.
    pub sides: bool,
    /// The near cap is drawn.
    pub near_cap: bool,
    /// The far cap is drawn.
    pub far_cap: bool,
}

/// The volumes in one light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightVolumes {
    /// Index into [`FrameLights`].
    pub light: usize,
    /// The light.
    pub entity: Entity,
    /// Ascending by object.
    pub casters: Vec<CasterVolume>,
    /// Casters of S whose volume was left out as a whole: it misses the view, or the depths that the light reaches.
    pub culled: usize,
}

/// The volumes of this frame, for each light with a [`StencilVolume`] that lights something. Written by
/// [`build_stencil_volumes`].
#[derive(Resource, Clone, Debug, Default)]
pub struct StencilVolumes {
    /// Ascending by light.
    pub lights: Vec<LightVolumes>,
    spare: Vec<Vec<CasterVolume>>,
    surfaces: NearestSurfaces,
}

impl StencilVolumes {
    /// The volumes in a light of [`FrameLights`].
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
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], [`Silhouettes`], what stands before the camera; writes
/// [`StencilVolumes`].
/// In an orthographic view it tells [`DepthReach`] how deep they reach. Cost: one pyramid and one hull test a caster of S.
pub fn build_stencil_volumes(
    mut volumes: ResMut<StencilVolumes>,
    mut depth_reach: ResMut<DepthReach>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    silhouettes: Res<Silhouettes>,
    near_caps: NearCaps,
    occlusion: Res<CameraOcclusion>,
    components: Query<&StencilVolume>,
    casters: Query<(&CasterEdges, &SceneMesh, Placement, Option<&PosedMesh>)>,
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
        let Ok(settings) = components.get(light.entity) else {
            continue;
        };
        if light.scissor.is_none() {
            continue; // nothing that is visible receives it
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
            for object in light.s.ones() {
                let Some((slot, silhouette)) = known.of_object(object) else {
                    continue;
                };
                if silhouette.contour.edge_count() == 0 && silhouette.contour.caps.is_empty() {
                    continue;
                }
                let caster = casters.get(objects.entities[object]);
                let shows_fronts_alone = || caster.is_ok_and(|caster| caster.0.0.shows_fronts_alone);
                let hides_cap = near_caps.are_hidden(&objects, object, shows_fronts_alone);
                let depth_pass = settings.counting == Counting::Auto
                    && hides_cap
                    && pyramid.excludes(&objects.boxes.get(object));
                let entity = objects.entities[object];
                let bounds = objects.boxes.get(object);
                let extrusion = match &finite {
                    Some(finite) => finite.extrusion(&bounds, || {
                        let key = (light.entity, 0, entity);
                        let (edges, mesh, place, posed) = casters.get(entity).ok()?;
                        let placed = (edges, mesh, place.world_from_local()?, posed);
                        surfaces.get(key, silhouette.revision, light.point_world, placed)
                    }),
                    None if settings.extent == Extent::Finite => finite_extrusion(
                        light.point_world,
                        light.light.range,
                        &bounds,
                        &light.lit_receivers,
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
                            include_points(&mut depth_reach, view, corners);
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
