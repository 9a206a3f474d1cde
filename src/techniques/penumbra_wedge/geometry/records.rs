//! The GPU's records of wedges, and how the record of an edge is made. They mirror the structs of the same
//! names in `shaders/techniques/penumbra_wedge/wedge.wgsl` and `shaders/common/wedge_light.wgsl`
//! (`tests/gpu/layout_contract.rs`).

use glam::{DMat4, DVec3, Vec3, Vec4};

use super::clip::{clip_before_plane, clip_outside_sphere};
use super::shell::{Half, RIM, Shell, quad_shell, sphere_shell};
use super::sight::Sight;
use super::silhouette_layers::{LayeredEdge, Side};
use crate::techniques::penumbra_wedge::component::WedgeBounds;
use crate::techniques::penumbra_wedge::light_parts::PartShape;

/// One edge, or one piece of an edge that the light cuts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Wedge {
    /// Start of the edge, in the caster's space.
    pub start_local: [f32; 3],
    /// Index of the [`WedgeCaster`].
    pub caster: u32,
    /// End of the edge, in the caster's space.
    pub end_local: [f32; 3],
    /// Bits: [`HARD`], [`PIECE`], [`SOFT`], layers of the hard shadow from [`LAYERS_SHIFT`] on, layers of the
    /// penumbra from [`SOFT_LAYERS_SHIFT`] on, [`ONLY_OUTER`], [`ONLY_INNER`], [`CLOSED`] and [`CUT`].
    pub flags: u32,
    /// Start of the edge or piece, in light space.
    pub start_light: [f32; 3],
    /// Unused.
    pub padding_a: u32,
    /// End of the edge or piece, in light space.
    pub end_light: [f32; 3],
    /// Unused.
    pub padding_b: u32,
    /// Rims of the outer and inner half: xyz is a direction in light space; w is 0 where the ray leaves from
    /// the start of the edge, 1 from its end. All zero without a shell. Of a [`CUT`], the first two are the third and the fourth corner.
    pub rims: [[f32; 4]; 2 * RIM],
    /// Planes of the triangles beside the edge, in light space: `dot(xyz, p) + w` is negative where `p` sees
    /// the light through the triangle's front. See [`side_plane`]. Of a [`CUT`], the first is the plane of its patch, and the
    /// second begins with the greatest distance of the surface from that plane, metres.
    pub sides: [[f32; 4]; 2],
}

/// Metres from a plane, farther than any receiver.
const FAR: f32 = 1e30;

/// Returns the plane that represents what is beside an edge; `plane` returns that of a turning triangle.
pub fn side_plane(side: Side, plane: impl Fn(u32) -> [f32; 4]) -> [f32; 4] {
    match side {
        Side::Turning(slot) => plane(slot),
        Side::Facing => [0.0, 0.0, 0.0, -FAR],
        Side::Averted => [0.0, 0.0, 0.0, FAR],
        Side::Open => [0.0; 4],
    }
}

/// Flag: the edge bounds the hard shadow.
pub const HARD: u32 = 1;

/// Flag: the record is a piece. Its vertices come from light space, because they are not vertices of the
/// caster.
pub const PIECE: u32 = 2;

/// Flag: the edge has a shell.
pub const SOFT: u32 = 4;

/// First bit of the [layers](super::silhouette_layers) whose hard shadow the edge bounds.
pub const LAYERS_SHIFT: u32 = 3;

/// First bit of the [layers](super::silhouette_layers) whose penumbra the edge bounds.
pub const SOFT_LAYERS_SHIFT: u32 = 5;

/// Flag: the whole shell is in the outer half. The rim of the inner half is flat, and there is no separator.
pub const ONLY_OUTER: u32 = 128;

/// Flag: the whole shell is in the inner half. The rim of the outer half is flat, and there is no separator.
pub const ONLY_INNER: u32 = 256;

/// Flag: both layers are the averted triangles of a closed piece.
pub const CLOSED: u32 = 512;

/// Flag: the record is a polygon of four corners that cuts the light. Start and end are two of them.
pub const CUT: u32 = 1024;

/// One caster of one part of a light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct WedgeCaster {
    /// The part's centre in the caster's space; w = 1: a position; w = 0: xyz points towards the light.
    pub light_local: [f32; 4],
    /// The plane where the caster's wedges end, in the caster's space: `dot(xyz, p) = w`.
    pub end_local: [f32; 4],
    /// The plane where the caster's wedges end, in light space: `dot(xyz, p) = w`.
    pub end_light: [f32; 4],
    /// Index into the objects of the frame.
    pub object: u32,
    /// Factor on the distance from the light by which far ends are pushed, in metres for a directional light;
    /// 0: to infinity.
    pub extrusion: f32,
    /// Unused.
    pub padding: [u32; 2],
}

/// One part of a light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct WedgeLight {
    /// Matrix from light space to clip space, by columns. Computed in `f64`.
    pub clip_from_light: [[f32; 4]; 4],
    /// First row of the transform from eye-relative to light space.
    pub light_from_relative_x: [f32; 4],
    /// Second row of the transform from eye-relative to light space.
    pub light_from_relative_y: [f32; 4],
    /// Third row of the transform from eye-relative to light space.
    pub light_from_relative_z: [f32; 4],
    /// Half width and half height of a rectangle; twice the same radius for a sphere.
    pub half_size: [f32; 2],
    /// First entry of the texture's tables; 0 without a texture.
    pub table: u32,
    /// Metres at which the rays of shells end; 0: at infinity.
    pub reach: f32,
    /// Centre and half size of the part within the whole light, which spans −1 to 1.
    pub place: [f32; 4],
    /// xyz: centre of the whole light, in light space; w: radius of a whole sphere.
    pub whole: [f32; 4],
}

