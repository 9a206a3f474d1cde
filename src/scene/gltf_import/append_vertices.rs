//! Appends the vertices of a primitive to the streams of its mesh.

use glam::{Vec2, Vec3, Vec4};

use super::accessors::Accessors;
use super::vertices::Vertices;
use super::{Element, GltfError};
use crate::scene::MeshData;
use crate::scene::mesh::MorphTarget;

/// Appends streams to those of the mesh. Where only one side has a stream, default values fill the other
/// side. Returns the index of the first new vertex.
pub(super) fn append(
    accessors: &Accessors<'_>,
    element: Element,
    data: &mut MeshData,
    new: Vertices,
) -> Result<usize, GltfError> {
    let base = data.positions.len();
    let end = base + new.positions.len();
    if end > u32::MAX as usize {
        return Err(accessors.invalid(element, "the mesh has more than 2³² vertices"));
    }
    let join = Join {
        accessors,
        element,
        base,
        end,
    };
    join.stream(&mut data.positions, Some(new.positions), Vec3::ZERO)?;
    join.stream(&mut data.normals, new.normals, Vec3::Y)?;
    join.stream(&mut data.tangents, new.tangents, Vec4::X)?;
    let [uv0, uv1] = new.uv;
    join.stream(&mut data.uv0, uv0, Vec2::ZERO)?;
    join.stream(&mut data.uv1, uv1, Vec2::ZERO)?;
    join.stream(&mut data.colors, new.colors, Vec4::ONE)?;
    let (joints, weights) = new.skin.unzip();
    join.stream(&mut data.joints, joints, [0; 4])?;
    join.stream(&mut data.joint_weights, weights, Vec4::X)?;

    let mut targets = new.targets;
    let target_count = targets.len().max(data.morph_targets.len());
    targets.resize_with(target_count, MorphTarget::default);
    data.morph_targets.resize_with(target_count, MorphTarget::default);
    for (target, new) in data.morph_targets.iter_mut().zip(targets) {
        let present = |stream: Vec<Vec3>| Some(stream).filter(|stream| !stream.is_empty());
        join.stream(&mut target.positions, present(new.positions), Vec3::ZERO)?;
        join.stream(&mut target.normals, present(new.normals), Vec3::ZERO)?;
        join.stream(&mut target.tangents, present(new.tangents), Vec3::ZERO)?;
    }
    Ok(base)
}

struct Join<'j, 'a> {
    accessors: &'j Accessors<'a>,
    element: Element,
    base: usize,
    end: usize,
}

impl Join<'_, '_> {
    fn stream<T: Clone>(&self, stream: &mut Vec<T>, new: Option<Vec<T>>, fill: T) -> Result<(), GltfError> {
        if new.is_none() && stream.is_empty() {
            return Ok(());
        }
        self.accessors
            .charge(self.element, self.end - stream.len(), size_of::<T>())?;
        stream.resize(self.base, fill.clone());
        stream.extend(new.into_iter().flatten());
        stream.resize(self.end, fill);
        Ok(())
    }
}
