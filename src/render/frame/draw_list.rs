//! Sorted and batched draws of surfaces. Equal meshes with equal materials become one instanced draw.

use std::ops::Range;

use fixedbitset::FixedBitSet;

use crate::render::pools::objects::{NO_MESH, ObjectTable};
use crate::sets::Objects;

/// The properties that distinguish the pipelines of one surface pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variant {
    /// True if view and object together mirror, so that front faces wind clockwise.
    pub mirrored: bool,
    /// True if back faces are culled.
    pub culled: bool,
    /// True if the surface shows no shadows, because the object is no receiver or the light has no technique.
    pub unshadowed: bool,
    /// True if the light or the object has weights, or the light's shadows have a colour. Only passes that add
    /// lights tell such surfaces apart.
    pub modelled: bool,
    /// True if the surface has a clearcoat. Only passes that shade tell such surfaces apart; the others pay nothing for
    /// the coat.
    pub coated: bool,
}

impl Variant {
    /// The index of the variant, from 0 and below `VARIANT_COUNT`.
    pub fn index(self) -> usize {
        usize::from(self.mirrored)
            | usize::from(self.culled) << 1
            | usize::from(self.unshadowed) << 2
            | usize::from(self.modelled) << 3
            | usize::from(self.coated) << 4
    }
}

/// The number of [`Variant`]s.
pub const VARIANT_COUNT: usize = 32;

/// One draw call, for one submesh with one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Batch {
    /// The variant that chooses the pipeline.
    pub variant: Variant,
    /// The index of the material in the material pool.
    pub material: u32,
    /// The index of the mesh in the mesh pool.
    pub mesh: u32,
    /// The index of the submesh among those of its mesh.
    pub submesh: u32,
    /// The range of the frame's instances that the call draws. Each instance is the dense index of an object.
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

/// Turns sets of objects into batches, and reuses its memory.
#[derive(Debug, Default)]
pub struct DrawListBuilder {
    draws: Vec<Draw>,
}

/// The items of objects that a list takes. An item is one submesh with its material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemFilter {
    /// The list takes all items that write depth.
    Opaque,
    /// The list takes all items that write depth and take light.
    OpaqueLit,
}

/// Decides whether the surfaces of a list show the shadows of the light that they are drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// Surfaces of receivers show shadows, if their layers share a bit with the mask.
    OnReceivers(u32),
    /// No surface shows shadows: the light has no technique, or the list is for no light.
    Nowhere,
}

impl Shadows {
    /// Returns whether an object shows the shadows.
    pub fn shown_on(self, objects: &Objects, object: usize) -> bool {
        match self {
            Self::OnReceivers(mask) => {
                objects.receivers.contains(object) && objects.layers[object] & mask != 0
            }
            Self::Nowhere => false,
        }
    }
}

/// The input from which a list is built, apart from its set of objects.
#[derive(Clone, Copy, Debug)]
pub struct DrawListInput<'a> {
    /// The meshes and materials of the objects.
    pub table: &'a ObjectTable,
    /// The objects of the frame: which of them show shadows, and on which layers they are.
    pub objects: &'a Objects,
    /// True if the view mirrors.
    pub mirrored_view: bool,
    /// True if single-sided materials are culled. If false, all surfaces are drawn from both sides.
    pub cull_back_faces: bool,
}

impl DrawListBuilder {
    /// Appends the batches of `set` to `batches` and their objects to `instances`. Returns the range of the
    /// new batches. `modelled` says whether the light that they are drawn for has weights or a shadow's colour.
    pub fn build(
        &mut self,
        input: &DrawListInput,
        set: &FixedBitSet,
        filter: ItemFilter,
        (shadows, modelled): (Shadows, bool),
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
                        unshadowed: !shadows.shown_on(input.objects, object),
                        modelled: modelled || input.table.weighted.contains(object),
                        coated: item.coated,
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
