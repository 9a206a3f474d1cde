//! The system that makes the frame's wedges.

use bevy_ecs::prelude::*;
use glam::DVec3;

use super::chunks::{Chunk, ChunkKey, chunks_of};
use super::component::{Overlap, PenumbraWedge, WedgeCulling};
use super::geometry::cut::cutting_distance;
use super::light_parts::{LightPart, PartShape, push_parts};
use super::part_patches::Placed;
use super::seen_caster::{SeenCaster, light_from_local};
use super::tables::texture::EmitterTexture;
use super::wedges::{LightWedges, PartWedges, PenumbraWedges};
use crate::geometry::Aabb;
use crate::scene::placement::Placement;
use crate::sets::light::depth_bounds::shadow_depth_range;
use crate::sets::{DepthReach, FrameLight, FrameLights, Objects, View, ViewData};
use crate::silhouettes::cache::light_is_within;
use crate::silhouettes::{CasterShape, CasterShapeItem, KEPT_FRAMES, Silhouette, Silhouettes};
use crate::techniques::shared::extrude::{TO_INFINITY, volume_corners};
use crate::techniques::shared::finite_reach::{FiniteReach, include_points, include_rays};
use crate::techniques::shared::inside_test::OcclusionPyramid;
use crate::techniques::shared::near_caps::NearCaps;

/// Factor on the largest distance of a receiver from the light, which gives the length of a shell's rays. The
/// triangles between rays that are less than 172° apart then pass beyond all receivers.
const RAY_SHARE: f64 = 16.0;

/// Makes the wedges of every caster of every light with a [`PenumbraWedge`] where none are known or the known
/// ones are stale, and lists what the frame draws. A light without any wedge or cap is not listed, unless it has a
/// texture: nothing is recorded for it, and it counts as unshadowed.
///
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], [`Silhouettes`] and what hides near
/// caps; writes [`PenumbraWedges`] and, in an orthographic view, extends [`DepthReach`] to the wedges. Cost:
/// a matrix inverse for each caster of S, and the edges of what moved.
pub fn build_penumbra_wedges(
    mut wedges: ResMut<PenumbraWedges>,
    depth_reach: Res<DepthReach>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    silhouettes: Res<Silhouettes>,
    near_caps: NearCaps,
    components: Query<(&PenumbraWedge, Option<&EmitterTexture>)>,
    casters: Query<CasterShape>,
    places: Query<Placement>,
) {
    let out = &mut *wedges;
    out.frame += 1;
    let frame = out.frame;
    out.lights.clear();
    out.parts.clear();
    out.surfaces.begin_frame();
    std::mem::swap(&mut out.scratch.layout, &mut out.scratch.last_layout);
    out.scratch.layout.clear();
    let Some(view) = &view.data else {
        out.assemble(!out.casters.is_empty()); // else the next frame without casters would draw those of the last one
        return;
    };
    let near = &view.near_corners;
    let context = Context {
        view,
        around: [near[0], near[1], near[3], near[2]],
        objects: &objects,
        depth_reach: &depth_reach,
        near_caps: &near_caps,
    };
    let mut rebuilt = false;
    for (index, light) in lights.lights.iter().enumerate() {
        if !light.is_shadowed_by::<PenumbraWedge>() {
            continue;
        }
        let Ok((settings, texture)) = components.get(light.entity) else {
            continue;
        };
        if light.region.scissor.is_none() {
            continue; // no visible surface receives the light
        }
        let placed = out.scratch.layout.len();
        let first = out.begin_light(index, light, settings, texture, view);
        if let Some(known) = silhouettes.of_light(light.entity) {
            if let Some(this) = out.lights.last_mut() {
                this.stacked = known.stacked;
            }
            for number in 0..out.scratch.parts.len() {
                let part = out.scratch.parts[number];
                let part = PartContext {
                    light,
                    settings,
                    part: &part,
                    number: number as u32,
                    first: first as u32,
                    reach: out.parts[first + number].reach,
                    pyramid: OcclusionPyramid::new(&context.around, part.point_world),
                    finite: FiniteReach::new(view, light, part.point_world),
                };
                for object in light.sets.s.ones() {
                    if let Some((_, silhouette)) = known.of_object(object)
                        && let Ok(caster) = casters.get(objects.entities[object])
                    {
                        rebuilt |= out.place(&context, &part, object, silhouette, &caster);
                    }
                }
            }
        }
        chunks_of(&mut out.kept, light.entity, frame).retain(|chunk| chunk.last_used + KEPT_FRAMES >= frame);
        // The mask also carries the colours of a texture, which a light without shadows has as well.
        let has_texture = out.lights.last().is_some_and(|light| light.texture.is_some());
        if out.scratch.layout.len() == placed && !has_texture {
            out.lights.pop();
            out.parts.truncate(first);
        }
    }
    out.kept.retain(|light| light.last_used + KEPT_FRAMES >= frame);
    let same_layout = out.scratch.layout == out.scratch.last_layout;
    out.assemble(rebuilt || !same_layout);
    let viewport = Aabb::from_points(near.map(|corner| corner.as_vec3()));
    out.end(&viewport, &lights, &objects, &places);
}

/// Inputs that all lights of the frame share.
struct Context<'a, 'w> {
    view: &'a ViewData,
    /// The corners of the near plane, in their order around it.
    around: [DVec3; 4],
    objects: &'a Objects,
    depth_reach: &'a DepthReach,
    near_caps: &'a NearCaps<'w>,
}

