//! The frame's wedges: flat arrays over all lights, made anew only where something moved.

use std::ops::Range;

use bevy_ecs::prelude::*;

use super::chunks::{CasterItem, Chunk, ChunkKey, ChunkScratch, LightChunks, chunks_of, light_from_local};
use super::component::{Overlap, PenumbraWedge, WedgeCulling};
use super::geometry::patches::ShadowCone;
use super::geometry::records::{Wedge, WedgeCaster};
use super::light_parts::{LightPart, PartShape, push_parts};
use super::tables::texture::EmitterTexture;
use crate::geometry::Aabb;
use crate::scene::placement::Placement;
use crate::sets::light::depth_bounds::shadow_depth_range;
use crate::sets::{DepthReach, FrameLights, Objects, View};
use crate::silhouettes::cache::light_is_within;
use crate::silhouettes::{LightClearance, Silhouettes};
use crate::techniques::shared::extrude::{TO_INFINITY, volume_corners};
use crate::techniques::shared::finite_reach::{FiniteReach, NearestSurfaces, include_points, include_rays};
use crate::techniques::shared::inside_test::OcclusionPyramid;
use crate::techniques::shared::near_caps::NearCaps;

/// The wedges of this frame, for each light with a [`PenumbraWedge`] that lights something. Written by
/// [`build_penumbra_wedges`].
#[derive(Resource, Debug, Default)]
pub struct PenumbraWedges {
    /// Ascending by light.
    pub lights: Vec<LightWedges>,
    /// Parts of all lights.
    pub parts: Vec<PartWedges>,
    /// What is summed by itself; one a part, or with [`Overlap::Paper`] as many as [patches](super::geometry::patches) meet.
    pub groups: Vec<Group>,
    /// Casters of all parts.
    pub casters: Vec<CasterDraw>,
    /// The same for the GPU.
    pub caster_records: Vec<WedgeCaster>,
    /// Edges of all casters.
    pub wedges: Vec<Wedge>,
    /// Cap triangles of all casters: vertices of their meshes, wound towards the light.
    pub caps: Vec<u32>,
    /// Increases when `wedges` or `caps` changed, and how many casters there are.
    pub generation: u64,
    /// Increases when `caster_records` changed.
    pub casters_generation: u64,
    pub(super) kept: Vec<LightChunks>,
    pub(super) scratch: Scratch,
    surfaces: NearestSurfaces,
    frame: u64,
}

/// One light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightWedges {
    /// Index into [`FrameLights`].
    pub light: usize,
    /// The light.
    pub entity: Entity,
    /// Copy of the component.
    pub settings: PenumbraWedge,
    /// Copy of the component, for rectangles.
    pub texture: Option<EmitterTexture>,
    /// Range of [`PenumbraWedges::parts`].
    pub parts: Range<usize>,
    /// Some caster is not the same in both [layers](super::geometry::silhouette_layers).
    pub is_layered: bool,
    /// Casters that lie one behind the other, about.
    pub stacked: u32,
}

/// One part of a light.
#[derive(Clone, Debug, PartialEq)]
pub struct PartWedges {
    /// Where and what it is.
    pub part: LightPart,
    /// Metres at which rays of shells end; 0: at infinity.
    pub reach: f32,
    /// Range of [`PenumbraWedges::groups`].
    pub groups: Range<usize>,
}

/// Casters whose shadows are summed.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Range of [`PenumbraWedges::casters`].
    pub casters: Range<usize>,
    /// Range of [`PenumbraWedges::wedges`]: those that count where they are before the surface.
    pub towards: Range<u32>,
    /// Those that count where they are behind it.
    pub away: Range<u32>,
}

impl Group {
    /// All of them.
    pub fn wedges(&self) -> Range<u32> {
        self.towards.start..self.away.end
    }
}

/// One caster of one part.
#[derive(Clone, Debug, PartialEq)]
pub struct CasterDraw {
    /// Dense index.
    pub object: u32,
    /// Ranges of [`PenumbraWedges::caps`]: facing, averted, both [layers](super::geometry::silhouette_layers).
    pub caps: [Range<u32>; 6],
    /// Counted towards the viewer: it shadows no part of the viewport, and its own surface hides the caps.
    pub towards: bool,
}

