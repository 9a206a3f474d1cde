//! Meshes that a node places many times (`EXT_mesh_gpu_instancing`).

use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, Vec3};
use gltf::json::Value;
use gltf::json::scene::Node;

use super::accessors::Accessors;
use super::extensions::{INSTANCING, whole_number};
use super::transforms::unit_rotation;
use super::{Element, GltfError, Report, SkipKind};
use crate::scene::placement::placed;

/// Memory that is counted for each instance, bytes. Each becomes an entity with all that an object has.
const INSTANCE_BYTES: usize = 512;

/// The transforms of a node's instances relative to the node. `None` if the node draws its mesh once.
///
/// # Errors
/// An attribute that is no accessor of the right type, or attributes of different lengths.
pub(super) fn load(
    accessors: &Accessors<'_>,
    element: Element,
    node: &Node,
    report: &mut Report,
) -> Result<Option<Vec<Transform>>, GltfError> {
    let others = node.extensions.as_ref().map(|extensions| &extensions.others);
    let Some(object) = others.and_then(|others| others.get(INSTANCING)) else {
        return Ok(None);
    };
    if node.mesh.is_none() {
        return Ok(None);
    }
    let attribute = |name: &str| -> Result<Option<usize>, GltfError> {
        let Some(value) = object
            .get("attributes")
            .and_then(|attributes| attributes.get(name))
        else {
            return Ok(None);
        };
        let index = whole_number(Some(value)).filter(|&index| index < accessors.root.accessors.len());
        index.map(Some).ok_or_else(|| {
            let reason = format!("{INSTANCING}: {name} is {value}, which is no accessor");
            accessors.invalid(element, reason)
        })
    };
    let names = ["TRANSLATION", "ROTATION", "SCALE"];
    let [translation, rotation, scale] = [attribute(names[0])?, attribute(names[1])?, attribute(names[2])?];
    let counts = [translation, rotation, scale].map(|accessor| accessor.map(|index| accessors.count(index)));
    let Some(count) = counts.into_iter().flatten().next() else {
        // Attributes of other applications, or none that can be read, tell how many instances there are.
        let others = object.get("attributes").and_then(Value::as_object);
        if others.is_none_or(|others| !others.is_empty()) {
            let reason = format!("{INSTANCING} has no transforms, the mesh is drawn once");
            report.add(SkipKind::Instance, element, 1, reason);
        }
        return Ok(None);
    };
    if let Some(at) = counts
        .iter()
        .position(|other| other.is_some_and(|other| other != count))
    {
        let reason = format!(
            "{INSTANCING}: {} has {} elements, another attribute has {count}",
            names[at],
            counts[at].unwrap_or(0)
        );
        return Err(accessors.invalid(element, reason));
    }
    accessors.charge(element, count, INSTANCE_BYTES)?;
    let vectors = |accessor: Option<usize>, default: Vec3| match accessor {
        Some(accessor) => Ok(accessors
            .read_f32::<3>(accessor, element)?
            .into_iter()
            .map(Vec3::from)
            .collect()),
        None => Ok(vec![default; count]),
    };
    let (translations, scales): (Vec<Vec3>, Vec<Vec3>) =
        (vectors(translation, Vec3::ZERO)?, vectors(scale, Vec3::ONE)?);
    let rotations = match rotation {
        Some(accessor) => accessors.read_f32::<4>(accessor, element)?,
        None => vec![Quat::IDENTITY.to_array(); count],
    };
    let transforms = translations.into_iter().zip(rotations).zip(scales);
    let transforms: Vec<Transform> = transforms
        .map(|((translation, rotation), scale)| Transform {
            translation,
            rotation: unit_rotation(Quat::from_array(rotation)).unwrap_or(Quat::IDENTITY),
            scale,
        })
        .collect();
    let is_nowhere = |transform: &&Transform| placed(&GlobalTransform::from(**transform), false).is_none();
    let nowhere = transforms.iter().filter(is_nowhere).count();
    if nowhere > 0 {
        let reason = "its transform is singular or not finite";
        report.add(SkipKind::Instance, element, nowhere, reason);
    }
    Ok(Some(transforms))
}
