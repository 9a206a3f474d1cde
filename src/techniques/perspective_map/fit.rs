//! The faces of a light in this frame.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::component::{MapFocus, PerspectiveFaces};
use super::cube;
use super::fit_input::FitInput;
use super::light_camera::{self, Rows};
use super::place_face::place_face;
use super::projection::Projection;
use super::texels::{Sample, collect_samples, mean_texel_side, median_texel_side};
use super::view_space::ViewSpace;
use crate::techniques::maps::request::MapFaces;

/// Ratio between the slides that are tried.
const SLIDE_STEP: f64 = 4.0;

/// Largest ratio of w between far and near receivers. Beyond, the rounding of large casters' corners shows near the eye.
const MOST_RATIO: f64 = 256.0;

/// Largest ratio of w for the faces of a cube whose texels are larger than [`HUGE`] with [`MOST_RATIO`]. What rounding takes
/// from contacts is then less than what such texels would take. Measured: with a ball at 370 km in view, 2 % of the pixels were
/// wrong in place of 30 %, and over hills of 4 km, whose texels are not that large, it made things worse.
const LARGEST_RATIO: f64 = 1024.0;

/// Mean side of a texel on the screen, pixels, with as many texels along a side as pixels, from which on hardly any edge is left.
const HUGE: f64 = 100.0;

/// Growth of w over the visible depth below which a perspective looks like none.
const FLAT: f64 = 0.1;

/// Share of a uniform map's texel side from which on one picture gains so little that the cube's faces are tried. By eye.
const POOR: f64 = 0.6;

/// Share of a uniform map's texel side below which one picture takes over again from the cube's faces. The distance from
/// [`POOR`] keeps a turning view from replacing textures in every other frame.
const GOOD: f64 = 0.5;

/// Mean side of a texel on the screen, pixels, with as many texels along a side as pixels, from which on the cube's faces are
/// tried although one picture gains much on a uniform map: that gains little itself where the map reaches over kilometres. One
/// picture of a usual view has less than 10.
const LARGE: f64 = 16.0;

/// Mean side of a texel on the screen, pixels, with as many texels along a side as pixels, from which on the cube's faces are
/// tried for a light at a position. Below the ceilings of rooms one picture had up to 25, because it must be as wide as the
/// receivers around the light, and the faces had 1.1 to 1.8.
const COARSE: f64 = 2.0;

/// Share of the depth of the nearest sample below which a set slide does not bring the virtual viewer: a near plane within the
/// bounds of receivers is far nearer than any surface, and texels would be spent on air. In front of a bare ground, the lowest
/// sample of the screen is at most a quarter farther away than the nearest point.
const NEAREST_SHARE: f64 = 0.75;

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
    /// Median of the longer sides of texels on the screen, in the same unit.
    pub usual_side: f64,
    /// Whether the faces of a cube stand in for one picture, which would be coarse. Those of a directional light have half the
    /// side.
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
    sides: Vec<f64>,
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
    let limit = if input.replaced_one { GOOD } else { POOR };
    let (large, coarse) = (LARGE * limit / POOR, COARSE * limit / POOR);
    let is_poor = |one: &Choice| {
        if light.w != 0.0 {
            one.side > coarse
        } else {
            space.is_perspective && (one.side > limit * one.uniform || one.side > large)
        }
    };
    let needs_several = one.as_ref().is_none_or(is_poor);
    let several = needs_several
        .then(|| choose(input, &space, (near, far), most, true, scratch))
        .flatten();
    let had_one = one.is_some();
    // Four faces of half the side have the texels of one picture. What is shown already is kept if it is about as good.
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
        usual_side: median_texel_side(&chosen.pictures, &scratch.samples, &mut scratch.sides),
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
    let within = |ratio: f64| most.min((ratio - 1.0) / (far - near));
    let of_grounds = input.growth_of_grounds(space);
    let most = within(MOST_RATIO);
    let mut growths: SmallVec<[f64; 32]> = SmallVec::new();
    if let Some(slide) = input.settings.slide {
        // An orthographic view may begin behind the virtual viewer.
        let depths = scratch.samples.iter().map(|sample| sample.point.z);
        let nearest = depths.reduce(f64::min).unwrap_or(near);
        let depth = (near + f64::from(slide)).max(NEAREST_SHARE * nearest);
        let growth = if depth > 0.0 {
            depth.recip().min(most)
        } else {
            most
        };
        growths.push(growth.min(of_grounds));
    } else {
        let mut growth = most;
        while growth * (far - near) > FLAT && growths.len() < 31 {
            let next = growth / SLIDE_STEP;
            if next < of_grounds {
                growths.push(growth.min(of_grounds));
            }
            growth = next;
        }
        growths.push(0.0); // for comparison, a uniform map
    }
    let mut best: Option<Choice> = None;
    let mut uniform = f64::INFINITY;
    // Returns the side of the best so far.
    let mut consider = |growth: f64| {
        let projection = Projection::new(near, far, growth, space.is_perspective);
        if let Some(pictures) = pictures(input, space, &projection, several, scratch) {
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
        best.as_ref().map(|best| best.side)
    };
    let mut side = None;
    for growth in growths {
        side = consider(growth);
    }
    if several && input.settings.slide.is_none() && side.is_some_and(|side| side > HUGE) {
        consider(within(LARGEST_RATIO).min(of_grounds));
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
