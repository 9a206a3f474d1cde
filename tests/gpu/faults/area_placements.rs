//! Area lights at random places in, on and beside surfaces, judged by rays.

use std::f32::consts::TAU;

use antumbra::prelude::*;
use antumbra::reference::{
    HitImage, LightSource, Ray, RayScene, camera_rays, hard_visibility, primary_hits, soft_visibility,
};
use antumbra::silhouettes::LightClearance;
use antumbra::techniques::PenumbraWedges;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, Quat, UVec2, Vec3};

use super::placements::{Random, on_triangle};
use super::scenes::{draw, lamp, object, stage};
use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;

/// Pixels of a picture. Each of them is a receiver at a random place.
const SMALL: UVec2 = UVec2::new(8, 5);

/// Half of the side of the room around everything, metres.
const ROOM: f32 = 3.0;

/// Number of places in one frame.
const AT_ONCE: usize = 4;

/// Heights of a light's centre over a surface, as shares of the light's extent. Below 1, the surface cuts most lights.
const HEIGHTS: [f64; 10] = [0.0, 1e-5, -1e-5, 0.2, -0.2, 0.6, -0.6, 0.95, -0.95, 1.2];

/// Heights at which a light lies on one side of the surface.
const CLEAR_HEIGHTS: [f64; 3] = [1.2, 2.0, 4.0];

/// Closed, open, coarse and fine surfaces, and how they are turned.
fn meshes() -> [(MeshData, Quat); 4] {
    [
        (
            MeshData::cuboid(Vec3::new(0.8, 0.5, 0.6)),
            Quat::from_rotation_x(0.4),
        ),
        (MeshData::plane(0.9), Quat::from_rotation_z(1.2)),
        (MeshData::icosphere(0.8, 0), Quat::IDENTITY),
        (MeshData::icosphere(0.8, 3), Quat::IDENTITY),
    ]
}

/// A closed room with a mesh in its middle.
struct Site {
    stage: Stage,
    scene: RayScene,
    /// Triangles of the mesh, and those of the room after them.
    triangles: Vec<[DVec3; 3]>,
    mesh_count: usize,
}

impl Site {
    /// A site with so many lights without a shape, a place and a technique.
    fn new((mesh, turn): (MeshData, Quat), lights: usize) -> Self {
        let mut stage = stage(Vec3::Z, Vec3::ZERO, Camera::default());
        stage.world.insert_resource(ViewportSize(SMALL));
        let mesh_count = mesh.triangle_count();
        let room = MeshData::cuboid(Vec3::splat(ROOM));
        for (mesh, turn) in [(mesh, turn), (room, Quat::IDENTITY)] {
            stage.world.spawn(object(mesh, Transform::from_rotation(turn)));
        }
        for _ in 0..lights {
            lamp(&mut stage, LightKind::Point, Vec3::Y, 20.0);
        }
        stage.schedule.run(&mut stage.world);
        let scene = RayScene::from_world(&mut stage.world);
        let mut triangles: Vec<_> = scene.triangles().iter().collect();
        triangles.sort_by_key(|triangle| (triangle.entity, triangle.source_index));
        let triangles = triangles.into_iter().map(|triangle| triangle.corners).collect();
        Self {
            stage,
            scene,
            triangles,
            mesh_count,
        }
    }

    /// Looks from a random place outside of the mesh past a random place near it.
    fn look(&mut self, random: &mut Random) {
        let eye = loop {
            let eye = random.point(2.8).as_vec3();
            if eye.length() > 1.3 {
                break eye;
            }
        };
        let target = random.point(1.0).as_vec3();
        let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
        let camera = Camera {
            vertical_fov: 1.6,
            near: 0.02,
            aspect: SMALL.x as f32 / SMALL.y as f32,
            ..Camera::default()
        };
        let entity = self.stage.camera;
        self.stage.world.entity_mut(entity).insert((camera, view));
    }

    /// A light of random shape and size on a random triangle or beside it. One in eight is at the walls. One rectangle in
    /// four lies nearly in the plane of the triangle.
    fn random_light(&self, random: &mut Random, heights: &[f64]) -> Placement {
        let (first, count) = if random.unit() < 0.125 {
            (self.mesh_count, self.triangles.len() - self.mesh_count)
        } else {
            (0, self.mesh_count)
        };
        let chosen = self.triangles[first + (random.unit() * count as f64) as usize];
        let height = heights[(random.unit() * heights.len() as f64) as usize];
        let extent = 0.05 + 0.3 * random.unit() * random.unit();
        let at = on_triangle(random, chosen, height * extent).as_vec3();
        let axis = random.point(1.0).as_vec3().normalize_or(Vec3::Y);
        let turn = Quat::from_axis_angle(axis, TAU * random.unit() as f32);
        let kind = match (random.unit() * 2.0) as u32 {
            0 => LightKind::Sphere {
                radius: extent as f32,
            },
            _ => LightKind::Rect {
                width: 2.0 * extent as f32,
                height: extent as f32 * (0.4 + 1.6 * random.unit() as f32),
            },
        };
        let [a, b, c] = chosen;
        let normal = (b - a).cross(c - a).normalize().as_vec3();
        let flat = Transform::default()
            .looking_to(normal, normal.any_orthonormal_vector())
            .rotation;
        let tilt = Quat::from_axis_angle(axis, (0.02 * random.unit() * random.unit()) as f32);
        let is_flat = random.unit() < 0.25;
        Placement {
            kind,
            at,
            turn: if is_flat { tilt * flat } else { turn },
            height,
        }
    }

