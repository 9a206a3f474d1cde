//! Collects the objects that may hide others from the camera and from lights.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;
use glam::{DMat4, DVec3, Mat4};

use super::occluder_mesh::{OccluderMesh, OccluderMeshes};
use super::raster::Sides;
use super::settings::OcclusionSettings;
use crate::geometry::{Aabb, distance_to_triangle};
use crate::scene::changes::{NewAppearances, any_changed};
use crate::scene::{
    AlphaMode, FaceCulling, LeftOutSubmeshes, Occluder, PosedMesh, SceneMaterials, SceneMesh,
};
use crate::sets::index::objects::{Objects, resize};

/// Occluders, by dense object index. Written by [`collect_occluders`].
#[derive(Resource, Clone, Debug, Default)]
pub struct Occluders {
    /// Objects that may hide others from the camera.
    pub camera: FixedBitSet,
    /// Objects that may hide others from lights for which they cast.
    pub light: FixedBitSet,
    /// Objects that can be left out of lights which do not see them, because they are not drawn or because
    /// all of their surfaces show shadows.
    pub shadeable: FixedBitSet,
    /// Increases when occluders came or went.
    pub generation: u64,
    /// Occluders that moved in this frame.
    pub moved: FixedBitSet,
    /// Objects that have an entry.
    known: FixedBitSet,
    entries: Vec<Option<Entry>>,
    meshes: OccluderMeshes,
    seen: Option<(u64, OcclusionSettings, FaceCulling, [usize; 2])>,
}

#[derive(Clone, Debug)]
struct Entry {
    mesh: Arc<OccluderMesh>,
    world_from_local: DMat4,
    drawn_sides: Sides,
}

/// The components that [`collect_occluders`] reads.
#[derive(SystemParam)]
pub struct OccluderParts<'w, 's> {
    objects: Query<
        'w,
        's,
        (
            Option<&'static SceneMesh>,
            Option<&'static SceneMaterials>,
            Option<&'static Occluder>,
            Option<&'static LeftOutSubmeshes>,
            Has<PosedMesh>,
        ),
    >,
    appearances: NewAppearances<'w, 's>,
    occluders: Query<'w, 's, Ref<'static, Occluder>>,
    posed: Query<'w, 's, (), With<PosedMesh>>,
    transforms: Query<'w, 's, &'static GlobalTransform>,
}

impl OccluderParts<'_, '_> {
    /// Whether a mesh, a material or an occluder was replaced.
    fn exchanged(&mut self) -> bool {
        self.appearances.take() | any_changed(&self.occluders)
    }
}

impl Occluders {
    /// Number of triangles of an occluder; 0 if the object is no occluder.
    pub fn triangle_count(&self, object: usize) -> usize {
        self.entries[object]
            .as_ref()
            .map_or(0, |entry| entry.mesh.triangles.len())
    }

    /// Whether a triangle of an occluder is within a distance, metres, of a point of world space.
    pub(in crate::sets) fn comes_near(&self, object: usize, point: DVec3, distance: f64) -> bool {
        self.entries[object].as_ref().is_some_and(|entry| {
            let place = |at: u32| {
                let local = entry.mesh.positions[at as usize];
                entry.world_from_local.transform_point3(local.as_dvec3())
            };
            let mut triangles = entry.mesh.triangles.iter();
            triangles.any(|corners| distance_to_triangle(point, corners.map(place)) <= distance)
        })
    }

    /// Mesh, transform to world space, and drawn sides of an occluder.
    pub(super) fn get(&self, object: usize) -> Option<(&OccluderMesh, &DMat4, Sides)> {
        let entry = self.entries[object].as_ref()?;
        Some((&entry.mesh, &entry.world_from_local, entry.drawn_sides))
    }
}

