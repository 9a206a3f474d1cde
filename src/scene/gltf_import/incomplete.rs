//! Reports primitives that are drawn, but not as their author meant: without area, without the texture coordinates of
//! their material, or without the joints of their mesh.

use glam::{DVec3, Vec3};
use gltf::json::mesh::{Primitive, Semantic};

use super::vertices::attribute;
use super::{Element, Report, SkipKind};
use crate::scene::Material;

/// Whether the triangles of a primitive all lack area, as if its accessors have no data. Skins and morph targets may give
/// them one.
pub(super) fn lacks_area(primitive: &Primitive, positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let may_change = primitive.targets.is_some() || attribute(primitive, Semantic::Joints(0)).is_some();
    let is_flat = |corners: &[u32; 3]| {
        // Products of `f64` neither overflow nor vanish for any `f32`.
        let [a, b, c] = corners.map(|corner| positions[corner as usize].as_dvec3());
        (b - a).cross(c - a) == DVec3::ZERO
    };
    !may_change && triangles.iter().all(is_flat)
}

/// Reports the textures of a material for which a primitive has no texture coordinates.
pub(super) fn report_coordinates(
    element: Element,
    primitive: &Primitive,
    material: &Material,
    report: &mut Report,
) {
    let slots = [
        &material.base_color_texture,
        &material.metallic_roughness_texture,
        &material.normal_texture,
        &material.occlusion_texture,
        &material.emissive_texture,
        &material.clearcoat_texture,
        &material.clearcoat_roughness_texture,
    ];
    for set in [0, 1] {
        let used = slots
            .iter()
            .filter(|slot| slot.as_ref().is_some_and(|slot| slot.uv_set == set));
        let count = used.count();
        if count > 0 && attribute(primitive, Semantic::TexCoords(set)).is_none() {
            let reason =
                format!("it has no TEXCOORD_{set} for its material, the texel at (0, 0) is everywhere");
            report.add(SkipKind::Texture, element, count, reason);
        }
    }
}

/// Reports the primitives without joints in a mesh of which others have some. Each is given with its number of vertices.
pub(super) fn report_unbound(loaded: &[(Element, usize, bool)], report: &mut Report) {
    if !loaded.iter().any(|&(_, _, has_joints)| has_joints) {
        return;
    }
    for &(element, vertex_count, _) in loaded.iter().filter(|(_, _, has_joints)| !has_joints) {
        let reason = "it has no JOINTS_0 though its mesh is skinned, it follows the first joint";
        report.add(SkipKind::VertexData, element, vertex_count, reason);
    }
}
