//! Sorted, batched draws of surfaces: equal meshes with equal materials become one instanced draw.

use std::ops::Range;

use fixedbitset::FixedBitSet;

use crate::render::pools::objects::{NO_MESH, ObjectTable};

/// What tells two pipelines of one surface pass apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variant {
    /// View and object together mirror: fronts wind clockwise.
    pub mirrored: bool,
    /// Back faces are left out.
    pub culled: bool,
    /// Shadows are left out (the object is no receiver, or the light has no technique).
    pub unshadowed: bool,
}

impl Variant {
    /// A small dense number.
    pub fn index(self) -> usize {
        usize::from(self.mirrored) | usize::from(self.culled) << 1 | usize::from(self.unshadowed) << 2
    }
}

/// Number of [`Variant`]s.
pub const VARIANT_COUNT: usize = 8;

/// One draw call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Batch {
    /// Chooses the pipeline.
    pub variant: Variant,
    /// Index into the material pool.
    pub material: u32,
    /// Index into the mesh pool.
    pub mesh: u32,
    /// Index into the mesh's submeshes.
    pub submesh: u32,
    /// Range of the frame's instances, each an object's dense index.
    pub instances: Range<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Draw {
    variant: Variant,
    material: u32,
    mesh: u32,
    submesh: u32,
    object: u32,
}

/// Turns sets of objects into batches, reusing its memory.
#[derive(Debug, Default)]
pub struct DrawListBuilder {
    draws: Vec<Draw>,
}

/// Which items of the objects a list takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemFilter {
    /// All that write depth.
    Opaque,
    /// All that write depth and take light.
    OpaqueLit,
}

/// Whether the surfaces of a list show the shadows of the light that they are drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// Those of receivers do.
    OnReceivers,
    /// None does: the light has no technique, or the list is for no light.
    Nowhere,
}

/// What a list is built from beside its set.
#[derive(Clone, Copy, Debug)]
pub struct DrawListInput<'a> {
    /// Meshes and materials.
    pub table: &'a ObjectTable,
    /// Objects that show shadows.
    pub receivers: &'a FixedBitSet,
    /// The view mirrors.
    pub mirrored_view: bool,
    /// Single-sided materials are culled; else all surfaces are drawn from both sides.
    pub cull_back_faces: bool,
}

impl DrawListBuilder {
    /// Appends the batches of `set` to `batches` and their objects to `instances`; the range of the batches.
    pub fn build(
        &mut self,
        input: &DrawListInput,
        set: &FixedBitSet,
        filter: ItemFilter,
        shadows: Shadows,
        batches: &mut Vec<Batch>,
        instances: &mut Vec<u32>,
    ) -> Range<usize> {
        self.draws.clear();
        for object in set.ones() {
            let mesh = input.table.mesh[object];
            let handedness = input.table.handedness[object];
            if mesh == NO_MESH || handedness == 0.0 {
                continue;
            }
            for item in input.table.items_of(object) {
                if item.blended || (filter == ItemFilter::OpaqueLit && item.unlit) {
                    continue;
                }
                self.draws.push(Draw {
                    variant: Variant {
                        mirrored: (handedness < 0.0) != input.mirrored_view,
                        culled: input.cull_back_faces && !item.double_sided,
                        unshadowed: shadows == Shadows::Nowhere || !input.receivers.contains(object),
                    },
                    material: item.material,
                    mesh,
                    submesh: item.submesh,
                    object: object as u32,
                });
            }
        }
        self.draws.sort_unstable();
        let first = batches.len();
        for draw in &self.draws {
            let at = instances.len() as u32;
            instances.push(draw.object);
            if let Some(last) = batches[first..].last_mut()
                && last.instances.end == at
                && (last.variant, last.material, last.mesh, last.submesh)
                    == (draw.variant, draw.material, draw.mesh, draw.submesh)
            {
                last.instances.end = at + 1;
            } else {
                batches.push(Batch {
                    variant: draw.variant,
                    material: draw.material,
                    mesh: draw.mesh,
                    submesh: draw.submesh,
                    instances: at..at + 1,
                });
            }
        }
        first..batches.len()
    }
}