#[derive(Debug, Default)]
pub(super) struct Scratch {
    chunk: ChunkScratch,
    parts: Vec<LightPart>,
    /// What the flat arrays hold, and held in the last frame.
    pub(super) layout: Vec<Placed>,
    last_layout: Vec<Placed>,
    /// Of the parts of the frame that the flat arrays were made for.
    pub(super) part_groups: Vec<Range<usize>>,
    /// Patches of one part: index into `layout`, and number within the chunk; where their shadows go; their sums.
    pub(super) entries: Vec<(usize, usize)>,
    pub(super) cones: Vec<ShadowCone>,
    pub(super) sums: Vec<u32>,
}

/// A chunk in the flat arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Placed {
    pub(super) light: Entity,
    /// Number of the part in its light.
    pub(super) part: u32,
    /// Index of the part in the frame.
    pub(super) index: u32,
    pub(super) caster: Entity,
    pub(super) object: u32,
    pub(super) towards: bool,
    /// Bits of [`WedgeCaster::extrusion`].
    pub(super) extrusion: u32,
}

/// Rays of shells end so many times farther from the edge than receivers are from the light: the triangles between rays
/// that are less than 172° apart pass beyond all receivers.
const RAY_SHARE: f64 = 16.0;

/// Frames that a chunk outlives its last use; as of silhouettes.
const KEPT_FRAMES: u64 = 120;

impl PenumbraWedges {
    /// The wedges of a light of [`FrameLights`].
    pub fn of_light(&self, light: usize) -> Option<&LightWedges> {
        let at = self
            .lights
            .binary_search_by_key(&light, |entry| entry.light)
            .ok()?;
        Some(&self.lights[at])
    }
}

