//! What the GPU reads of wedges, and how the record of an edge is made. Mirrors of the structs of the same names in
//! `shaders/techniques/penumbra_wedge/wedge.wgsl` and `shaders/common/wedge_light.wgsl` (`tests/layout_contract.rs`).

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
    /// Start of the edge, the caster's space.
    pub start_local: [f32; 3],
    /// Index of the [`WedgeCaster`].
    pub caster: u32,
    /// End of the edge, the caster's space.
    pub end_local: [f32; 3],
    /// [`HARD`], [`PIECE`], [`SOFT`], layers of the hard shadow from [`LAYERS_SHIFT`] on, of the penumbra from
    /// [`SOFT_LAYERS_SHIFT`] on, [`ONLY_OUTER`], [`ONLY_INNER`] and [`CLOSED`].
    pub flags: u32,
    /// Start of the edge or piece, light space.
    pub start_light: [f32; 3],
    /// Unused.
    pub padding_a: u32,
    /// End of the edge or piece, light space.
    pub end_light: [f32; 3],
    /// Unused.
    pub padding_b: u32,
    /// Rims of the outer and inner half: direction in light space; w: 0 where the ray leaves from the start, 1 from the
    /// end. Zero without a shell.
    pub rims: [[f32; 4]; 2 * RIM],
    /// Planes of the triangles beside the edge, light space: `dot(xyz, p) + w`, less than 0 where `p` sees the light
    /// through the triangle's front. See [`side_plane`].
    pub sides: [[f32; 4]; 2],
}

/// Farther than any receiver lies from a plane, metres.
const FAR: f32 = 1e30;

/// The plane of what lies beside an edge; `plane` gives that of a turning triangle.
pub fn side_plane(side: Side, plane: impl Fn(u32) -> [f32; 4]) -> [f32; 4] {
    match side {
        Side::Turning(slot) => plane(slot),
        Side::Facing => [0.0, 0.0, 0.0, -FAR],
        Side::Averted => [0.0, 0.0, 0.0, FAR],
        Side::Open => [0.0; 4],
    }
}

/// The edge bounds the hard shadow.
pub const HARD: u32 = 1;

/// A piece: its vertices come from light space, for they are no vertices of the caster.
pub const PIECE: u32 = 2;

/// The edge has a shell.
pub const SOFT: u32 = 4;

/// Where the [layers](super::silhouette_layers) whose hard shadow the edge bounds stand in the flags.
pub const LAYERS_SHIFT: u32 = 3;

/// Where the layers whose penumbra it bounds stand.
pub const SOFT_LAYERS_SHIFT: u32 = 5;

/// All of the shell is in the outer half: the rim of the inner one is flat, and there is no separator.
pub const ONLY_OUTER: u32 = 128;

/// The same in the inner half.
pub const ONLY_INNER: u32 = 256;

/// Both layers are what is averted of a closed piece.
pub const CLOSED: u32 = 512;

/// One caster of one part of a light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct WedgeCaster {
    /// The part's centre, the caster's space; w = 1: a position; w = 0: xyz points towards the light.
    pub light_local: [f32; 4],
    /// The [plane](super::ends) where its wedges end, the caster's space: `dot(xyz, p) = w`.
    pub end_local: [f32; 4],
    /// The same, light space.
    pub end_light: [f32; 4],
    /// Index into the objects of the frame.
    pub object: u32,
    /// Factor on the distance from the light, of a directional one metres, by which far ends are pushed; 0: to infinity.
    pub extrusion: f32,
    /// Unused.
    pub padding: [u32; 2],
}

/// One part of a light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct WedgeLight {
    /// Columns; from light space to clip space. Computed in f64.
    pub clip_from_light: [[f32; 4]; 4],
    /// First row of the map from eye-relative to light space.
    pub light_from_relative_x: [f32; 4],
    /// Second row.
    pub light_from_relative_y: [f32; 4],
    /// Third row.
    pub light_from_relative_z: [f32; 4],
    /// Half width and height of a rectangle, or the radius of a sphere twice.
    pub half_size: [f32; 2],
    /// First entry of the texture's tables; 0 without a texture.
    pub table: u32,
    /// Metres at which rays of shells end; 0: at infinity.
    pub reach: f32,
    /// Centre and half size within the whole light, −1 to 1.
    pub place: [f32; 4],
    /// Centre of the whole light, light space; w: of a sphere, its radius.
    pub whole: [f32; 4],
}

/// Share of a rectangle's larger side by which casters must stand before its plane to cover it.
const PLANE_MARGIN: f64 = 1e-4;

/// Factor on a sphere's radius within which casters do not cover it.
const SPHERE_MARGIN: f64 = 1.005;

/// Appends the records of one edge: one, or if it meets the light, one that bounds the hard shadow and others that
/// cover the light.
///
/// `ends_local` are those of `edge`, turned round for casters that mirror; `sides` are its [planes](side_plane). Edges
/// that cover nothing keep their record without a shell if they bound the hard shadow. Section 4.1: "that edge should be
/// clipped against the light".
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

/// Of an edge with these planes beside it.
fn sight_of(edge: &LayeredEdge, planes: [[f32; 4]; 2]) -> Sight {
    if edge.sides.contains(&Side::Open) {
        return Sight::default(); // in one layer or the other, it is of the silhouette from everywhere
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
                // Only the direction counts; its length might not fit.
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
