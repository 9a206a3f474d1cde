//! Judges maps: what is wrong further from an edge than a texel of the map, and what is dark for no reason.

use antumbra::insides::matrix_faces;
use antumbra::prelude::*;
use antumbra::reference::{
    HitImage, LightShape, LightSource, Ray, RayScene, SurfaceHit, VisibilityImage, camera_rays, primary_hits,
};
use antumbra::techniques::maps::{FaceProjection, LightMap, MapFace, Maps};
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec2, DVec3};

use super::support::stage::Stage;
use super::truth;

/// How wrong a map's visibility is, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MapError {
    /// Pixels that count.
    pub counted: usize,
    /// Dark in truth.
    pub dark: usize,
    /// Wrong by more than ½ and not within a texel of a shadow's edge.
    pub wrong: usize,
    /// Of these: dark where the light is seen, with nothing but lit and even surface around.
    pub acne: usize,
    /// Of these: lit where the light is not seen.
    pub leaks: usize,
    /// Wrong within the band too.
    pub wrong_all: usize,
}

impl MapError {
    /// Share of the pixels that count that are wrong.
    pub fn share(&self) -> f64 {
        self.wrong as f64 / self.counted.max(1) as f64
    }

    /// Adds another picture's.
    pub fn add(&mut self, other: Self) {
        self.counted += other.counted;
        self.dark += other.dark;
        self.wrong += other.wrong;
        self.acne += other.acne;
        self.leaks += other.leaks;
        self.wrong_all += other.wrong_all;
    }
}

/// A frame's surfaces and one of its lights.
pub struct Judge<'a> {
    scene: &'a RayScene,
    /// What each pixel shows.
    pub hits: HitImage,
    /// Truth for each pixel.
    pub truth: VisibilityImage,
    rays: Vec<Ray>,
    source: LightSource,
    map: LightMap,
    /// Texels to each side of an edge that are not judged: 1, or as far as the filter reaches.
    pub band: f64,
}

impl<'a> Judge<'a> {
    /// Of the frame that ran last; `None` if the light's map was not looked up, for nothing casts into view.
    pub fn new(stage: &Stage, scene: &'a RayScene, light: usize) -> Option<Self> {
        let world = &stage.world;
        let camera = world.get::<Camera>(stage.camera).expect("the stage has a camera");
        let transform = world
            .get::<GlobalTransform>(stage.camera)
            .expect("and it stands somewhere");
        let size = world.resource::<ViewportSize>().0;
        let index = stage.light_indices()[light].expect("the light shines");
        Some(Self {
            scene,
            rays: camera_rays(camera, transform, size).expect("the camera is usable"),
            hits: primary_hits(scene, camera, transform, size).expect("the camera is usable"),
            truth: truth(stage, scene, light),
            source: LightSource::of_entity(world, stage.lights[light]).expect("the light is usable"),
            map: world.resource::<Maps>().of_light(index)?.clone(),
            band: 1.0,
        })
    }

    /// Compares a picture with the truth.
    pub fn compare(&self, got: &[f32]) -> MapError {
        let mut error = MapError::default();
        let width = self.hits.size.x as usize;
        for (index, (&truth, &got)) in self.truth.values().iter().zip(got).enumerate() {
            if truth.is_nan() {
                continue;
            }
            error.counted += 1;
            error.dark += usize::from(truth < 0.5);
            if (got - truth).abs() <= 0.5 {
                continue;
            }
            error.wrong_all += 1;
            let hit = self.hits.hits[index].as_ref().expect("what counts is a surface");
            if self.is_ambiguous(index, hit) {
                continue;
            }
            if got < 0.5 && self.is_even_from_light(hit) && self.is_even(index % width, index / width, hit) {
                error.acne += 1;
            } else if self.in_band(hit, truth) {
                continue;
            }
            error.leaks += usize::from(got > 0.5);
            error.wrong += 1;
        }
        error
    }