/// Share of a rectangle's larger side by which casters must be in front of its plane to cover it.
const PLANE_MARGIN: f64 = 1e-4;

/// Factor on a sphere's radius; casters nearer to its centre do not cover it.
const SPHERE_MARGIN: f64 = 1.005;

/// Appends the records of one edge. There is one record unless the edge meets the light; then one record
/// bounds the hard shadow and others cover the light.
///
/// `ends_local` are those of `edge`, swapped for casters that mirror; `sides` are its [planes](side_plane).
/// An edge that covers nothing keeps a record without a shell if it bounds the hard shadow. Section 4.1:
/// "that edge should be clipped against the light".
pub fn push_edge(
    edge: &LayeredEdge,
    ends_local: [Vec3; 2],
    sides: [[f32; 4]; 2],
    light_from_local: &DMat4,
    shape: PartShape,
    bounds: WedgeBounds,
    wedges: &mut Vec<Wedge>,
) {
    let ends = ends_local.map(|end| light_from_local.transform_point3(end.as_dvec3()));
    let [start, end] = ends_local.map(|end| end.to_array());
    let [start_light, end_light] = ends.map(|end| end.as_vec3().to_array());
    let layers = (edge.layers << LAYERS_SHIFT)
        | (edge.soft_layers << SOFT_LAYERS_SHIFT)
        | (CLOSED * u32::from(edge.is_closed));
    let sight = sight_of(edge, sides);
    let mut whole = Wedge {
        start_local: start,
        end_local: end,
        start_light,
        end_light,
        flags: if edge.layers == 0 { 0 } else { HARD } | layers,
        sides,
        ..Wedge::default()
    };
    if ends[0] == ends[1] {
        return; // bounds nothing
    }
    let pieces = match shape {
        PartShape::Point => [None, None],
        PartShape::Rect { half } => [clip_before_plane(ends, half.max_element() * PLANE_MARGIN), None],
        PartShape::Sphere { radius } => clip_outside_sphere(ends, radius * SPHERE_MARGIN),
    };
    if pieces[0] == Some(ends) {
        whole.flags |= add_shell(ends, shape, bounds, &sight, &mut whole);
        if whole.flags & (HARD | SOFT) != 0 {
            wedges.push(whole);
        }
        return;
    }
    if edge.layers != 0 {
        wedges.push(whole);
    }
    for piece in pieces.into_iter().flatten() {
        let [start_light, end_light] = piece.map(|end| end.as_vec3().to_array());
        let mut record = Wedge {
            start_light,
            end_light,
            flags: PIECE | layers,
            ..whole
        };
        let soft = add_shell(piece, shape, bounds, &sight, &mut record);
        record.flags |= soft;
        if soft != 0 {
            wedges.push(record);
        }
    }
}

/// Returns the sight of an edge with these planes beside it.
fn sight_of(edge: &LayeredEdge, planes: [[f32; 4]; 2]) -> Sight {
    if edge.sides.contains(&Side::Open) {
        return Sight::default(); // in one layer or the other, it is a silhouette edge from everywhere
    }
    let turns = edge.sides.map(|side| matches!(side, Side::Turning(_)));
    let plane = |i: usize| turns[i].then(|| Vec4::from(planes[i]).as_dvec4());
    Sight {
        planes: [plane(0), plane(1)],
        is_beside: edge.layers == 0,
    }
}

fn add_shell(
    ends: [DVec3; 2],
    shape: PartShape,
    bounds: WedgeBounds,
    sight: &Sight,
    wedge: &mut Wedge,
) -> u32 {
    let shell = match (shape, bounds) {
        (PartShape::Point, _) => None,
        (PartShape::Sphere { radius }, _) => sphere_shell(ends, radius, sight),
        (PartShape::Rect { half }, WedgeBounds::Sphere)
            if clip_outside_sphere(ends, half.length() * SPHERE_MARGIN)[0] == Some(ends) =>
        {
            sphere_shell(ends, half.length(), sight)
        }
        (PartShape::Rect { half }, _) => {
            let corner = |x: f64, y: f64| DVec3::new(x * half.x, y * half.y, 0.0);
            quad_shell(
                ends,
                [
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                    corner(-1.0, -1.0),
                    corner(1.0, -1.0),
                ],
                sight,
            )
        }
    };
    match shell {
        Some(shell) if is_finite(&shell) => {
            for (record, point) in wedge.rims.iter_mut().zip(shell.rims.iter().flatten()) {
                // Only the direction matters; its length might not fit into an `f32`.
                let direction = point.direction.normalize().as_vec3();
                *record = direction.extend(point.apex as f32).to_array();
            }
            match shell.only {
                None => SOFT,
                Some(Half::Outer) => SOFT | ONLY_OUTER,
                Some(Half::Inner) => SOFT | ONLY_INNER,
            }
        }
        _ => 0,
    }
}

fn is_finite(shell: &Shell) -> bool {
    let mut points = shell.rims.iter().flatten();
    points.all(|point| point.direction.is_finite() && point.direction.length_squared() > 0.0)
}
