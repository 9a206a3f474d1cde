//! The faces of a light in this frame.

use glam::{DMat3, DVec2, DVec3, DVec4};
use smallvec::SmallVec;

use super::component::{MapFocus, PerspectiveFaces, PerspectiveMap, PerspectiveProjection};
use super::cube;
use super::light_camera::{self, Rows};
use super::projection::Projection;
use super::receivers::{corners, push_cut};
use super::shadowed::push_half_spaces;
use super::texels::{Sample, collect_samples, mean_texel_side};
use super::view_space::ViewSpace;
use crate::geometry::Aabb;
use crate::sets::{FrameLight, Objects, ViewData};
use crate::techniques::maps::matrix_faces::{parallel_face, point_face};
use crate::techniques::maps::members::{farthest, near_plane};
use crate::techniques::maps::request::MapFaces;

/// Ratio between the slides that are tried.
const SLIDE_STEP: f64 = 4.0;

/// Largest ratio of w between far and near receivers. Beyond, the rounding of large casters' corners shows near the eye.
const MOST_RATIO: f64 = 256.0;

/// Steepest slope of the plane under the receivers from which depth counts.
const STEEPEST_BASE: f64 = 100.0;

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

/// The input from which a light's faces are fitted.
#[derive(Clone, Copy, Debug)]
pub struct FitInput<'a> {
    /// The view.
    pub view: &'a ViewData,
    /// The light.
    pub light: &'a FrameLight,
    /// All objects.
    pub objects: &'a Objects,
    /// The light's settings.
    pub settings: &'a PerspectiveMap,
    /// Boxes that hold every visible point of the light's receivers, world space.
    pub boxes: &'a [Aabb],
    /// Distance to which the blur of grounds reaches beyond what is seen, metres.
    pub blur_metres: f64,
    /// Clearance of lights at a position from the surfaces that they may be on, as a share of distance.
    pub near_share: f64,
    /// Whether a cube's faces replaced one picture in the frame before.
    pub replaced_one: bool,
}

