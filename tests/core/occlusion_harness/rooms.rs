//! Random storeys of rooms: walls of boxes with openings, cells within them, portals in the openings.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{Cell, Portal};
use antumbra::schedule::init_resources;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec2, Vec3};

use super::{Random, VIEWPORT};

/// A storey.
pub struct Rooms {
    pub world: World,
    pub portals: Vec<Entity>,
}

/// Rooms along each axis.
const SIDE: usize = 3;
const SIZE: f32 = 5.0;
const HEIGHT: f32 = 3.0;

struct Builder {
    world: World,
    material: Arc<Material>,
}

impl Builder {
    fn block(&mut self, min: Vec3, max: Vec3) {
        let half = (max - min) * 0.5;
        if half.min_element() <= 0.0 {
            return;
        }
        self.world.spawn((
            SceneMesh(Arc::new(MeshData::cuboid(half))),
            SceneMaterials([self.material.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation((min + max) * 0.5),
        ));
    }

    /// A wall without thickness to speak of, in the plane `axis = at`, with an opening.
    fn wall(&mut self, axis: usize, at: f32, along: (f32, f32), opening: Option<(Vec2, Vec2)>) {
        let mut piece = |low: Vec2, high: Vec2| {
            let point = |p: Vec2, off: f32| {
                let mut v = Vec3::new(0.0, p.y, 0.0);
                v[axis] = at + off;
                v[2 - axis] = p.x;
                v
            };
            self.block(point(low, -0.001), point(high, 0.001));
        };
        let (low, high) = (Vec2::new(along.0, 0.0), Vec2::new(along.1, HEIGHT));
        let Some((from, to)) = opening else {
            return piece(low, high);
        };
        piece(low, Vec2::new(from.x, high.y));
        piece(Vec2::new(to.x, low.y), high);
        piece(Vec2::new(from.x, low.y), Vec2::new(to.x, from.y));
        piece(Vec2::new(from.x, to.y), Vec2::new(to.x, high.y));
    }
}

/// Rooms, things in them, and cameras and lights at all the bad places: in doorways, on portals' rims, in walls.
pub fn random_rooms(seed: u64) -> Rooms {
    let mut random = Random::new(seed ^ 0x7007);
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(VIEWPORT));
    world.insert_resource(FaceCulling::None);
    let mut build = Builder {
        world,
        material: Arc::new(Material::matte(Vec3::ONE)),
    };
    let end = SIDE as f32 * SIZE;
    build.block(Vec3::new(-1.0, -0.2, -1.0), Vec3::new(end + 1.0, 0.0, end + 1.0));
    build.block(
        Vec3::new(-1.0, HEIGHT, -1.0),
        Vec3::new(end + 1.0, HEIGHT + 0.2, end + 1.0),
    );
    let cell = |x: usize, z: usize| x * SIDE + z;
    let cells: Vec<Entity> = (0..SIDE * SIDE)
        .map(|at| {
            let (x, z) = ((at / SIDE) as f32, (at % SIDE) as f32);
            let middle = Vec3::new((x + 0.5) * SIZE, HEIGHT * 0.5, (z + 0.5) * SIZE);
            // Some overlap their neighbours by a little.
            let grow = if random.chance(0.2) { 0.0005 } else { 0.0 };
            let half_size = Vec3::new(SIZE * 0.5 + grow, HEIGHT * 0.5, SIZE * 0.5 + grow);
            build
                .world
                .spawn((Cell { half_size }, Transform::from_translation(middle)))
                .id()
        })
        .collect();
    let mut portals = Vec::new();
    let mut doorways = Vec::new();
    for axis in [0, 2] {
        for line in 0..=SIDE {
            for place in 0..SIDE {
                let at = line as f32 * SIZE;
                let along = (place as f32 * SIZE, (place + 1) as f32 * SIZE);
                let inner = line > 0 && line < SIDE;
                let opening = (inner && random.chance(0.75)).then(|| {
                    let from = Vec2::new(along.0 + random.range(0.3, 3.0), random.range(0.0, 1.2));
                    (
                        from,
                        from + Vec2::new(random.range(0.3, 1.6), random.range(0.4, 1.7)),
                    )
                });
                build.wall(axis, at, along, opening);
                let Some((from, to)) = opening else { continue };
                let (a, b) = if axis == 0 {
                    (cell(line - 1, place), cell(line, place))
                } else {
                    (cell(place, line - 1), cell(place, line))
                };
                let (middle, half) = ((from + to) * 0.5, (to - from) * 0.5);
                let mut point = Vec3::new(0.0, middle.y, 0.0);
                point[axis] = at;
                point[2 - axis] = middle.x;
                let turn = if axis == 0 {
                    std::f32::consts::FRAC_PI_2
                } else {
                    0.0
                };
                let portal = Portal::rectangle([cells[a], cells[b]], half.x, half.y);
                let place = Transform::from_translation(point).with_rotation(Quat::from_rotation_y(turn));
                portals.push(build.world.spawn((portal, place)).id());
                let mut rim = point;
                rim.y += half.y;
                doorways.push((point, rim));
            }
        }
    }
    for _ in 0..40 {
        let at = Vec3::new(
            random.range(0.1, end - 0.1),
            random.range(0.2, 2.6),
            random.range(0.1, end - 0.1),
        );
        let half = random.vec(0.3).abs() + 0.02;
        build.block(at - half, at + half);
    }
    // In a room, and off its walls: whether a viewer in the middle of a wall sees out of it is not asked.
    let in_a_room = |random: &mut Random| random.below(SIDE) as f32 * SIZE + random.range(0.1, SIZE - 0.1);
    let place = |random: &mut Random| {
        let free = Vec3::new(in_a_room(random), random.range(0.3, 2.7), in_a_room(random));
        match (random.below(6), doorways.is_empty()) {
            (0, false) => doorways[random.below(doorways.len())].0,
            (1, false) => doorways[random.below(doorways.len())].1,
            (2, false) => doorways[random.below(doorways.len())].0 + random.vec(0.05),
            (3, _) => Vec3::new(SIZE, free.y, free.z),
            _ => free,
        }
    };
    let camera = Camera {
        vertical_fov: random.range(0.6, 1.8),
        near: random.range(0.01, 0.1),
        aspect: 16.0 / 9.0,
        ..Camera::default()
    };
    let look = Quat::from_euler(
        glam::EulerRot::YXZ,
        random.range(-3.2, 3.2),
        random.range(-0.5, 0.5),
        0.0,
    );
    let eye = place(&mut random);
    build
        .world
        .spawn((camera, Transform::from_translation(eye).with_rotation(look)));
    for _ in 0..5 {
        let at = place(&mut random);
        super::scenes::spawn_light(&mut build.world, &mut random, at);
    }
    Rooms {
        world: build.world,
        portals,
    }
}
