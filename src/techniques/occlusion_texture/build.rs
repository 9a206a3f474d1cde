//! The frame's occlusion textures: which lights have them, what they show, and which are drawn again.
//!
//! Pictures show everything that the light reaches, whether or not it is in view, so that shadows do not change as the
//! camera moves. They are kept from frame to frame, and drawn and filtered again when a caster, the light or a setting
//! changes.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;

use super::casters::{FrameObjects, Scratch};
use super::component::OcclusionTexture;
use super::light_slices::LightSlices;
use super::scene_box::OwnBox;
use super::shell::is_shell_around;
use crate::scene::placement::Placement;
use crate::scene::{AlphaMode, LocalBounds, SceneMaterials};
use crate::sets::{FrameLights, Objects};
use crate::silhouettes::CasterEdges;
use crate::techniques::registry::Technique;
use crate::techniques::shared::exchanged::Exchanged;
use crate::techniques::shared::texture_memory::{Storage, TextureMemory, TextureWant};

/// Least resolution that a shortage of memory leaves, texels.
const LEAST: u32 = 32;

/// The occlusion textures of this frame. Written by the systems `ask_for_slices` and `build_slices`.
#[derive(Resource, Clone, Debug, Default)]
pub struct OcclusionTextures {
    /// All lights with occlusion textures, ascending by light. They include lights out of view, because their pictures are
    /// kept.
    pub lights: Vec<LightSlices>,
    previous: Vec<LightSlices>,
    exchanged: FixedBitSet,
    scratch: Scratch,
    revision: u64,
}

impl OcclusionTextures {
    /// Returns the pictures of a light of [`FrameLights`], if they are looked up in this frame. A light without casters has none.
    pub fn of_light(&self, light: usize) -> Option<&LightSlices> {
        let at = self
            .lights
            .binary_search_by_key(&light, |slices| slices.light)
            .ok()?;
        Some(&self.lights[at]).filter(|slices| slices.is_active)
    }
}

/// Lists the lights with occlusion textures, fits their slices to what they reach, and asks for their memory.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Ask`](crate::techniques::TextureMemorySystems::Ask). Reads
/// [`FrameLights`] and [`Objects`]; writes [`OcclusionTextures`] and [`TextureMemory`]. Cost: O(words of L) for a light of
/// which nothing changed, else O(L), and O(L) for each caster that is about as wide as everything lit.
pub fn ask_for_slices(
    mut textures: ResMut<OcclusionTextures>,
    mut memory: ResMut<TextureMemory>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    components: Query<&OcclusionTexture>,
    exchanged: Exchanged,
    casters: Query<(&CasterEdges, &GlobalTransform, Option<&SceneMaterials>)>,
    placed: Query<(&LocalBounds, Placement)>,
) {
    let textures = &mut *textures;
    std::mem::swap(&mut textures.lights, &mut textures.previous);
    textures.lights.clear();
    textures.exchanged.clear();
    textures.exchanged.grow(objects.len());
    for object in exchanged.iter().filter_map(|entity| objects.index_of(entity)) {
        textures.exchanged.insert(object);
    }
    let frame = FrameObjects {
        objects: &objects,
        exchanged: &textures.exchanged,
        is_closed: &|entity| {
            let caster = casters.get(entity);
            caster.is_ok_and(|(edges, transform, materials)| is_closed(edges, transform, materials))
        },
        is_shell: &|entity, lit, emitter, rounding| {
            let caster = casters.get(entity).ok();
            let place = placed
                .get(entity)
                .ok()
                .and_then(|(_, placement)| placement.affine());
            caster
                .zip(place)
                .is_some_and(|((edges, ..), place)| is_shell_around(&edges.0, &place, lit, emitter, rounding))
        },
        own_box: &|entity| {
            let (local, placement) = placed.get(entity).ok()?;
            OwnBox::new(&local.0, &placement.affine()?)
        },
    };
    let mut old = textures.previous.drain(..).peekable();
    for (index, light) in lights.lights.iter().enumerate() {
        if !light.is_shadowed_by::<OcclusionTexture>() {
            continue;
        }
        let Ok(settings) = components.get(light.entity) else {
            continue;
        };
        while old.next_if(|slices| slices.entity < light.entity).is_some() {}
        let known = old.next_if(|slices| slices.entity == light.entity);
        let mut slices = known.unwrap_or_else(|| LightSlices::new(light.entity));
        slices.light = index;
        slices.is_active = false;
        let changed = slices.follow(light, settings, &frame, &mut textures.scratch);
        if changed {
            textures.revision += 1;
            slices.revision = textures.revision;
        }
        // Without casters all pictures would be empty: nothing is drawn or looked up, and no memory is needed.
        if !slices.casters.is_clear() {
            let want = TextureWant {
                bytes_per_square: slices.bytes_per_square(),
                resolution: settings.resolution,
                least: LEAST.min(settings.resolution),
                storage: Storage::OwnElseNothing,
            };
            memory.ask(index, OcclusionTexture::NAME, want);
        }
        textures.lights.push(slices);
    }
}

/// Whether only fronts of a caster are seen from outside. A caster with holes shows its inside, and a mirrored one is
/// turned inside out.
fn is_closed(edges: &CasterEdges, transform: &GlobalTransform, materials: Option<&SceneMaterials>) -> bool {
    let mut materials = materials.iter().flat_map(|materials| materials.0.iter());
    edges.0.shows_fronts_alone
        && transform.affine().matrix3.determinant() > 0.0
        && !materials.any(|material| matches!(material.alpha_mode, AlphaMode::Mask(_)))
}

/// Takes over the memory that each light gets. A light without casters gets none, and counts as unshadowed.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Build`](crate::techniques::TextureMemorySystems::Build). Reads
/// [`FrameLights`] and [`TextureMemory`]; writes [`OcclusionTextures`].
pub fn build_slices(
    mut textures: ResMut<OcclusionTextures>,
    memory: Res<TextureMemory>,
    lights: Res<FrameLights>,
) {
    let textures = &mut *textures;
    for slices in &mut textures.lights {
        let grant = memory.grant(slices.light, OcclusionTexture::NAME);
        let resolution = grant.map_or(0, |grant| grant.resolution);
        if slices.set_resolution(resolution) {
            textures.revision += 1;
            slices.revision = textures.revision;
        }
        slices.is_active = resolution > 0 && !lights.lights[slices.light].is_skipped();
    }
}
