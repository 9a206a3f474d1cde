//! The smoothies of each face, from the silhouettes of its casters.

use std::ops::Range;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::DVec3;

use crate::scene::placement::world_from_local;
use crate::scene::{AlphaMode, PosedMesh, SceneMaterials, SceneMesh};
use crate::sets::Objects;
use crate::silhouettes::{LightSilhouettes, Silhouettes};
use crate::techniques::maps::LightMap;
use crate::techniques::smoothie::outline::{Stand, push_smoothies};
use crate::techniques::smoothie::records::SmoothieEdge;

/// The smoothies of a frame. The memory is reused.
#[derive(Debug, Default)]
pub struct Smoothies {
    /// The records of all edges of the frame.
    pub edges: Vec<SmoothieEdge>,
    /// Ranges of `edges`, each one draw.
    pub draws: Vec<Range<u32>>,
    /// The casters of the current light whose edges are in `edges`, with their ranges.
    known: Vec<(usize, Range<u32>)>,
    scratch: Vec<[u32; 2]>,
}

/// A light whose smoothies are planned.
#[derive(Clone, Copy, Debug)]
pub struct PlannedLight<'a> {
    /// The map of the light.
    pub map: &'a LightMap,
    /// Origin of the edges' records, world space.
    pub anchor: DVec3,
    /// True for a directional light.
    pub is_parallel: bool,
}

impl Smoothies {
    /// Removes the smoothies of the last frame.
    pub fn clear(&mut self) {
        self.edges.clear();
        self.draws.clear();
        self.known.clear();
    }

    /// Begins another light.
    pub fn begin_light(&mut self) {
        self.known.clear();
    }

    /// Adds the smoothies of a set of casters, and returns the range of their draws.
    pub fn push(&mut self, world: &World, light: &PlannedLight, set: &FixedBitSet) -> Range<usize> {
        let first = self.draws.len();
        let silhouettes = world.resource::<Silhouettes>().of_light(light.map.entity);
        if let Some(silhouettes) = silhouettes {
            for object in set.ones() {
                let range = self.of_object(world, light, silhouettes, object);
                if range.is_empty() {
                    continue;
                }
                match self.draws[first..].last_mut() {
                    Some(last) if last.end == range.start => last.end = range.end,
                    _ => self.draws.push(range),
                }
            }
        }
        first..self.draws.len()
    }

    /// Returns the range of one caster's edges, which it makes if another face has not yet.
    fn of_object(
        &mut self,
        world: &World,
        light: &PlannedLight,
        silhouettes: &LightSilhouettes,
        object: usize,
    ) -> Range<u32> {
        let at = match self.known.binary_search_by_key(&object, |(object, _)| *object) {
            Ok(at) => return self.known[at].1.clone(),
            Err(at) => at,
        };
        let first = self.edges.len() as u32;
        let _ = self.push_edges(world, light, silhouettes, object);
        let range = first..self.edges.len() as u32;
        self.known.insert(at, (object, range.clone()));
        range
    }

    fn push_edges(
        &mut self,
        world: &World,
        light: &PlannedLight,
        silhouettes: &LightSilhouettes,
        object: usize,
    ) -> Option<()> {
        let entity = world.resource::<Objects>().entities[object];
        let (_, silhouette) = silhouettes.of_object(object)?;
        if has_holes(world, entity) {
            return None;
        }
        let world_from_local = world_from_local(world, entity)?;
        let mesh = &world.get::<SceneMesh>(entity)?.0.positions;
        let posed = world
            .get::<PosedMesh>(entity)
            .filter(|posed| posed.is_whole(mesh.len()));
        let stand = Stand {
            positions: posed.map_or(mesh, |posed| &posed.positions),
            world_from_local: &world_from_local,
            anchor: light.anchor,
            along: light
                .is_parallel
                .then(|| light.map.faces[0].face.axes[2].as_vec3()),
            beside: light.map.request.beside.as_ref()?,
        };
        push_smoothies(&silhouette.contour, &stand, &mut self.scratch, &mut self.edges);
        Some(())
    }
}

/// Whether a caster's texture cuts holes. Its outline is then not that of its triangles, and smoothies around the
/// triangles would darken what shines past the texture.
fn has_holes(world: &World, entity: Entity) -> bool {
    let materials = world.get::<SceneMaterials>(entity);
    materials.is_some_and(|materials| {
        let mut modes = materials.0.iter().map(|material| material.alpha_mode);
        modes.any(|mode| matches!(mode, AlphaMode::Mask(_)))
    })
}