    fn place(&mut self, light: usize, placement: Placement) {
        let mut entity = self.stage.world.entity_mut(self.stage.lights[light]);
        let mut light = entity.get_mut::<Light>().expect("a light");
        light.kind = placement.kind;
        entity.insert(Transform::from_translation(placement.at).with_rotation(placement.turn));
    }

    /// Returns what the pixels show, and what is seen a hundredth of a pixel beside them. Pixels beside which another triangle is
    /// seen are left out: the rasterizer may show that one.
    fn receivers(&self) -> Receivers {
        let world = &self.stage.world;
        let camera = world.get::<Camera>(self.stage.camera).expect("a camera");
        let place = world
            .get::<GlobalTransform>(self.stage.camera)
            .expect("its place");
        let mut centre = primary_hits(&self.scene, camera, place, SMALL).expect("it sees");
        let rays = camera_rays(camera, place, SMALL).expect("it sees");
        let [right, down] =
            [1, SMALL.x as usize].map(|next| (rays[next].direction - rays[0].direction) * 0.01);
        let mut beside = [right, -right, down, -down].map(|step| (step, centre.clone()));
        for (pixel, ray) in rays.iter().enumerate() {
            for (step, image) in &mut beside {
                let ray = Ray {
                    direction: ray.direction + *step,
                    ..*ray
                };
                let seen = self
                    .scene
                    .closest_hit(&ray, f64::from(camera.near), f64::INFINITY, |_| true);
                match (seen, &mut image.hits[pixel]) {
                    (Some(seen), Some(hit)) if seen.triangle == hit.triangle => {
                        hit.position = ray.origin + ray.direction * seen.t;
                    }
                    _ => centre.hits[pixel] = None,
                }
            }
        }
        Receivers {
            centre,
            beside: beside.map(|(_, image)| image),
        }
    }

    fn source(&self, light: usize) -> LightSource {
        LightSource::of_entity(&self.stage.world, self.stage.lights[light]).expect("it shines")
    }
}

/// The surfaces that pixels show.
struct Receivers {
    centre: HitImage,
    beside: [HitImage; 4],
}

impl Receivers {
    /// The visibility of a light's centre; NaN where the edge of a shadow passes through a pixel so close to its centre that
    /// the rasterizer decides.
    fn hard(&self, scene: &RayScene, source: &LightSource) -> Vec<f32> {
        let mut seen = hard_visibility(scene, &self.centre, source).values().to_vec();
        for image in &self.beside {
            let beside = hard_visibility(scene, image, source);
            for (seen, beside) in seen.iter_mut().zip(beside.values()) {
                if seen != beside {
                    *seen = f32::NAN;
                }
            }
        }
        seen
    }
}

/// A light's shape and place.
#[derive(Clone, Copy, Debug)]
#[allow(dead_code, reason = "printed where the test fails")]
struct Placement {
    kind: LightKind,
    at: Vec3,
    turn: Quat,
    height: f64,
}

/// Errors of many receivers.
#[derive(Default)]
struct Tally {
    receivers: usize,
    /// Receivers that see a part of the light.
    partly: usize,
    sum: f64,
    /// Errors above a tenth, and where they are.
    large: Vec<(f32, String)>,
}

impl Tally {
    fn add(&mut self, truth: &[f32], got: &[f32], what: &dyn std::fmt::Debug) {
        for (pixel, (truth, got)) in truth.iter().zip(got).enumerate() {
            if truth.is_nan() {
                continue;
            }
            let error = (truth - got).abs();
            self.receivers += 1;
            self.partly += usize::from(*truth > 0.02 && *truth < 0.98);
            self.sum += f64::from(error);
            // NaN is large as well.
            if !(error <= 0.1) {
                self.large.push((
                    error,
                    format!("{truth} is drawn as {got} at pixel {pixel}, {what:?}"),
                ));
            }
        }
    }

    fn mean(&self) -> f64 {
        self.sum / self.receivers as f64
    }

    fn print(&self, name: &str) {
        let (receivers, partly, mean) = (self.receivers, self.partly, self.mean());
        println!(
            "{name}: {receivers} receivers, {partly} partly, mean {mean:.5}, {} off",
            self.large.len()
        );
        for (error, what) in self.large.iter().take(20) {
            println!("  {error}: {what}");
        }
    }
}

