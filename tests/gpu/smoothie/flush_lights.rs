//! Lights on walls, up to their clearance before or behind them: smoothies grow at what blocks the light, and not at the surface
//! on which the light lies.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{RayScene, SurfaceHit};
use antumbra::silhouettes::Silhouettes;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use super::scenes::hits;
use crate::faults::placements::Random;
use crate::harness::support::stage::Stage;
use crate::harness::{strict_context, truth};

const SIZE: UVec2 = UVec2::new(96, 54);

/// Half the room's size, metres.
const HALF: Vec3 = Vec3::new(2.0, 1.25, 2.0);

/// Where a light lies: the middle of a surface and the direction out of it.
#[derive(Clone, Copy, Debug)]
struct Wall {
    middle: Vec3,
    normal: Vec3,
    /// Half the sizes along the surface.
    half: Vec3,
}

/// The ceiling, two walls and a side of a post.
const WALLS: [Wall; 4] = [
    Wall {
        middle: Vec3::new(0.0, 2.5, 0.0),
        normal: Vec3::NEG_Y,
        half: Vec3::new(1.8, 0.0, 1.8),
    },
    Wall {
        middle: Vec3::new(-2.0, 1.25, 0.0),
        normal: Vec3::X,
        half: Vec3::new(0.0, 1.0, 1.8),
    },
    Wall {
        middle: Vec3::new(0.0, 1.25, -2.0),
        normal: Vec3::Z,
        half: Vec3::new(1.8, 1.0, 0.0),
    },
    Wall {
        middle: Vec3::new(-0.8, 1.25, 0.3),
        normal: Vec3::X,
        half: Vec3::new(0.0, 1.0, 0.1),
    },
];

/// A room with a table, a crate and a post from floor to ceiling. The walls of the room have `cells` squares along a side.
fn room(cells: u32) -> (Stage, RayScene) {
    let camera = Camera {
        vertical_fov: 1.22,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(1.7, 1.5, 1.8).looking_at(Vec3::new(-0.4, 0.9, -0.6), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    stage.world.insert_resource(FaceCulling::None);
    let mut add = |mesh: MeshData, at: Vec3| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at),
        ));
    };
    add(walls(cells), Vec3::Y * HALF.y);
    add(
        MeshData::cuboid(Vec3::new(0.5, 0.02, 0.3)),
        Vec3::new(0.2, 0.72, -0.3),
    );
    add(MeshData::cuboid(Vec3::splat(0.25)), Vec3::new(-0.9, 0.25, -1.0));
    add(
        MeshData::cuboid(Vec3::new(0.1, HALF.y, 0.1)),
        Vec3::new(-0.9, HALF.y, 0.3),
    );
    stage.schedule.run(&mut stage.world);
    let rays = RayScene::from_world(&mut stage.world);
    (stage, rays)
}

/// The six sides of a box, seen from inside.
fn walls(cells: u32) -> MeshData {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for turn in [
        Quat::IDENTITY,
        Quat::from_rotation_x(std::f32::consts::PI),
        Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
    ] {
        let first = positions.len() as u32;
        for row in 0..=cells {
            for column in 0..=cells {
                let at = |step: u32| step as f32 / cells as f32 * 2.0 - 1.0;
                // Corners of neighbouring sides are equal bit for bit.
                let place = turn * Vec3::new(at(column), -1.0, at(row));
                positions.push((place * 4096.0).round() / 4096.0 * HALF);
            }
        }
        for row in 0..cells {
            for column in 0..cells {
                let at = |x: u32, z: u32| first + z * (cells + 1) + x;
                let [a, b, c, d] = [
                    at(column, row),
                    at(column + 1, row),
                    at(column + 1, row + 1),
                    at(column, row + 1),
                ];
                indices.extend([a, c, b, a, d, c]);
            }
        }
    }
    MeshData::from_triangles("walls", positions, indices)
}

/// Visibility of a light alone in the stage, and the number of edges that are left out of its silhouettes.
fn draw(stage: &mut Stage, lamp: &Lamp, depth: f32, technique: impl Component) -> (Vec<f32>, usize) {
    let Lamp { kind, wall, on } = *lamp;
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 20.0, 20.0)
    };
    let place = Transform::from_translation(on - wall.normal * depth);
    let place = place.looking_to(wall.normal, wall.normal.any_orthonormal_vector());
    for old in stage.lights.drain(..) {
        stage.world.despawn(old);
    }
    let entity = stage.spawn_light(light, place, Some(technique));
    let mut rendered = stage.render().expect("the frame renders");
    let silhouettes = stage.world.resource::<Silhouettes>().of_light(entity);
    let flush = silhouettes.map_or(0, |silhouettes| {
        let slots = silhouettes.slots.iter();
        slots.map(|slot| slot.contour.flush_edges.len()).sum()
    });
    (rendered.visibility.remove(0), flush)
}

/// A light on a wall.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    kind: LightKind,
    wall: Wall,
    on: Vec3,
}

/// The numbers of pixels that a group of pictures shows wrongly, and of those that are judged.
#[derive(Clone, Copy, Debug, Default)]
struct Wrong {
    /// Pixels that are lit in truth.
    lit: usize,
    /// Lit pixels that the plain map shows lit, and smoothies too when the same light hangs well before its wall.
    clear: usize,
    /// Clear pixels that smoothies show darker than 0.9.
    false_penumbra: usize,
    /// Pixels that are dark in truth, and so are their neighbours.
    dark: usize,
    /// Dark pixels that smoothies show lighter than ½.
    leaks: usize,
    /// Pixels in a penumbra.
    soft: usize,
}

impl Wrong {
    fn add(&mut self, other: &Self) {
        self.lit += other.lit;
        self.clear += other.clear;
        self.false_penumbra += other.false_penumbra;
        self.dark += other.dark;
        self.leaks += other.leaks;
        self.soft += other.soft;
    }
}