impl FitInput<'_> {
    /// The casters that the map shows: set S, or all that the light reaches if the map is kept.
    fn casters(&self) -> impl Iterator<Item = usize> + '_ {
        let kept = self
            .settings
            .cached
            .then(|| self.light.reached_casters(self.objects));
        let of_frame = (!self.settings.cached).then(|| self.light.sets.s.ones());
        kept.into_iter().flatten().chain(of_frame.into_iter().flatten())
    }

    /// Calls `each` with the middle and the half sides of the bounds of every caster.
    fn for_each_caster(&self, mut each: impl FnMut(DVec3, DVec3)) {
        for index in self.casters() {
            let (center, half) = self.objects.boxes.center_half(index);
            each(center, half);
        }
    }

    /// Half-spaces, in view coordinates, of what the view shows and the light lights.
    fn half_spaces(&self, space: &ViewSpace) -> SmallVec<[DVec4; 20]> {
        let mut half_spaces: SmallVec<[DVec4; 20]> = space.half_spaces.iter().copied().collect();
        let apex = self.light.point_world.truncate();
        if let Some((axis, half_angle)) = self.light.shadow_cone() {
            let angle = half_angle + 1e-5;
            half_spaces.push(space.half_space(axis, apex));
            if angle < std::f64::consts::FRAC_PI_2 {
                let (x, y) = axis.any_orthonormal_pair();
                let (sin, cos) = angle.sin_cos();
                half_spaces
                    .extend([x, -x, y, -y].map(|side| space.half_space(axis * sin - side * cos, apex)));
            }
        }
        let reach = self.blur_metres.max(self.softness());
        push_half_spaces(
            self.light,
            self.objects,
            self.view,
            space,
            self.casters(),
            reach,
            &mut half_spaces,
        );
        half_spaces
    }

    /// Radius of the filter: metres, or a share of the distance from a light at a position.
    fn softness(&self) -> f64 {
        f64::from(self.settings.filter.softness().unwrap_or(0.0))
    }

    /// Collects the points that the map must show, in view coordinates. Returns their least and greatest
    /// depth.
    fn collect_points(
        &self,
        space: &ViewSpace,
        half_spaces: &[DVec4],
        points: &mut Vec<DVec3>,
    ) -> Option<(f64, f64)> {
        points.clear();
        for aabb in self.boxes {
            let corners = corners(aabb).map(|corner| space.point(corner));
            push_cut(&corners, half_spaces, points);
        }
        let range = |points: &[DVec3]| {
            points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), point| {
                    (near.min(point.z), far.max(point.z))
                })
        };
        let (_, far) = range(points);
        if self.settings.focus == MapFocus::All && far > space.near {
            points.clear();
            let side = |depth: f64| if space.is_perspective { depth } else { 1.0 };
            let frustum: [DVec3; 8] = std::array::from_fn(|i| {
                let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let depth = if i >> 2 & 1 == 0 { space.near } else { far };
                DVec3::new(sign(0) * side(depth), sign(1) * side(depth), depth)
            });
            push_cut(&frustum, &half_spaces[space.half_spaces.len()..], points);
        }
        let (near, far) = range(points);
        if points.is_empty() {
            return None;
        }
        let softness = self.softness();
        if softness > 0.0 || self.blur_metres > 0.0 {
            self.widen(space, softness, points);
        }
        let near = if space.is_perspective {
            near.max(space.near)
        } else {
            near
        };
        Some((near, far.max(near + 1e-3 * near.abs().max(1e-3))))
    }

    /// Adds the places that the taps of a soft filter and of a blur reach.
    fn widen(&self, space: &ViewSpace, softness: f64, points: &mut Vec<DVec3>) {
        let light = self.light.point_world;
        for index in 0..points.len() {
            let world = space.eye_world + space.to_axes * (points[index] - space.eye);
            let ray = world * light.w - light.truncate();
            let radius = softness * if light.w == 0.0 { 1.0 } else { ray.length() };
            let radius = radius.max(self.blur_metres);
            let (x, y) = ray.normalize_or(DVec3::Z).any_orthonormal_pair();
            // A square with these corners holds the disc.
            for side in [x, -x, y, -y] {
                let mut beside = points[index] + space.from_axes * side * (radius * std::f64::consts::SQRT_2);
                beside.z = beside.z.max(space.near);
                points.push(beside);
            }
        }
    }

    /// The greatest growth of w that the projection allows.
    fn most_growth(&self, space: &ViewSpace, near: f64) -> f64 {
        if !space.is_perspective {
            return 0.0;
        }
        let most = near.recip();
        if self.settings.projection == PerspectiveProjection::Inverse {
            return most;
        }
        // The virtual eye stands behind all casters.
        let depth_row = space.from_axes.transpose().z_axis;
        let mut nearest = near;
        self.for_each_caster(|center, half| {
            nearest = nearest.min(space.point(center).z - depth_row.abs().dot(half));
        });
        if nearest >= 0.0 {
            return most;
        }
        (near - nearest * 1.01).recip()
    }
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
        // What an orthographic view shows may begin behind the virtual viewer.
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

