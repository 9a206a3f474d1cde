//! The frame's shadow volumes: which parts of which caster are drawn, and how they are counted.
//!
//! A caster of a light's set S has up to three parts, each left out where it cannot matter:
//!
//! | part | left out |
//! | --- | --- |
//! | sides | their bounds miss the view frustum |
//! | near cap | depth-pass (it lies on the caster's own, drawn surface), or the caster's bounds miss the frustum |
//! | far cap | directional light (all far corners are one point), depth-pass to infinity (nothing is behind infinity), or its bounds miss the frustum |
//!
//! A finite volume keeps its far cap under depth-pass: a pixel inside the light's range may be seen through it.
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use bevy_ecs::prelude::*;
use glam::{DVec4, Vec4};

use super::component::{Counting, Extent, StencilVolume};
use super::extrude::{TO_INFINITY, finite_extrusion, volume_corners};
use super::inside_test::OcclusionPyramid;
use crate::scene::FaceCulling;
use crate::sets::depth_bounds::shadow_depth_range;
use crate::sets::{FrameLight, FrameLights, Objects, SeenInto, View, ViewData};
use crate::silhouettes::{CasterEdges, Silhouettes};

/// The volume of one caster in one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterVolume {
    /// Dense index of the caster.
    pub object: u32,
    /// Slot of its silhouette in the light's [`LightSilhouettes`](crate::silhouettes::LightSilhouettes).
    pub slot: u32,
    /// The light in the caster's space.
    pub light_local: Vec4,
    /// See [`far_position`](super::extrude::far_position).
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
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], [`Silhouettes`]; writes [`StencilVolumes`].
/// Cost: one pyramid and one hull test a caster of S.
pub fn build_stencil_volumes(
    mut volumes: ResMut<StencilVolumes>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    silhouettes: Res<Silhouettes>,
    seen_into: Res<SeenInto>,
    face_culling: Res<FaceCulling>,
    components: Query<&StencilVolume>,
    casters: Query<&CasterEdges>,
) {
    let StencilVolumes { lights: out, spare } = &mut *volumes;
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
        if let Some(known) = silhouettes.of_light(light.entity) {
            for object in light.s.ones() {
                let Some((slot, silhouette)) = known.of_object(object) else {
                    continue;
                };
                if silhouette.contour.edge_count() == 0 && silhouette.contour.caps.is_empty() {
                    continue;
                }
                // Its own surface hides the near cap only where all of the surface is drawn.
                let hides_cap = objects.drawn.contains(object)
                    && !seen_into.0.contains(object)
                    && (*face_culling == FaceCulling::None
                        || casters
                            .get(objects.entities[object])
                            .is_ok_and(|edges| edges.0.edges.is_closed()));
                let depth_pass = settings.counting == Counting::Auto
                    && hides_cap
                    && pyramid.excludes(&objects.boxes.get(object));
                let volume = CasterVolume {
                    object: object as u32,
                    slot: slot as u32,
                    light_local: silhouette.light_local,
                    extrusion: TO_INFINITY,
                    depth_pass,
                    sides: true,
                    near_cap: !depth_pass,
                    far_cap: true,
                };
                match cull_parts(volume, settings, light, &objects, view) {
                    Some(volume) => entry.casters.push(volume),
                    None => entry.culled += 1,
                }
            }
        }
        out.push(entry);
    }
}

/// Chooses the extrusion and drops parts that cannot matter; `None` if none is left.
fn cull_parts(
    mut volume: CasterVolume,
    settings: &StencilVolume,
    light: &FrameLight,
    objects: &Objects,
    view: &ViewData,
) -> Option<CasterVolume> {
    let bounds = objects.boxes.get(volume.object as usize);
    let point: DVec4 = light.point_world;
    if settings.extent == Extent::Finite {
        volume.extrusion = finite_extrusion(point, light.light.range, &bounds);
    }
    let to_infinity = volume.extrusion == TO_INFINITY;
    let corners = volume_corners(point, volume.extrusion, &bounds);
    let planes = &view.frustum.planes;
    volume.sides = !planes.excludes_points(&corners);
    volume.near_cap &= !planes.excludes_points(&corners[..8]);
    volume.far_cap =
        point.w != 0.0 && !(volume.depth_pass && to_infinity) && !planes.excludes_points(&corners[8..]);
    if !(volume.sides || volume.near_cap || volume.far_cap) {
        return None;
    }
    // A volume that ends before the nearest, or begins beyond the farthest surface that the light reaches, counts to 0
    // at all of them.
    let reached = light.depth_bounds?;
    let spanned = shadow_depth_range(view, &bounds, &light.emitter)?;
    spanned.intersects(&reached).then_some(volume)
}