    /// The face that shows a point, and the point in it: NDC and distance along the face's axis.
    pub fn face_of(&self, point: DVec3) -> Option<(&MapFace, DVec2, f64)> {
        self.map.faces.iter().find_map(|state| {
            let face = &state.face;
            let [x, y, z] = face.axes.map(|axis| axis.dot(point - face.origin));
            let (ndc, inside) = match face.projection {
                FaceProjection::Perspective { tangent, .. } => {
                    let ndc = DVec2::new(x, y) / (z * tangent);
                    let cube = self.map.faces.len() == 6;
                    let limit = if cube { 1.0 / tangent } else { 1.0 };
                    (ndc, z > 0.0 && ndc.abs().max_element() <= limit + 1e-9)
                }
                FaceProjection::Parallel { half, length } => {
                    let ndc = DVec2::new(x, y) / half;
                    let room = 1.0 - 6.0 / f64::from(self.map.resolution);
                    (ndc, ndc.abs().max_element() < room && z < length)
                }
                FaceProjection::Matrix { .. } => {
                    let shown = matrix_faces::showing(self.map.faces.iter().map(|state| &state.face), point);
                    match shown.filter(|shown| self.map.faces[shown.face].face == *face) {
                        Some(shown) => (shown.ndc, true),
                        None => (DVec2::ZERO, false),
                    }
                }
            };
            inside.then_some((face, ndc, z))
        })
    }

    /// Side of a texel at a point, metres.
    pub fn texel_metres(&self, point: DVec3) -> f64 {
        let Some((face, _, z)) = self.face_of(point) else {
            return 0.0;
        };
        let texel = face.texel_metres(self.map.resolution);
        match face.projection {
            FaceProjection::Perspective { .. } => texel * z,
            FaceProjection::Parallel { .. } => texel,
            FaceProjection::Matrix { .. } => {
                let sides = matrix_faces::texel_at(face, point, self.map.resolution);
                sides.map(DVec3::length).into_iter().fold(0.0, f64::max)
            }
        }
    }

    /// The map's ray some texels off a point: from the light (or before the box), and where it goes.
    fn ray_beside(&self, point: DVec3, texels: DVec2) -> Option<(DVec3, DVec3)> {
        let (face, ndc, _) = self.face_of(point)?;
        let ndc = ndc + texels * 2.0 / f64::from(self.map.resolution);
        let [x, y, z] = face.axes;
        let (origin, direction) = match face.projection {
            FaceProjection::Perspective { tangent, .. } => {
                (face.origin, x * (ndc.x * tangent) + y * (ndc.y * tangent) + z)
            }
            FaceProjection::Parallel { half, .. } => {
                (face.origin + x * (ndc.x * half) + y * (ndc.y * half), z)
            }
            FaceProjection::Matrix { .. } => matrix_faces::ray(face, ndc),
        };
        Some((origin, direction))
    }

    /// The point of the surface's plane that lies some texels off, as the map sees it; `None` if the plane ends before.
    pub fn beside(&self, hit: &SurfaceHit, texels: DVec2) -> Option<DVec3> {
        let (origin, direction) = self.ray_beside(hit.position, texels)?;
        let facing = hit.normal.dot(direction);
        let t = hit.normal.dot(hit.position - origin) / facing;
        (facing < 0.0 && t > 0.0).then(|| origin + direction * t)
    }

    /// Whether a point of a surface's plane sees the light.
    pub fn sees(&self, point: DVec3, hit: &SurfaceHit) -> bool {
        let (receiver, casts_for) = (Some(hit.triangle), self.source.selection.casts_for);
        match self.source.shape {
            LightShape::Directional { towards } => {
                !self.scene.blocks_direction(point, towards, receiver, casts_for)
            }
            LightShape::Point { position } | LightShape::Spot { position, .. } => {
                !self.scene.blocks_segment(point, position, receiver, casts_for)
            }
            LightShape::Rect { center, .. } | LightShape::Sphere { center, .. } => {
                !self.scene.blocks_segment(point, center, receiver, casts_for)
            }
        }
    }

    /// Whether within a texel, to each side, the surface's plane is lit in parts and dark in parts.
    fn in_band(&self, hit: &SurfaceHit, truth: f32) -> bool {
        let steps = [-1.0, -0.5, 0.0, 0.5, 1.0];
        steps.iter().any(|&y| {
            steps.iter().any(|&x| {
                let beside = self.beside(hit, DVec2::new(x, y) * self.band);
                beside.is_none_or(|point| self.sees(point, hit) != (truth > 0.5))
            })
        })
    }

