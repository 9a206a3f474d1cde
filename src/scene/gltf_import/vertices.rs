//! The vertex streams of one primitive. Values that no vertex may have are repaired.

use glam::{Vec2, Vec3, Vec4};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessors::Accessors;
use super::{Element, GltfError, Report, SkipKind};
use crate::scene::mesh::MorphTarget;

/// How far the squared length of a vector may be from 1 before it is normalised again. The tolerance keeps
/// exact input bit for bit. By eye: 8-bit normals are off by more, 32-bit ones by less.
const UNIT_TOLERANCE: f32 = 1e-5;

/// The four joints of each vertex, and their weights.
type Influences = (Vec<[u16; 4]>, Vec<Vec4>);

/// The streams of one primitive. Each has one entry for each vertex.
#[derive(Default)]
pub(super) struct Vertices {
    /// Positions as stored; they may contain values that are not finite.
    pub positions: Vec<Vec3>,
    pub normals: Option<Vec<Vec3>>,
    pub tangents: Option<Vec<Vec4>>,
    pub uv: [Option<Vec<Vec2>>; 2],
    pub colors: Option<Vec<Vec4>>,
    pub skin: Option<Influences>,
    pub targets: Vec<MorphTarget>,
}

/// Index of the accessor of an attribute.
pub(super) fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive
        .attributes
        .get(&Checked::Valid(semantic))
        .map(|accessor| accessor.value())
}

struct Reader<'r, 'a> {
    accessors: &'r Accessors<'a>,
    element: Element,
    primitive: &'r Primitive,
    vertex_count: usize,
    report: &'r mut Report,
}

/// Reads all streams that a mesh can hold.
///
/// # Errors
/// A stream whose accessor is broken, has the wrong type, or has another length than the positions.
pub(super) fn read(
    accessors: &Accessors<'_>,
    element: Element,
    primitive: &Primitive,
    position_accessor: usize,
    report: &mut Report,
) -> Result<Vertices, GltfError> {
    let positions: Vec<Vec3> = accessors
        .read_f32::<3>(position_accessor, element)?
        .into_iter()
        .map(Vec3::from)
        .collect();
    let mut reader = Reader {
        accessors,
        element,
        primitive,
        vertex_count: positions.len(),
        report,
    };
    let normals = reader.normals()?;
    Ok(Vertices {
        positions,
        // Tangents without normals have no meaning (glTF 2.0 §3.7.2.1).
        tangents: if normals.is_some() {
            reader.tangents()?
        } else {
            None
        },
        normals,
        uv: [reader.texture_coordinates(0)?, reader.texture_coordinates(1)?],
        colors: reader.colors()?,
        skin: reader.skin()?,
        targets: reader.targets()?,
    })
}

impl Reader<'_, '_> {
    fn stream<const N: usize>(&self, accessor: usize, name: &str) -> Result<Vec<[f32; N]>, GltfError> {
        self.check_length(accessor, name)?;
        self.accessors.read_f32(accessor, self.element)
    }

    fn check_length(&self, accessor: usize, name: &str) -> Result<(), GltfError> {
        let (count, vertex_count) = (self.accessors.count(accessor), self.vertex_count);
        // If the accessor does not exist, the read that follows reports it.
        if accessor < self.accessors.root.accessors.len() && count != vertex_count {
            let reason = format!(
                "{name} of {} has {count} elements, POSITION has {vertex_count}",
                self.element
            );
            return Err(self.accessors.invalid(Element::Accessor(accessor), reason));
        }
        Ok(())
    }

    fn repaired(&mut self, count: usize, reason: &str) {
        if count > 0 {
            self.report.add(SkipKind::VertexData, self.element, count, reason);
        }
    }

    fn normals(&mut self) -> Result<Option<Vec<Vec3>>, GltfError> {
        let Some(accessor) = attribute(self.primitive, Semantic::Normals) else {
            return Ok(None);
        };
        let mut without = 0;
        let normals = self.stream::<3>(accessor, "NORMAL")?.into_iter().map(|normal| {
            unit(Vec3::from(normal)).unwrap_or_else(|| {
                without += 1;
                Vec3::Y
            })
        });
        let normals = normals.collect();
        self.repaired(without, "a normal has no direction, +Y is used");
        Ok(Some(normals))
    }

    fn tangents(&mut self) -> Result<Option<Vec<Vec4>>, GltfError> {
        let Some(accessor) = attribute(self.primitive, Semantic::Tangents) else {
            return Ok(None);
        };
        let tangents = self
            .stream::<4>(accessor, "TANGENT")?
            .into_iter()
            .map(|[x, y, z, w]| {
                let sign = if w > 0.0 {
                    1.0
                } else if w < 0.0 {
                    -1.0
                } else {
                    0.0
                };
                unit(Vec3::new(x, y, z)).map_or(Vec4::X, |tangent| tangent.extend(sign))
            });
        Ok(Some(tangents.collect()))
    }

    fn texture_coordinates(&mut self, set: u32) -> Result<Option<Vec<Vec2>>, GltfError> {
        let Some(accessor) = attribute(self.primitive, Semantic::TexCoords(set)) else {
            return Ok(None);
        };
        let mut repaired = 0;
        let uv = self
            .stream::<2>(accessor, "TEXCOORD")?
            .into_iter()
            .map(Vec2::from);
        let uv = uv
            .map(|uv| finite_or(uv.is_finite(), uv, Vec2::ZERO, &mut repaired))
            .collect();
        self.repaired(repaired, "texture coordinates are not finite, 0 is used");
        Ok(Some(uv))
    }