/// Metres before a wall at which it is farther from a light than the clearance, which is 0.16 to 0.32 mm in this room.
const BEFORE: f32 = 5e-4;

/// Judges the picture of a light that is some way behind a wall. Behind it the light shines as the rays say, which leave out the
/// triangles within the clearance; penumbrae are those of the light before the wall.
fn judge(stage: &mut Stage, rays: &RayScene, lamp: &Lamp, depth: f32) -> (Wrong, usize) {
    let (before, _) = draw(stage, lamp, -BEFORE, Smoothie::default());
    let (plain, _) = draw(stage, lamp, depth, OmniMap::default());
    let (got, flush) = draw(stage, lamp, depth, Smoothie::default());
    // Smoothies cast from the light's centre, and rectangles shine to one side.
    let light = stage.lights[0];
    stage.world.get_mut::<Light>(light).expect("it is a light").kind = LightKind::Point;
    let truth = truth(stage, rays, 0);
    let is_before = |hit: &SurfaceHit| (hit.position.as_vec3() - lamp.on).dot(lamp.wall.normal) > 0.01;
    let (width, values) = (SIZE.x as usize, truth.values());
    let mut wrong = Wrong::default();
    for (index, hit) in hits(stage).hits.iter().enumerate() {
        let expected = values[index];
        if expected.is_nan() || !hit.as_ref().is_some_and(is_before) {
            continue;
        }
        let value = got[index];
        wrong.soft += usize::from((0.1..0.9).contains(&value));
        if expected > 0.5 {
            let is_clear = before[index] > 0.95 && plain[index] > 0.95;
            wrong.lit += 1;
            wrong.clear += usize::from(is_clear);
            wrong.false_penumbra += usize::from(is_clear && value < 0.9);
        }
        let beside = [
            index.wrapping_sub(1),
            index + 1,
            index.wrapping_sub(width),
            index + width,
        ];
        let is_dark = |at: &usize| values.get(*at).is_some_and(|value| *value < 0.5);
        if is_dark(&index) && beside.iter().all(is_dark) {
            wrong.dark += 1;
            wrong.leaks += usize::from(value > 0.5);
        }
    }
    (wrong, flush)
}

/// The kinds of lights, by turns.
const KINDS: [LightKind; 3] = [
    LightKind::Sphere { radius: 0.1 },
    LightKind::Rect {
        width: 0.6,
        height: 0.4,
    },
    LightKind::Point,
];

/// Metres behind the wall.
const DEPTHS: [f32; 7] = [0.0, 2e-6, 1e-5, 4e-5, 1.2e-4, -1e-5, -1.2e-4];

#[test]
fn lamps_on_walls_have_no_penumbra_of_their_wall() {
    let mut random = Random::new(5);
    let mut bad = Vec::new();
    let (mut all, mut with_flush) = (Wrong::default(), 0);
    for cells in [1, 5] {
        let (mut stage, rays) = room(cells);
        for (round, depth) in DEPTHS.into_iter().cycle().take(2 * DEPTHS.len()).enumerate() {
            for (turn, wall) in WALLS.into_iter().enumerate() {
                let mut within = || random.unit() as f32 * 2.0 - 1.0;
                let along = wall.half * Vec3::new(within(), within(), within());
                let lamp = Lamp {
                    kind: KINDS[(round + turn) % KINDS.len()],
                    wall,
                    on: wall.middle + along,
                };
                let (wrong, flush) = judge(&mut stage, &rays, &lamp, depth);
                with_flush += usize::from(flush > 0);
                all.add(&wrong);
                let line = format!("{cells} cells, {depth} m behind, {lamp:?}: {wrong:?}, {flush} edges");
                println!("{line}");
                if wrong.false_penumbra * 100 > wrong.clear || wrong.leaks * 50 > wrong.dark {
                    bad.push(line);
                }
            }
        }
    }
    println!("{all:?}, {with_flush} pictures with edges that are left out");
    assert!(with_flush > 50, "{with_flush}");
    assert!(all.clear * 2 > all.lit && all.lit > 100_000, "{all:?}");
    assert!(all.dark > 10_000 && all.soft > 5_000, "{all:?}");
    assert!(bad.is_empty(), "{} pictures:\n{}", bad.len(), bad.join("\n"));
}

/// The judge of these tests notices the penumbra of a wall: that of a board on the ceiling, where before there was none.
#[test]
fn a_penumbra_of_the_ceiling_is_noticed() {
    let (mut stage, _) = room(1);
    let [ceiling, ..] = WALLS;
    let lamp = Lamp {
        kind: KINDS[0],
        wall: ceiling,
        on: ceiling.middle + Vec3::new(0.3, 0.0, 0.1),
    };
    let (before, _) = draw(&mut stage, &lamp, -BEFORE, Smoothie::default());
    let board = MeshData::cuboid(Vec3::new(0.005, 0.01, 0.5));
    stage.world.spawn((
        SceneMesh(Arc::new(board)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        ShadowCaster,
        Transform::from_translation(lamp.on - Vec3::new(0.4, 0.01, 0.0)),
    ));
    let (plain, _) = draw(&mut stage, &lamp, -BEFORE, OmniMap::default());
    let (got, _) = draw(&mut stage, &lamp, -BEFORE, Smoothie::default());
    let is_clear = |index: &usize| before[*index] > 0.95 && plain[*index] > 0.95;
    let clear: Vec<usize> = (0..got.len()).filter(is_clear).collect();
    let dim = clear.iter().filter(|index| got[**index] < 0.9).count();
    println!("{dim} of {}", clear.len());
    assert!(dim * 50 > clear.len(), "{dim} of {}", clear.len());
}
