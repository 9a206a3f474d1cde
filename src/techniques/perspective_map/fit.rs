//! The faces of a light in this frame.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::component::{MapFocus, PerspectiveFaces};
use super::cube;
use super::fit_input::FitInput;
use super::light_camera::{self, Rows};
use super::place_face::place_face;
use super::projection::Projection;
use super::texels::{Sample, collect_samples, mean_texel_side};
use super::view_space::ViewSpace;
use crate::techniques::maps::request::MapFaces;

/// Ratio between the slides that are tried.
const SLIDE_STEP: f64 = 4.0;

/// Largest ratio of w between far and near receivers. Beyond, the rounding of large casters' corners shows near the eye.
const MOST_RATIO: f64 = 256.0;

/// Growth of w over the visible depth below which a perspective looks like none.
const FLAT: f64 = 0.1;

/// Share of a uniform map's texel side from which on one picture gains so little that the cube's faces are tried. By eye.
const POOR: f64 = 0.6;

/// Share of a uniform map's texel side below which one picture takes over again from the cube's faces. The distance from
/// [`POOR`] keeps a turning view from replacing textures in every other frame.
const GOOD: f64 = 0.5;

/// Pictures of one projection, and how they compare.
struct Choice {
    growth: f64,
    pictures: SmallVec<[Rows; 6]>,
    /// Mean of the longer sides of texels on the screen.
    side: f64,
    /// Mean of the longer sides of a uniform map's texels on the screen; infinite if none was tried.
    uniform: f64,
}

/// How a light's map was fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fit {
    /// Depth of the nearest receiver, which is the near plane, in the view's units.
    pub near: f64,
    /// Depth of the farthest receiver.
    pub far: f64,
    /// Distance by which the virtual viewer stands behind the eye; infinite: the map is uniform.
    pub slide: f64,
    /// Number of faces.
    pub faces: usize,
    /// Mean of the longer sides of texels on the screen, pixels, for faces with as many texels along a side as the screen
    /// has pixels.
    pub texel_side: f64,
    /// Whether the faces of a cube stand in for one picture of a directional light. Each has half the side.
    pub replaces_one: bool,
}

/// Memory that is used again in every frame.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    points: Vec<DVec3>,
    projected: Vec<DVec3>,
    directions: Vec<DVec3>,
    picture: Vec<DVec2>,
    samples: Vec<Sample>,
}

/// Returns the faces of a light's map, none if there is nothing to show, and how they were fitted.
pub fn fit_faces(input: &FitInput, scratch: &mut Scratch) -> Option<(MapFaces, Fit)> {
    let space = ViewSpace::new(input.view)?;
    let half_spaces = input.half_spaces(&space);
    let (near, far) = input.collect_points(&space, &half_spaces, &mut scratch.points)?;
    let light = input.light.point_world;
    let Scratch { points, samples, .. } = &mut *scratch;
    collect_samples(&space, input.boxes, &half_spaces, points, light, samples);
    let most = input.most_growth(&space, near);
    let is_cube = input.settings.faces == PerspectiveFaces::Cube;
    let one = (!is_cube)
        .then(|| choose(input, &space, (near, far), most, false, scratch))
        .flatten();
    let may_be_replaced = space.is_perspective && light.w == 0.0;
    let limit = if input.replaced_one { GOOD } else { POOR };
    let needs_several = one
        .as_ref()
        .is_none_or(|one| may_be_replaced && one.side > limit * one.uniform);
    let several = needs_several
        .then(|| choose(input, &space, (near, far), most, true, scratch))
        .flatten();
    let had_one = one.is_some();
    // Faces of half the side: four of them have the texels of one picture. What is shown already is kept if it is about as good.
    let texel = if input.replaced_one { 1.7 } else { 2.0 };
    let chosen = match (one, several) {
        (Some(one), Some(several)) if one.side <= texel * several.side => one,
        (one, several) => several.or(one)?,
    };
    let faces: MapFaces = chosen
        .pictures
        .iter()
        .filter_map(|rows| place_face(input, &space, rows, &scratch.points))
        .collect();
    let projection = Projection::new(near, far, chosen.growth, space.is_perspective);
    let fit = Fit {
        near,
        far,
        slide: projection.slide(),
        faces: faces.len(),
        texel_side: chosen.side,
        replaces_one: had_one && faces.len() > 1,
    };
    Some((faces, fit))
}

/// Tries slides, and returns the pictures with the smallest texels on the screen. `None` if one picture cannot show all
/// points.
fn choose(
    input: &FitInput,
    space: &ViewSpace,
    (near, far): (f64, f64),
    most: f64,
    several: bool,
    scratch: &mut Scratch,
) -> Option<Choice> {
    let mut growths: SmallVec<[f64; 32]> = SmallVec::new();
    let most = most.min((MOST_RATIO - 1.0) / (far - near));
    if let Some(slide) = input.settings.slide {
        // An orthographic view may begin behind the virtual viewer.
        let depth = near + f64::from(slide);
        growths.push(if depth > 0.0 {
            depth.recip().min(most)
        } else {
            most
        });
    } else {
        let mut growth = most;
        while growth * (far - near) > FLAT && growths.len() < 31 {
            growths.push(growth);
            growth /= SLIDE_STEP;
        }
        growths.push(0.0); // for comparison, a uniform map
    }
    let mut best: Option<Choice> = None;
    let mut uniform = f64::INFINITY;
    for growth in growths {
        let projection = Projection::new(near, far, growth, space.is_perspective);
        let Some(pictures) = pictures(input, space, &projection, several, scratch) else {
            continue;
        };
        let side = mean_texel_side(&pictures, &scratch.samples);
        if growth == 0.0 {
            uniform = side;
        }
        if best.as_ref().is_none_or(|best| side < best.side) {
            best = Some(Choice {
                growth,
                pictures,
                side,
                uniform,
            });
        }
    }
    best.map(|best| Choice { uniform, ..best })
}

/// Returns the pictures for one projection, with rows for view coordinates.
fn pictures(
    input: &FitInput,
    space: &ViewSpace,
    projection: &Projection,
    several: bool,
    scratch: &mut Scratch,
) -> Option<SmallVec<[Rows; 6]>> {
    let Scratch {
        points,
        projected,
        directions,
        picture,
        ..
    } = scratch;
    projected.clear();
    projected.extend(points.iter().map(|point| projection.point(*point)));
    let light = projection.light(space.homogeneous(input.light.point_world));
    let mut pictures: SmallVec<[Rows; 6]> = if several {
        let whole = input.settings.focus == MapFocus::All;
        cube::sides(&light, projected, whole)
    } else {
        SmallVec::from_slice(&[light_camera::fit(&light, projected, directions, picture)?])
    };
    let to_view = projection.matrix.transpose();
    for rows in &mut pictures {
        *rows = rows.map(|row| to_view * row);
    }
    (!pictures.is_empty()).then_some(pictures)
}
