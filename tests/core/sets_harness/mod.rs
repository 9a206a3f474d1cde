//! Random scenes, and a judge of their sets that shares no code with the crate.
#![allow(dead_code, reason = "each test file uses a part")]

pub mod flat;
pub mod judge;

use antumbra::geometry::Aabb;
use antumbra::scene::{
    Camera, Light, LightDistance, LightKind, LightSelection, LightShape, Orthographic, SceneMaterials,
    SelectionLayers, ShadowCaster, ShadowOrigin, ShadowReceiver, ShadowSoftness, WorldBounds,
};
use antumbra::sets::{FrameLights, FrustumSet, Objects, ViewportSize, collect_sets, init_set_resources};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, EulerRot, Quat, UVec2, Vec2, Vec3};

use judge::Eye;

/// Size of all test pictures.
pub const VIEWPORT: UVec2 = UVec2::new(320, 180);

/// Random numbers: every scene follows from its seed.
pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    pub fn unit(&mut self) -> f64 {
        self.0.f64()
    }

    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        self.0.usize(..count)
    }

    pub fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    pub fn vec(&mut self, half: f64) -> DVec3 {
        DVec3::new(
            self.range(-half, half),
            self.range(-half, half),
            self.range(-half, half),
        )
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vec(1.0);
            if v.length_squared() <= 1.0 && v.length_squared() > 1e-4 {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> Quat {
        let mut angle = || self.range(-3.2, 3.2) as f32;
        Quat::from_euler(EulerRot::YXZ, angle(), angle(), angle())
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Thing {
    pub aabb: Aabb,
    pub caster: bool,
    pub receiver: bool,
    pub drawn: bool,
    pub layers: u32,
}

pub type SceneLight = (Light, GlobalTransform, LightSelection);

/// The light model of a light: barn doors, distances, and the place and extent of its shadows.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneModel {
    pub shape: Option<LightShape>,
    pub distance: Option<LightDistance>,
    pub origin: Option<ShadowOrigin>,
    pub softness: Option<ShadowSoftness>,
}

#[derive(Clone, Debug)]
pub struct Scene {
    pub camera: Camera,
    pub world_from_camera: GlobalTransform,
    pub things: Vec<Thing>,
    pub lights: Vec<SceneLight>,
    /// Models of the first lights; the others have none.
    pub models: Vec<SceneModel>,
}

impl Scene {
    /// The model of the light at this index.
    pub fn model(&self, light: usize) -> SceneModel {
        self.models.get(light).copied().unwrap_or_default()
    }
}

/// Index of an entity among the things of its scene.
#[derive(Component, Clone, Copy)]
pub struct Id(pub usize);

pub fn transform(translation: DVec3, rotation: Quat, scale: Vec3) -> GlobalTransform {
    Transform {
        translation: translation.as_vec3(),
        rotation,
        scale,
    }
    .into()
}

pub fn look(direction: DVec3) -> Quat {
    Quat::from_rotation_arc(Vec3::NEG_Z, direction.as_vec3().normalize())
}

fn random_things(random: &mut Random, origin: DVec3, count: usize) -> Vec<Thing> {
    let mut thing = |_| {
        let center = origin + random.vec(12.0);
        let half = DVec3::from_array([0; 3].map(|_| random.range(0.0, 1.0).powi(3) * 4.0));
        Thing {
            aabb: Aabb {
                min: (center - half).as_vec3(),
                max: (center + half).as_vec3(),
            },
            caster: random.chance(0.8),
            receiver: random.chance(0.8),
            drawn: random.chance(0.8),
            layers: 1 << random.below(3),
        }
    };
    (0..count).map(&mut thing).collect()
}

fn random_kind(random: &mut Random) -> LightKind {
    match random.below(5) {
        0 => LightKind::Point,
        1 => {
            let outer = random.range(0.05, 1.57);
            LightKind::Spot {
                inner_angle: (outer * 0.5) as f32,
                outer_angle: outer as f32,
            }
        }
        2 => LightKind::Directional,
        3 => LightKind::Rect {
            width: random.range(0.0, 3.0) as f32,
            height: random.range(0.0, 3.0) as f32,
        },
        _ => LightKind::Sphere {
            radius: random.range(0.0, 2.0) as f32,
        },
    }
}

/// Boxes and lights of all kinds; cameras also mirrored and far from the origin; lights where it hurts.
pub fn random_scene(seed: u64) -> Scene {
    scene_of(seed, |_| None)
}

/// As [`random_scene`], with barn doors, distances, moved and softened shadows.
pub fn random_modelled_scene(seed: u64) -> Scene {
    let mut scene = random_scene(seed);
    let mut random = Random::new(seed ^ 0x0d00);
    for (light, world_from_light, _) in &scene.lights {
        let is_directional = light.kind == LightKind::Directional;
        let mut size = |least: f64| (least + random.range(0.0, 1.3).powi(2)) as f32;
        let shape = LightShape {
            width: size(0.02),
            height: size(0.02),
            width_edge: size(0.0),
            height_edge: size(0.0),
            round: size(0.0).min(1.0),
        };
        let near = random.range(0.0, 3.0) as f32;
        let distance = LightDistance {
            near,
            far: near + random.range(0.0, 10.0) as f32,
            near_edge: random.range(0.0, 1.0) as f32,
            far_edge: random.range(0.0, 3.0) as f32,
        };
        let by = random.vec(4.0).as_vec3();
        let origin = if is_directional {
            ShadowOrigin::Direction(by)
        } else {
            ShadowOrigin::Position(world_from_light.translation() + by)
        };
        scene.models.push(SceneModel {
            shape: (!is_directional && random.chance(0.7)).then_some(shape),
            distance: (!is_directional && random.chance(0.5)).then_some(distance),
            origin: random.chance(0.3).then_some(origin),
            softness: random
                .chance(0.3)
                .then_some(ShadowSoftness(random.range(0.0, 2.0) as f32)),
        });
    }
    scene
}

/// As [`random_scene`], seen by orthographic cameras: most reach behind themselves, and some show nothing else.
pub fn random_orthographic_scene(seed: u64) -> Scene {
    scene_of(seed, |random| {
        let near = random.range(-25.0, 4.0) as f32;
        Some((near, near + random.range(1.0, 30.0) as f32))
    })
}

/// `planes` gives the near and far plane of an orthographic view.
fn scene_of(seed: u64, planes: impl Fn(&mut Random) -> Option<(f32, f32)>) -> Scene {
    let mut random = Random::new(seed);
    let origin = [
        DVec3::ZERO,
        DVec3::ZERO,
        DVec3::new(3e3, -2e3, 5e3),
        DVec3::new(-1e6, 2e5, 4e5),
    ][random.below(4)];
    let mirror = random.chance(0.25);
    let mut off_center = || random.range(-0.9, 0.9) as f32;
    let shift = Vec2::new(off_center(), off_center()) * f32::from(u8::from(random.chance(0.3)));
    let mut camera = Camera {
        vertical_fov: random.range(0.2, 2.4) as f32,
        near: random.range(0.05, 0.6) as f32,
        aspect: random.range(0.5, 2.5) as f32,
        shift,
        ..Camera::default()
    };
    if let Some((near, far)) = planes(&mut random) {
        camera.near = near;
        let height = random.range(2.0, 20.0) as f32;
        camera.orthographic = Some(Orthographic { height, far });
    }
    let scale = Vec3::new(if mirror { -1.0 } else { 1.0 }, 1.0, 1.0);
    let mut scene = Scene {
        camera,
        world_from_camera: transform(origin + random.vec(3.0), random.rotation(), scale),
        things: random_things(&mut random, origin, 40),
        lights: Vec::new(),
        models: Vec::new(),
    };
    let eye = Eye::new(&scene);
    for _ in 0..6 {
        let kind = random_kind(&mut random);
        let sign = |random: &mut Random| if random.chance(0.5) { -1.0 } else { 1.0 };
        let corner = eye.ray(sign(&mut random), sign(&mut random));
        let side = eye.ray(random.range(-1.0, 1.0), 1.0);
        let inside = eye.ray(random.range(-0.8, 0.8), random.range(-0.8, 0.8));
        let mut position = match random.below(7) {
            0 => eye.position,
            1 => eye.position + corner * random.range(0.0, 8.0),
            2 => eye.position + side * random.range(-8.0, 8.0),
            3 => eye.position - eye.forward * random.range(0.0, 8.0),
            4 => eye.position + inside * random.range(0.0, 8.0),
            _ => origin + random.vec(12.0),
        };
        if camera.orthographic.is_some() && random.chance(0.5) {
            let depth = eye.depth_at(random.range(-0.2, 1.2));
            position = eye.point_at(random.range(-1.0, 1.0), random.range(-1.0, 1.0), depth);
        }
        let rotation = match random.below(4) {
            0 => look(corner),
            1 => look(-corner),
            2 => look(side),
            _ => random.rotation(),
        };
        let light = Light {
            kind,
            color: Vec3::ONE,
            intensity: 1.0,
            range: [f64::INFINITY, random.range(0.5, 20.0)][random.below(2)] as f32,
        };
        let mask = |random: &mut Random| [u32::MAX, 0b011, 0b100][random.below(3)];
        let selection = LightSelection {
            affects: mask(&mut random),
            casts_for: mask(&mut random),
            shows_on: mask(&mut random),
        };
        let world_from_light = transform(position, rotation, Vec3::ONE);
        scene.lights.push((light, world_from_light, selection));
    }
    scene
}

/// A storey of rooms with walls, crates and a lamp each: boxes as interiors have them.
pub fn rooms(seed: u64, side: usize) -> Scene {
    let mut random = Random::new(seed);
    let middle = side as f64 * 3.0;
    let eye = DVec3::new(middle + 1.0, 1.6, middle + 1.0);
    let mut scene = Scene {
        camera: Camera::default(),
        world_from_camera: transform(eye, look(DVec3::new(1.0, -0.1, 0.3)), Vec3::ONE),
        things: Vec::new(),
        lights: Vec::new(),
        models: Vec::new(),
    };
    let mut push = |min: DVec3, max: DVec3| {
        scene.things.push(Thing {
            aabb: Aabb {
                min: min.as_vec3(),
                max: max.as_vec3(),
            },
            caster: true,
            receiver: true,
            drawn: true,
            layers: 1,
        });
    };
    for x in 0..side {
        for z in 0..side {
            let corner = DVec3::new(x as f64, 0.0, z as f64) * 6.0;
            push(corner - DVec3::Y * 0.2, corner + DVec3::new(6.0, 0.0, 6.0));
            push(corner, corner + DVec3::new(4.5, 3.0, 0.2));
            push(corner, corner + DVec3::new(0.2, 3.0, 4.5));
            for _ in 0..4 {
                let at = corner + DVec3::new(random.range(0.8, 5.2), 0.0, random.range(0.8, 5.2));
                push(at, at + DVec3::new(0.5, random.range(0.4, 1.8), 0.5));
            }
            let lamp = corner + DVec3::new(3.0, 2.6, 3.0);
            scene.lights.push((
                Light::point(Vec3::ONE, 40.0, 7.0),
                transform(lamp, Quat::IDENTITY, Vec3::ONE),
                LightSelection::default(),
            ));
        }
    }
    scene
}

/// The scene as a world, its things spawned in this order, and a schedule of the sets.
pub fn spawn(scene: &Scene, order: &[usize]) -> (World, Schedule) {
    let mut world = World::new();
    init_set_resources(&mut world);
    world.insert_resource(ViewportSize(VIEWPORT));
    world.spawn((scene.camera, scene.world_from_camera));
    for &i in order {
        let thing = &scene.things[i];
        let mut entity = world.spawn((
            Id(i),
            WorldBounds(thing.aabb),
            SelectionLayers(thing.layers),
            GlobalTransform::IDENTITY,
        ));
        if thing.caster {
            entity.insert(ShadowCaster);
        }
        if thing.receiver {
            entity.insert(ShadowReceiver);
        }
        if thing.drawn {
            entity.insert(SceneMaterials(Default::default()));
        }
    }
    for (index, (light, world_from_light, selection)) in scene.lights.iter().enumerate() {
        let mut entity = world.spawn((light.clone(), *world_from_light, *selection));
        let SceneModel {
            shape,
            distance,
            origin,
            softness,
        } = scene.model(index);
        if let Some(shape) = shape {
            entity.insert(shape);
        }
        if let Some(distance) = distance {
            entity.insert(distance);
        }
        if let Some(origin) = origin {
            entity.insert(origin);
        }
        if let Some(softness) = softness {
            entity.insert(softness);
        }
    }
    let mut schedule = Schedule::default();
    schedule.add_systems(collect_sets());
    (world, schedule)
}

/// The scene after its first frame.
pub fn run(scene: &Scene) -> (World, Schedule) {
    let order: Vec<usize> = (0..scene.things.len()).collect();
    let (mut world, mut schedule) = spawn(scene, &order);
    schedule.run(&mut world);
    (world, schedule)
}

/// A cube that takes every part.
pub fn thing(center: Vec3, half: f32) -> Thing {
    Thing {
        aabb: Aabb::around(center, Vec3::splat(half)),
        caster: true,
        receiver: true,
        drawn: true,
        layers: 1,
    }
}

/// A scene seen from the origin along −Z.
pub fn simple(things: Vec<Thing>, lights: Vec<(Light, Vec3)>) -> Scene {
    let place = |(light, at): (Light, Vec3)| {
        let world_from_light = transform(at.as_dvec3(), Quat::IDENTITY, Vec3::ONE);
        (light, world_from_light, LightSelection::default())
    };
    Scene {
        camera: Camera::default(),
        world_from_camera: GlobalTransform::IDENTITY,
        things,
        lights: lights.into_iter().map(place).collect(),
        models: Vec::new(),
    }
}

type Ids = Vec<usize>;

/// F, and L, I, S of each light with its scissor and depth bounds, as ids: comparable between worlds.
pub fn all_sets(world: &World) -> (Ids, Vec<(String, [Ids; 3])>) {
    let objects = world.resource::<Objects>();
    let ids = |set: &fixedbitset::FixedBitSet| {
        let id = |i: usize| world.get::<Id>(objects.entities[i]).unwrap().0;
        let mut ids: Ids = set.ones().map(id).collect();
        ids.sort_unstable();
        ids
    };
    let mut lights: Vec<_> = world
        .resource::<FrameLights>()
        .lights
        .iter()
        .map(|light| {
            let place = format!("{:?} {:?}", light.light, light.world_from_light);
            let bounds = format!(
                "{place} {:?} {:?}",
                light.region.scissor, light.region.depth_bounds
            );
            (
                bounds,
                [ids(&light.sets.l), ids(&light.sets.i), ids(&light.sets.s)],
            )
        })
        .collect();
    lights.sort();
    (ids(&world.resource::<FrustumSet>().set), lights)
}