    fn colors(&mut self) -> Result<Option<Vec<Vec4>>, GltfError> {
        let Some(accessor) = attribute(self.primitive, Semantic::Colors(0)) else {
            return Ok(None);
        };
        let colors: Vec<Vec4> = if self.accessors.is_vec4(accessor) {
            self.stream::<4>(accessor, "COLOR_0")?
                .into_iter()
                .map(Vec4::from)
                .collect()
        } else {
            let rgb = self.stream::<3>(accessor, "COLOR_0")?;
            rgb.into_iter().map(|rgb| Vec3::from(rgb).extend(1.0)).collect()
        };
        let mut repaired = 0;
        let colors = colors
            .into_iter()
            .map(|color| finite_or(color.is_finite(), color.max(Vec4::ZERO), Vec4::ONE, &mut repaired))
            .collect();
        self.repaired(repaired, "a colour is not finite, white is used");
        Ok(Some(colors))
    }

    /// The influences of each vertex in ascending order of joints, with weights of sum 1. If there are more
    /// than four, the four strongest are used. The fixed order makes the two sides of a seam pose to the same
    /// bits.
    fn skin(&mut self) -> Result<Option<Influences>, GltfError> {
        let mut sets = Vec::new();
        while let (set, Some(joints)) = (
            sets.len() as u32,
            attribute(self.primitive, Semantic::Joints(sets.len() as u32)),
        ) {
            let Some(weights) = attribute(self.primitive, Semantic::Weights(set)) else {
                let reason = format!("it has JOINTS_{set} and no WEIGHTS_{set}");
                return Err(self.accessors.invalid(self.element, reason));
            };
            self.check_length(joints, "JOINTS")?;
            let joints_of_set = self.accessors.read_u32::<4>(joints, self.element)?;
            if let Some(joint) = joints_of_set
                .iter()
                .flatten()
                .find(|&&joint| joint > u32::from(u16::MAX))
            {
                let reason = format!("joint index {joint} exceeds 65535");
                return Err(self.accessors.invalid(Element::Accessor(joints), reason));
            }
            sets.push((joints_of_set, self.stream::<4>(weights, "WEIGHTS")?));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let (mut unbound, mut overfull) = (0, 0);
        let mut influences: Vec<(u16, f32)> = Vec::new();
        let mut joints = Vec::with_capacity(self.vertex_count);
        let mut weights = Vec::with_capacity(self.vertex_count);
        for vertex in 0..self.vertex_count {
            influences.clear();
            for (joints, weights) in &sets {
                let pairs = joints[vertex].into_iter().zip(weights[vertex]);
                influences.extend(
                    pairs
                        .filter(|&(_, weight)| weight > 0.0 && weight.is_finite())
                        .map(|(joint, weight)| (joint as u16, weight)),
                );
            }
            influences.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            overfull += usize::from(influences.len() > 4);
            influences.truncate(4);
            let sum: f32 = influences.iter().map(|&(_, weight)| weight).sum();
            if influences.is_empty() || !sum.is_finite() {
                unbound += 1;
                influences.clear();
                influences.push((0, 1.0));
            } else if sum != 1.0 {
                influences.iter_mut().for_each(|(_, weight)| *weight /= sum);
            }
            influences.sort_by_key(|&(joint, _)| joint);
            let mut joint_of = [0; 4];
            let mut weight_of = [0.0; 4];
            for (slot, &(joint, weight)) in influences.iter().enumerate() {
                joint_of[slot] = joint;
                weight_of[slot] = weight;
            }
            joints.push(joint_of);
            weights.push(Vec4::from(weight_of));
        }
        self.repaired(
            unbound,
            "a vertex has no joint weight, it follows the first joint",
        );
        self.repaired(
            overfull,
            "a vertex has more than four joints, the four strongest are used",
        );
        Ok(Some((joints, weights)))
    }

    fn targets(&mut self) -> Result<Vec<MorphTarget>, GltfError> {
        let mut repaired = 0;
        let mut targets = Vec::new();
        for target in self.primitive.targets.iter().flatten() {
            let mut deltas = |accessor: Option<usize>, name: &str| -> Result<Vec<Vec3>, GltfError> {
                let Some(accessor) = accessor else {
                    return Ok(Vec::new());
                };
                let deltas = self.stream::<3>(accessor, name)?.into_iter().map(Vec3::from);
                Ok(deltas
                    .map(|delta| finite_or(delta.is_finite(), delta, Vec3::ZERO, &mut repaired))
                    .collect())
            };
            targets.push(MorphTarget {
                positions: deltas(
                    target.positions.map(|accessor| accessor.value()),
                    "target POSITION",
                )?,
                normals: deltas(target.normals.map(|accessor| accessor.value()), "target NORMAL")?,
                tangents: deltas(target.tangents.map(|accessor| accessor.value()), "target TANGENT")?,
            });
        }
        self.repaired(repaired, "a morph target is not finite, 0 is used");
        Ok(targets)
    }
}

fn finite_or<T>(is_finite: bool, value: T, default: T, repaired: &mut usize) -> T {
    *repaired += usize::from(!is_finite);
    if is_finite { value } else { default }
}

fn unit(vector: Vec3) -> Option<Vec3> {
    if (vector.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        return Some(vector);
    }
    vector.try_normalize()
}