/// One part of one light.
struct PartContext<'a> {
    light: &'a FrameLight,
    settings: &'a PenumbraWedge,
    part: &'a LightPart,
    /// Among the parts of the light.
    number: u32,
    /// The light's first among the parts of the frame.
    first: u32,
    reach: f32,
    pyramid: OcclusionPyramid,
    finite: Option<FiniteReach>,
}

impl PenumbraWedges {
    /// Lists a light and its parts; the index of the first of these.
    fn begin_light(
        &mut self,
        index: usize,
        light: &FrameLight,
        settings: &PenumbraWedge,
        texture: Option<&EmitterTexture>,
        view: &ViewData,
    ) -> usize {
        let first = self.parts.len();
        let parts = &mut self.scratch.parts;
        parts.clear();
        push_parts(light, settings, parts);
        self.parts.extend(parts.iter().map(|part| {
            PartWedges {
                part: *part,
                reach: FiniteReach::new(view, light, part.point_world)
                    .filter(|_| part.point_world.w != 0.0)
                    .map_or(0.0, |finite| (finite.distance().max(0.0) * RAY_SHARE) as f32),
                groups: 0..0,
            }
        }));
        let is_rect = matches!(parts[0].shape, PartShape::Rect { .. });
        self.lights.push(LightWedges {
            light: index,
            entity: light.entity,
            settings: *settings,
            texture: texture.filter(|_| is_rect).cloned(),
            parts: first..self.parts.len(),
            is_layered: false,
            stacked: 0,
            cuts_left_out: 0,
        });
        first
    }

    /// Adds a caster to a part of the light that was listed last, if its shadow reaches what the light lights in view;
    /// whether wedges were made anew.
    fn place(
        &mut self,
        context: &Context,
        part: &PartContext,
        object: usize,
        silhouette: &Silhouette,
        caster: &CasterShapeItem,
    ) -> bool {
        let (light, settings, view) = (part.light, part.settings, context.view);
        let entity = context.objects.entities[object];
        let bounds = context.objects.boxes.get(object);
        // A shadow before the nearest or beyond the farthest surface that the light reaches.
        let reaches = light.region.depth_bounds.is_some_and(|reached| {
            shadow_depth_range(view, &bounds, &light.emitter)
                .is_some_and(|spanned| spanned.intersects(&reached))
        });
        if !reaches {
            return false;
        }
        let Some(world_from_local) = caster.world_from_local() else {
            return false;
        };
        let Some(light_from_local) = light_from_local(part.part, &world_from_local) else {
            return false;
        };
        let Some(extrusion) = self.extrusion(context, part, (entity, &bounds), silhouette, caster) else {
            return false; // beyond all that receives the light
        };
        let point = part.part.point_world;
        let key = ChunkKey {
            revision: silhouette.revision,
            light_from_local: light_from_local.as_mat4(),
            shape: part.part.shape,
            bounds: settings.bounds,
            by_patch: settings.overlap == Overlap::Paper,
            silhouette: settings.used_silhouette(),
            touches: light_is_within(&bounds, point, cutting_distance(part.part.shape, light.clearance))
                .then_some(light.clearance),
        };
        let chunks = chunks_of(&mut self.kept, light.entity, self.frame);
        let at = chunks
            .binary_search_by_key(&(entity, part.number), |chunk| (chunk.entity, chunk.part))
            .unwrap_or_else(|at| {
                chunks.insert(at, Chunk::empty(entity, part.number, key));
                at
            });
        let chunk = &mut chunks[at];
        let stale = chunk.last_used == 0 || chunk.key != key;
        chunk.last_used = self.frame;
        if stale {
            chunk.key = key;
            let scratch = &mut self.scratch.chunk;
            let seen = SeenCaster::new(part.part, caster, &world_from_local, light_from_local);
            chunk.build(seen.as_ref(), silhouette.mode, scratch);
        }
        if let Some(this) = self.lights.last_mut() {
            this.is_layered |= chunk.is_layered;
            this.cuts_left_out += chunk.cuts_left_out;
        }
        if chunk.wedges.is_empty() && chunk.caps.is_empty() {
            return stale;
        }
        let shows_fronts_alone = || caster.edges.0.shows_fronts_alone;
        let is_cutting = chunk.is_cutting;
        let hides_cap = context
            .near_caps
            .are_hidden(context.objects, object, shows_fronts_alone);
        // From elsewhere on the light than its centre, the pyramid is within the light's radius of that from the centre.
        let radius = part.part.shape.radius() as f32;
        let around = Aabb {
            min: bounds.min - radius,
            max: bounds.max + radius,
        };
        self.scratch.layout.push(Placed {
            light: light.entity,
            part: part.number,
            index: part.first + part.number,
            caster: entity,
            object: object as u32,
            towards: settings.culling == WedgeCulling::Depth
                && !is_cutting
                && hides_cap
                && part.pyramid.excludes(&around),
            extrusion: extrusion.to_bits(),
        });
        stale
    }

    /// How far a caster's shadow is pushed; `None` if it is beyond all that receives the light.
    fn extrusion(
        &mut self,
        context: &Context,
        part: &PartContext,
        (entity, bounds): (Entity, &Aabb),
        silhouette: &Silhouette,
        caster: &CasterShapeItem,
    ) -> Option<f32> {
        let Some(finite) = part.finite else {
            return Some(TO_INFINITY);
        };
        let point = part.part.point_world;
        let extrusion = finite.extrusion(bounds, || {
            let key = (part.light.entity, part.number, entity);
            self.surfaces.get(key, silhouette.revision, point, caster)
        })?;
        let corners = volume_corners(point, extrusion, bounds);
        include_points(context.depth_reach, context.view, corners);
        include_rays(context.depth_reach, context.view, bounds, part.reach);
        Some(extrusion)
    }
}