    /// Whether a fiftieth of a pixel beside, another surface is seen: which one the pixel shows is then left to rounding.
    fn is_ambiguous(&self, index: usize, hit: &SurfaceHit) -> bool {
        let width = self.hits.size.x as usize;
        let ray = &self.rays[index];
        let step = |other: usize| (self.rays[other].direction - ray.direction) * 0.02;
        let right = step(if index.is_multiple_of(width) {
            index + 1
        } else {
            index - 1
        });
        let down = step(if index >= width {
            index - width
        } else {
            index + width
        });
        [right + down, right - down, -right + down, -right - down]
            .into_iter()
            .any(|offset| {
                let ray = Ray {
                    origin: ray.origin,
                    direction: ray.direction + offset,
                };
                let seen = self.scene.closest_hit(&ray, 0.0, f64::INFINITY, |t| t.is_primary);
                seen.is_none_or(|seen| {
                    let [a, b, c] = self.scene.triangles()[seen.triangle as usize].corners;
                    let normal = (b - a).cross(c - a).normalize_or_zero();
                    let distance = (a - hit.position).dot(hit.normal).abs();
                    normal.dot(hit.normal).abs() < 0.999 || distance > 1e-3 * hit.distance
                })
            })
    }

    /// Whether all that the map sees within its texels around the point is one surface that bends by less than 20°.
    pub fn is_even_from_light(&self, hit: &SurfaceHit) -> bool {
        let texel = self.texel_metres(hit.position);
        let steps = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|step| step * (self.band + 0.5));
        steps.iter().all(|&y| {
            steps.iter().all(|&x| {
                let Some((origin, direction)) = self.ray_beside(hit.position, DVec2::new(x, y)) else {
                    return false;
                };
                let ray = Ray { origin, direction };
                let seen = self
                    .scene
                    .closest_hit(&ray, 1e-9, f64::INFINITY, |triangle| triangle.blocks);
                seen.is_some_and(|seen| {
                    let [a, b, c] = self.scene.triangles()[seen.triangle as usize].corners;
                    let normal = (b - a).cross(c - a).normalize_or_zero();
                    let point = origin + direction * seen.t;
                    normal.dot(hit.normal).abs() > 0.94
                        && (point - hit.position).dot(hit.normal).abs()
                            < 0.35 * point.distance(hit.position) + 1e-3 * texel
                })
            })
        })
    }

    /// Whether all pixels around, and those within a texel, are lit and bend by less than 20°.
    fn is_even(&self, x: usize, y: usize, hit: &SurfaceHit) -> bool {
        let (width, height) = (self.hits.size.x as usize, self.hits.size.y as usize);
        let reach = 2.0 * (self.band + 0.5) / f64::from(self.map.resolution);
        let Some((face, here, _)) = self.face_of(hit.position) else {
            return false;
        };
        (0..height).all(|v| {
            (0..width).all(|u| {
                let near = u.abs_diff(x) <= 1 && v.abs_diff(y) <= 1;
                let index = v * width + u;
                match &self.hits.hits[index] {
                    Some(other) => {
                        let close = self.face_of(other.position).is_some_and(|(other, there, _)| {
                            other == face && (there - here).abs().max_element() <= reach
                        });
                        let even = other.normal.dot(hit.normal) > 0.94
                            && (other.position - hit.position).dot(hit.normal).abs()
                                < 0.35 * other.position.distance(hit.position) + 1e-9;
                        !(near || close) || (even && self.truth.values()[index] == 1.0)
                    }
                    None => !near,
                }
            })
        })
    }
}

/// Judges one light's rendered visibility; nothing is wrong where no caster reaches into view.
pub fn judge_map(stage: &Stage, scene: &RayScene, light: usize, rendered: &[f32]) -> MapError {
    match Judge::new(stage, scene, light) {
        Some(judge) => judge.compare(rendered),
        None => {
            let truth = truth(stage, scene, light);
            let dark = truth.values().iter().filter(|value| **value == 0.0).count();
            MapError {
                counted: truth.counted(),
                dark,
                wrong: dark,
                leaks: dark,
                wrong_all: dark,
                acne: 0,
            }
        }
    }
}