/// Makes a face of a picture: the frame at the light in world space, and the homography that the rows are in
/// that frame.
fn place_face(
    input: &FitInput,
    space: &ViewSpace,
    rows: &Rows,
    points: &[DVec3],
) -> Option<crate::techniques::maps::MapFace> {
    let light = input.light.point_world;
    let column = |at: DVec4| DVec3::from_array(rows.map(|row| row.dot(at)));
    let direction = |axis: DVec3| column((space.from_axes * axis).extend(0.0));
    // A homography may be scaled; w is about 1 at the points.
    let w = |point: &DVec3| rows[2].dot(point.extend(1.0));
    let largest = points.iter().map(|point| w(point).abs()).fold(0.0, f64::max);
    let scale = largest.max(f64::MIN_POSITIVE).recip();
    let to_world = |point: &DVec3| space.eye_world + space.to_axes * (*point - space.eye);
    let face = if light.w == 0.0 {
        let z = -light.truncate().normalize();
        let (x, y) = z.any_orthonormal_pair();
        let axes = [x, y, z];
        let origin = to_world(points.first()?);
        let local = |point: &DVec3| {
            let offset = to_world(point) - origin;
            DVec3::from_array(axes.map(|axis| axis.dot(offset)))
        };
        // Near points have the most pixels, and the least w.
        let weighted = |point: &DVec3| (local(point), 1.0 / (point.z * point.z).max(1e-12));
        let base = base_plane(points.iter().map(weighted));
        let up = x * base.x + y * base.y - z;
        let mut height: f64 = 1e-3;
        input.for_each_caster(|center, half| {
            height = height.max(base.z + up.dot(center - origin) + up.abs().dot(half));
        });
        let at_origin = column(space.point(origin).extend(1.0));
        let homography = DMat3::from_cols(direction(x), direction(y), at_origin) * scale;
        parallel_face(origin, axes, &homography, base, height * (1.0 + 1e-3))
    } else {
        let origin = light.truncate();
        let middle = points.iter().map(to_world).sum::<DVec3>() / points.len() as f64;
        let z = (middle - origin).normalize_or(DVec3::NEG_Y);
        let (x, y) = z.any_orthonormal_pair();
        let homography = DMat3::from_cols(direction(x), direction(y), direction(z)) * scale;
        point_face(origin, [x, y, z], &homography, near_distance(input))
    };
    let clip = face.clip_from_world();
    (clip.is_finite() && clip.inverse().is_finite()).then_some(face)
}

/// Returns the plane z = a x + b y + c close to points with weights, as (a, b, c), with no point beyond it: the
/// plane of least squares, moved along z.
fn base_plane(points: impl Iterator<Item = (DVec3, f64)> + Clone) -> DVec3 {
    let sum = |value: &dyn Fn(DVec3) -> f64| points.clone().map(|(p, weight)| value(p) * weight).sum::<f64>();
    let total = sum(&|_| 1.0).max(f64::MIN_POSITIVE);
    let mean = DVec3::new(sum(&|p| p.x), sum(&|p| p.y), sum(&|p| p.z)) / total;
    let (xx, yy) = (sum(&|p| (p.x - mean.x).powi(2)), sum(&|p| (p.y - mean.y).powi(2)));
    let xy = sum(&|p| (p.x - mean.x) * (p.y - mean.y));
    let (xz, yz) = (
        sum(&|p| (p.x - mean.x) * (p.z - mean.z)),
        sum(&|p| (p.y - mean.y) * (p.z - mean.z)),
    );
    let ridge = 1e-9 * (xx + yy) + f64::MIN_POSITIVE;
    let (xx, yy) = (xx + ridge, yy + ridge);
    let determinant = xx * yy - xy * xy;
    let (a, b) = (
        (xz * yy - yz * xy) / determinant,
        (yz * xx - xz * xy) / determinant,
    );
    // Receivers along the light have no such plane.
    let is_steep = !(a.abs().max(b.abs()) < STEEPEST_BASE);
    let (a, b) = if is_steep { (0.0, 0.0) } else { (a, b) };
    let beyond = points
        .map(|(p, _)| p.z - a * p.x - b * p.y)
        .fold(f64::MIN, f64::max);
    DVec3::new(a, b, beyond + 1e-6 * (1.0 + beyond.abs()))
}

/// Distance from a light at a position within which nothing casts, metres. It is that of plain maps: it follows the
/// casters.
fn near_distance(input: &FitInput) -> f64 {
    if let Some(near) = input.settings.near {
        return f64::from(near);
    }
    let (light, objects) = (input.light, input.objects);
    let reach = farthest(light, input.casters(), objects);
    near_plane(light, input.casters(), objects, reach, input.near_share)
}