/// Draws lights at random places, `AT_ONCE` in a frame, in front of each mesh. `prepare` gives the lights of a site their
/// techniques: they are as many for each place as `kinds`. `judge` gets the pictures of each place, and the truth.
fn for_each_place(
    frames: usize,
    kinds: usize,
    heights: &[f64],
    prepare: impl Fn(&mut Site),
    mut judge: impl FnMut(&Site, &Receivers, usize, Placement, &Rendered),
) {
    let mut random = Random::new(11);
    for mesh in meshes() {
        let mut site = Site::new(mesh, AT_ONCE * kinds);
        prepare(&mut site);
        for _ in 0..frames {
            site.look(&mut random);
            let places = [(); AT_ONCE].map(|()| site.random_light(&mut random, heights));
            for (at, place) in places.into_iter().enumerate() {
                (0..kinds).for_each(|kind| site.place(at + kind * AT_ONCE, place));
            }
            let rendered = draw(&mut site.stage);
            let receivers = site.receivers();
            for (at, place) in places.into_iter().enumerate() {
                judge(&site, &receivers, at, place, &rendered);
            }
        }
    }
}

/// Wedges light by the part of the light that is outside, and volumes by its centre.
#[test]
fn a_thousand_area_lights_in_on_and_beside_surfaces_light_as_rays_do() {
    let [mut soft, mut hard, mut without] = [(); 3].map(|()| Tally::default());
    let mut left_out = 0;
    let prepare = |site: &mut Site| {
        for (index, light) in site.stage.lights.clone().into_iter().enumerate() {
            let mut light = site.stage.world.entity_mut(light);
            if index < AT_ONCE {
                light.insert(PenumbraWedge::default());
            } else {
                light.insert(StencilVolume::default());
            }
        }
    };
    for_each_place(
        63,
        2,
        &HEIGHTS,
        prepare,
        |site, receivers, at, place, rendered| {
            let source = site.source(at);
            let truth = soft_visibility(&site.scene, &receivers.centre, &source, 196, 1);
            let centre = receivers.hard(&site.scene, &source);
            let (wedges, volumes) = (&rendered.visibility[at], &rendered.visibility[at + AT_ONCE]);
            soft.add(truth.values(), wedges, &place);
            hard.add(&centre, volumes, &place);
            without.add(truth.values(), volumes, &place);
            let wedges = site.stage.world.resource::<PenumbraWedges>();
            left_out += usize::from(wedges.lights.iter().any(|light| light.cuts_left_out > 0));
        },
    );
    soft.print("wedges");
    hard.print("volumes");
    assert!(soft.receivers > 20_000 && soft.partly > 10_000);
    assert!(soft.mean() < 0.0044, "{}", soft.mean());
    assert!(soft.large.len() < 3, "{:#?}", soft.large);
    assert_eq!(left_out, 0);
    assert!(hard.large.len() < 4, "{:#?}", hard.large);
    // The visibility of the centre is no answer for an area that is cut.
    assert!(without.mean() > 0.1, "{}", without.mean());
}

/// With a clearance as wide as many of the lights, surfaces no longer cut them, which the judge sees.
#[test]
fn area_lights_that_are_not_cut_are_wrong() {
    let mut tally = Tally::default();
    let prepare = |site: &mut Site| {
        site.stage.world.insert_resource(LightClearance(0.01));
        for light in site.stage.lights.clone() {
            site.stage
                .world
                .entity_mut(light)
                .insert(PenumbraWedge::default());
        }
    };
    for_each_place(4, 1, &HEIGHTS, prepare, |site, receivers, at, place, rendered| {
        let truth = soft_visibility(&site.scene, &receivers.centre, &site.source(at), 64, 1);
        tally.add(truth.values(), &rendered.visibility[at], &place);
    });
    assert!(tally.mean() > 0.05 && tally.large.len() > 100, "{}", tally.mean());
}

/// Occlusion textures take lights that no surface cuts. Most of their error is at surfaces close to the light and at its side,
/// which fill a slice with it.
#[test]
fn area_lights_beside_surfaces_light_by_occlusion_textures_as_rays_do() {
    let [mut tally, mut without] = [(); 2].map(|()| Tally::default());
    let prepare = |site: &mut Site| {
        for light in site.stage.lights.clone() {
            let textures = OcclusionTexture {
                resolution: 128,
                ..OcclusionTexture::default()
            };
            site.stage.world.entity_mut(light).insert(textures);
        }
    };
    for_each_place(
        8,
        1,
        &CLEAR_HEIGHTS,
        prepare,
        |site, receivers, at, place, rendered| {
            let truth = soft_visibility(&site.scene, &receivers.centre, &site.source(at), 196, 1);
            tally.add(truth.values(), &rendered.visibility[at], &place);
            without.add(truth.values(), &vec![1.0; truth.values().len()], &place);
        },
    );
    tally.print("occlusion textures");
    without.print("no shadows");
    assert!(tally.receivers > 2000 && tally.mean() < 0.2, "{}", tally.mean());
    assert!(without.mean() > 0.5, "{}", without.mean());
}
