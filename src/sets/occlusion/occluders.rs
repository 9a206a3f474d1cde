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
use crate::scene::changes::{Exchanges, NewAppearances, any_changed};
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
    /// Increases when objects, layers or settings changed, and when an exchanged mesh or material hides otherwise than the one
    /// before. A material of another colour leaves it.
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
    occluders: Query<'w, 's, Ref<'static, Occluder>>,
    posed: Query<'w, 's, (), With<PosedMesh>>,
    transforms: Query<'w, 's, &'static GlobalTransform>,
}

/// The part of one object in occlusion: whether it hides others, and whether others can hide it.
#[derive(Default)]
struct Look {
    camera: bool,
    light: bool,
    shadeable: bool,
    entry: Option<Entry>,
}

/// Everything that decides what objects hide.
struct Sources<'a, 'w, 's> {
    objects: &'a Objects,
    settings: &'a OcclusionSettings,
    culling: FaceCulling,
    parts: &'a OccluderParts<'w, 's>,
}

impl Entry {
    fn is_like(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh)
            && self.world_from_local == other.world_from_local
            && self.drawn_sides == other.drawn_sides
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

/// Brings [`Occluders`] up to date: all of them if objects or settings changed, otherwise those that moved or exchanged
/// their mesh or material.
///
/// Set: `CollectSets`, after `collect_objects`. Cost: the triangles of new occluder meshes, and O(objects)
/// when something came or went or an [`Occluder`] changed. At rest it only compares generations.
pub fn collect_occluders(
    mut occluders: ResMut<Occluders>,
    objects: Res<Objects>,
    settings: Res<OcclusionSettings>,
    face_culling: Option<Res<FaceCulling>>,
    parts: OccluderParts,
    mut appearances: NewAppearances,
) {
    let occluders = &mut *occluders;
    let culling = face_culling.map_or_else(FaceCulling::default, |culling| *culling);
    let counts = [parts.occluders.iter().len(), parts.posed.iter().len()];
    let now = Some((objects.flags_generation, *settings, culling, counts));
    let exchanges = appearances.take();
    let proxies_changed = any_changed(&parts.occluders);
    let sources = Sources {
        objects: &objects,
        settings: &settings,
        culling,
        parts: &parts,
    };
    if occluders.seen != now {
        occluders.seen = now;
        occluders.rebuild(&sources);
        return;
    }
    if !objects.moved.is_clear() || !occluders.moved.is_clear() {
        occluders.follow_motion(&sources);
    }
    let differs = match exchanges {
        Exchanges::Of(entities) if !proxies_changed => {
            let known = entities.iter().filter_map(|&entity| objects.index_of(entity));
            occluders.look_again(known, &sources)
        }
        _ => occluders.look_again(0..objects.len(), &sources),
    };
    occluders.generation += u64::from(differs);
}

impl Occluders {
    fn rebuild(&mut self, sources: &Sources) {
        self.generation += 1;
        let len = sources.objects.len();
        for set in [
            &mut self.camera,
            &mut self.light,
            &mut self.shadeable,
            &mut self.moved,
            &mut self.known,
        ] {
            resize(set, len);
        }
        self.entries.clear();
        self.entries.resize(len, None);
        self.look_again(0..len, sources);
    }

    fn follow_motion(&mut self, sources: &Sources) {
        let Self {
            moved,
            known,
            entries,
            ..
        } = self;
        moved.clear();
        // Few of many moving objects are occluders, and entries are large, so the loop runs over the
        // intersection.
        for object in sources.objects.moved.intersection(known) {
            if let Some(entry) = &mut entries[object] {
                entry.world_from_local = sources.world_from_local(object);
                moved.insert(object);
            }
        }
    }

    /// Looks at objects whose appearance may be new. Returns whether one of them hides otherwise than before.
    fn look_again(&mut self, objects: impl Iterator<Item = usize>, sources: &Sources) -> bool {
        if !sources.settings.from_camera && !sources.settings.from_lights {
            return false; // nothing hides, and nothing did
        }
        let mut differs = false;
        for object in objects {
            let look = sources.look_at(object, &mut self.meshes);
            for (set, is_in) in [
                (&mut self.camera, look.camera),
                (&mut self.light, look.light),
                (&mut self.shadeable, look.shadeable),
            ] {
                differs |= set.contains(object) != is_in;
                set.set(object, is_in);
            }
            differs |= match (&self.entries[object], &look.entry) {
                (Some(old), Some(new)) => !old.is_like(new),
                (old, new) => old.is_some() != new.is_some(),
            };
            self.known.set(object, look.entry.is_some());
            self.entries[object] = look.entry;
        }
        differs
    }
}

impl Sources<'_, '_, '_> {
    fn look_at(&self, object: usize, meshes: &mut OccluderMeshes) -> Look {
        let (objects, settings) = (self.objects, self.settings);
        let drawn = objects.drawn.contains(object);
        let mut look = Look::default();
        let Ok((mesh, materials, occluder, left_out, posed)) =
            self.parts.objects.get(objects.entities[object])
        else {
            return look;
        };
        let blends = materials.is_some_and(|materials| {
            let mut modes = materials.0.iter().map(|material| material.alpha_mode);
            modes.any(|mode| mode == AlphaMode::Blend)
        });
        look.shadeable = !drawn || (objects.receivers.contains(object) && !blends);
        let Some(mesh) = mesh else { return look };
        if posed || materials.is_some_and(|materials| !materials.are_opaque(&mesh.0)) {
            return look;
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
        let Some(mesh) = source.and_then(|source| meshes.get_or_build(source)) else {
            return look;
        };
        let all_double = materials.is_some_and(|materials| {
            let mut sides = materials.0.iter().map(|material| material.double_sided);
            sides.all(|double_sided| double_sided)
        });
        look.camera = drawn;
        // The occluder's mesh has all triangles of a mesh of which a part casts.
        let casts_whole = left_out.is_none_or(|left_out| left_out.0.is_empty());
        look.light = casts_whole && objects.casters.contains(object);
        look.entry = Some(Entry {
            mesh,
            world_from_local: self.world_from_local(object),
            drawn_sides: if all_double || self.culling == FaceCulling::None {
                Sides::DRAWN
            } else {
                Sides::DRAWN_FRONTS
            },
        });
        look
    }

    fn world_from_local(&self, object: usize) -> DMat4 {
        let transform = self.parts.transforms.get(self.objects.entities[object]);
        transform.map_or(DMat4::ZERO, |transform| Mat4::from(transform.affine()).as_dmat4())
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