/// Brings [`Occluders`] up to date: all of them if objects, meshes, materials or settings changed, otherwise
/// those that moved.
///
/// Set: `CollectSets`, after `collect_objects`. Cost: the triangles of new occluder meshes, and O(objects)
/// when something came or went. At rest it only compares generations.
pub fn collect_occluders(
    mut occluders: ResMut<Occluders>,
    objects: Res<Objects>,
    settings: Res<OcclusionSettings>,
    face_culling: Option<Res<FaceCulling>>,
    mut parts: OccluderParts,
) {
    let occluders = &mut *occluders;
    let culling = face_culling.map_or_else(FaceCulling::default, |culling| *culling);
    let counts = [parts.occluders.iter().len(), parts.posed.iter().len()];
    let now = Some((objects.flags_generation, *settings, culling, counts));
    if parts.exchanged() || occluders.seen != now {
        occluders.seen = now;
        occluders.rebuild(&objects, &settings, culling, &parts);
        return;
    }
    if occluders.generation == 0 || (objects.moved.is_clear() && occluders.moved.is_clear()) {
        return;
    }
    let Occluders {
        moved,
        known,
        entries,
        ..
    } = occluders;
    moved.clear();
    // Few of many moving objects are occluders, and entries are large, so the loop runs over the
    // intersection.
    for object in objects.moved.intersection(known) {
        if let Some(entry) = &mut entries[object] {
            entry.world_from_local = world_from_local(&parts.transforms, objects.entities[object]);
            moved.insert(object);
        }
    }
}

fn world_from_local(transforms: &Query<&GlobalTransform>, entity: Entity) -> DMat4 {
    transforms
        .get(entity)
        .map_or(DMat4::ZERO, |transform| Mat4::from(transform.affine()).as_dmat4())
}

impl Occluders {
    fn rebuild(
        &mut self,
        objects: &Objects,
        settings: &OcclusionSettings,
        culling: FaceCulling,
        parts: &OccluderParts,
    ) {
        self.generation += 1;
        for set in [
            &mut self.camera,
            &mut self.light,
            &mut self.shadeable,
            &mut self.moved,
            &mut self.known,
        ] {
            resize(set, objects.len());
        }
        self.entries.clear();
        self.entries.resize(objects.len(), None);
        if !settings.from_camera && !settings.from_lights {
            return;
        }
        for (object, &entity) in objects.entities.iter().enumerate() {
            let drawn = objects.drawn.contains(object);
            let Ok((mesh, materials, occluder, left_out, posed)) = parts.objects.get(entity) else {
                continue;
            };
            let blends = materials.is_some_and(|materials| {
                let mut modes = materials.0.iter().map(|material| material.alpha_mode);
                modes.any(|mode| mode == AlphaMode::Blend)
            });
            let shadeable = !drawn || (objects.receivers.contains(object) && !blends);
            self.shadeable.set(object, shadeable);
            let Some(mesh) = mesh else { continue };
            if posed || materials.is_some_and(|materials| !materials.are_opaque(&mesh.0)) {
                continue;
            }
            let bounds = objects.boxes.get(object);
            let source = match occluder {
                Some(Occluder::Never) => None,
                Some(Occluder::Own) => Some(&mesh.0),
                Some(Occluder::Proxy(proxy)) => Some(proxy),
                None => settings
                    .auto
                    .filter(|auto| {
                        mesh.0.triangle_count() <= auto.max_triangles && face_area(&bounds) >= auto.min_area
                    })
                    .map(|_| &mesh.0),
            };
            let Some(mesh) = source.and_then(|source| self.meshes.get_or_build(source)) else {
                continue;
            };
            let all_double = materials.is_some_and(|materials| {
                let mut sides = materials.0.iter().map(|material| material.double_sided);
                sides.all(|double_sided| double_sided)
            });
            self.known.insert(object);
            self.camera.set(object, drawn);
            // The occluder's mesh has all triangles of a mesh of which a part casts.
            let casts_whole = left_out.is_none_or(|left_out| left_out.0.is_empty());
            self.light
                .set(object, casts_whole && objects.casters.contains(object));
            self.entries[object] = Some(Entry {
                mesh,
                world_from_local: world_from_local(&parts.transforms, entity),
                drawn_sides: if all_double || culling == FaceCulling::None {
                    Sides::DRAWN
                } else {
                    Sides::DRAWN_FRONTS
                },
            });
        }
    }
}

/// Area of the largest face of a box, square metres.
fn face_area(bounds: &Aabb) -> f32 {
    if bounds.is_empty() {
        return 0.0;
    }
    let size = bounds.half_size() * 2.0;
    (size.x * size.y).max(size.y * size.z).max(size.z * size.x)
}