/// Makes the wedges of every edge of every caster of every light with a [`PenumbraWedge`], those that are not known yet
/// or stale, and lists what the frame draws.
///
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], [`Silhouettes`], [`NearCaps`]; writes
/// [`PenumbraWedges`]. In an orthographic view it tells [`DepthReach`] how deep they reach.
/// Cost: an inverse a caster of S; the edges of what moved.
pub fn build_penumbra_wedges(
    mut wedges: ResMut<PenumbraWedges>,
    mut depth_reach: ResMut<DepthReach>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    silhouettes: Res<Silhouettes>,
    near_caps: NearCaps,
    clearance: Res<LightClearance>,
    components: Query<(&PenumbraWedge, Option<&EmitterTexture>)>,
    casters: Query<CasterItem<'static>>,
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
        return;
    };
    let near = &view.near_corners;
    let around = [near[0], near[1], near[3], near[2]];
    let mut rebuilt = false;
    for (index, light) in lights.lights.iter().enumerate() {
        let Ok((settings, texture)) = components.get(light.entity) else {
            continue;
        };
        if light.scissor.is_none() {
            continue; // nothing that is visible receives it
        }
        let first = out.parts.len();
        out.scratch.parts.clear();
        push_parts(light, settings, &mut out.scratch.parts);
        out.parts.extend(out.scratch.parts.iter().map(|part| {
            PartWedges {
                part: *part,
                reach: FiniteReach::new(view, light, part.point_world)
                    .filter(|_| part.point_world.w != 0.0)
                    .map_or(0.0, |finite| (finite.distance().max(0.0) * RAY_SHARE) as f32),
                groups: 0..0,
            }
        }));
        out.lights.push(LightWedges {
            light: index,
            entity: light.entity,
            settings: *settings,
            texture: texture
                .filter(|_| matches!(out.scratch.parts[0].shape, PartShape::Rect { .. }))
                .cloned(),
            parts: first..out.parts.len(),
            is_layered: false,
            stacked: silhouettes
                .of_light(light.entity)
                .map_or(0, |known| known.stacked),
        });
        let this = out.lights.len() - 1;
        let Some(known) = silhouettes.of_light(light.entity) else {
            continue;
        };
        let chunks = chunks_of(&mut out.kept, light.entity, frame);
        for number in 0..out.scratch.parts.len() {
            let part = out.scratch.parts[number];
            let pyramid = OcclusionPyramid::new(&around, part.point_world);
            let finite = FiniteReach::new(view, light, part.point_world);
            let reach = out.parts[first + number].reach;
            for object in light.s.ones() {
                let Some((_, silhouette)) = known.of_object(object) else {
                    continue;
                };
                let entity = objects.entities[object];
                let Ok(item) = casters.get(entity) else {
                    continue;
                };
                // A shadow before the nearest or beyond the farthest surface that the light reaches.
                let reaches = light.depth_bounds.is_some_and(|reached| {
                    shadow_depth_range(view, &objects.boxes.get(object), &light.emitter)
                        .is_some_and(|spanned| spanned.intersects(&reached))
                });
                if !reaches {
                    continue;
                }
                let Some(world_from_local) = item.2.world_from_local() else {
                    continue;
                };
                let Some(light_from_local) = light_from_local(&part, &world_from_local) else {
                    continue;
                };
                let bounds = objects.boxes.get(object);
                let extrusion = finite.map(|finite| {
                    finite.extrusion(&bounds, || {
                        let key = (light.entity, number as u32, entity);
                        let placed = (item.0, item.1, world_from_local, item.3.map(|(posed, _)| posed));
                        out.surfaces
                            .get(key, silhouette.revision, part.point_world, placed)
                    })
                });
                let extrusion = match extrusion {
                    None => TO_INFINITY,
                    Some(Some(extrusion)) => {
                        let corners = volume_corners(part.point_world, extrusion, &bounds);
                        include_points(&mut depth_reach, view, corners);
                        include_rays(&mut depth_reach, view, &bounds, reach);
                        extrusion
                    }
                    Some(None) => continue, // beyond all that receives the light
                };
                let metres = clearance.metres(part.point_world, light.light.range, &bounds);
                let key = ChunkKey {
                    revision: silhouette.revision,
                    light_from_local: light_from_local.as_mat4(),
                    shape: part.shape,
                    bounds: settings.bounds,
                    by_patch: settings.overlap == Overlap::Paper,
                    silhouette: settings.used_silhouette(),
                    clearance: if light_is_within(&bounds, part.point_world, metres) {
                        metres
                    } else {
                        0.0
                    },
                };
                let number = number as u32;
                let at = match chunks
                    .binary_search_by_key(&(entity, number), |chunk| (chunk.entity, chunk.part))
                {
                    Ok(at) => at,
                    Err(at) => {
                        chunks.insert(at, Chunk::empty(entity, number, key));
                        at
                    }
                };
                let chunk = &mut chunks[at];
                let fresh = chunk.last_used == 0;
                chunk.last_used = frame;
                if fresh || chunk.key != key {
                    chunk.key = key;
                    chunk.build(
                        light,
                        &part,
                        &light_from_local,
                        silhouette,
                        (item.0, item.1, &world_from_local, item.3),
                        &mut out.scratch.chunk,
                    );
                    rebuilt = true;
                }
                out.lights[this].is_layered |= chunk.is_layered;
                if !(chunk.wedges.is_empty() && chunk.caps.is_empty()) {
                    // From elsewhere on the light than its centre, the pyramid is within the light's radius of that from
                    // the centre.
                    let hides_cap = near_caps.are_hidden(&objects, object, || item.0.0.shows_fronts_alone);
                    let radius = part.shape.radius() as f32;
                    let towards = settings.culling == WedgeCulling::Depth
                        && hides_cap
                        && pyramid.excludes(&Aabb {
                            min: bounds.min - radius,
                            max: bounds.max + radius,
                        });
                    let layout = &mut out.scratch.layout;
                    layout.push(Placed {
                        light: light.entity,
                        part: number,
                        index: first as u32 + number,
                        caster: entity,
                        object: object as u32,
                        towards,
                        extrusion: extrusion.to_bits(),
                    });
                }
            }
        }
        chunks.retain(|chunk| chunk.last_used + KEPT_FRAMES >= frame);
    }
    out.kept.retain(|light| light.last_used + KEPT_FRAMES >= frame);
    let same_layout = out.scratch.layout == out.scratch.last_layout;
    out.assemble(rebuilt || !same_layout);
    out.end(&lights, &objects, &places);
}
