//! A ladder against a wall, and what a linear light does there.

use std::sync::{Arc, LazyLock};

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, SurfaceHit, primary_hits};
use antumbra::scene::PathPoint;
use antumbra::techniques::occlusion_interval::{IntervalScenes, Window};
use antumbra::techniques::{IntervalLibrary, IntervalMaps};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, Quat, UVec2, Vec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

pub const SIZE: UVec2 = UVec2::new(64, 36);
pub const TEXELS_PER_METRE: f32 = 8.0;

/// The sun passes from the right to the left, in front of the wall.
pub fn path() -> LightPath {
    LightPath::Arc {
        direction: Vec3::new(-1.0, -0.2, -0.5),
        axis: Vec3::Z,
        degrees: 150.0,
    }
}

/// Spawns a white object that casts and receives.
pub fn spawn(world: &mut World, mesh: MeshData, place: Transform) {
    world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        place,
    ));
}

/// A ladder against a wall below a roof, without a light and a renderer.
pub fn ladder() -> Stage {
    let view = Transform::from_xyz(0.5, 1.6, 3.2).looking_at(Vec3::new(0.0, 0.9, 0.0), Vec3::Y);
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    let world = &mut stage.world;
    spawn(world, MeshData::plane(2.0), Transform::IDENTITY);
    spawn(
        world,
        MeshData::cuboid(Vec3::new(1.5, 1.0, 0.1)),
        Transform::from_xyz(0.0, 1.0, -0.8),
    );
    let roof = MeshData::cuboid(Vec3::new(1.5, 0.05, 0.6));
    spawn(world, roof, Transform::from_xyz(0.0, 2.05, -0.3));
    let leaning = Transform::from_xyz(0.0, 0.0, 0.1).with_rotation(Quat::from_rotation_x(-0.35));
    for x in [-0.3, 0.3] {
        let rail = Transform::from_xyz(x, 0.9, 0.0);
        spawn(
            world,
            MeshData::cuboid(Vec3::new(0.05, 0.9, 0.05)),
            leaning * rail,
        );
    }
    for rung in 0..4 {
        let rung = Transform::from_xyz(0.0, 0.3 + 0.4 * rung as f32, 0.0);
        spawn(
            world,
            MeshData::cuboid(Vec3::new(0.3, 0.05, 0.04)),
            leaning * rung,
        );
    }
    stage.schedule.run(&mut stage.world);
    stage
}

/// The maps of the ladder, baked once for all tests.
pub fn maps() -> Arc<IntervalMaps> {
    static MAPS: LazyLock<Arc<IntervalMaps>> = LazyLock::new(|| {
        let settings = BakeSettings {
            texels_per_metre: TEXELS_PER_METRE,
            ..Default::default()
        };
        let bake = bake_intervals(&mut ladder().world, &path(), &settings, |_| ()).expect("it is baked");
        assert_eq!(bake.notes, []);
        Arc::new(bake.maps)
    });
    MAPS.clone()
}

pub fn settings(time: f32, width: f32) -> OcclusionInterval {
    OcclusionInterval {
        maps: "ladder".to_owned(),
        time,
        width,
        ..Default::default()
    }
}

/// The ladder in the light of maps.
pub fn lit_ladder(maps: Arc<IntervalMaps>, time: f32, width: f32) -> Stage {
    let mut stage = ladder();
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    add_light(&mut stage, maps, time, width);
    stage
}

/// Adds a light with maps to a stage.
pub fn add_light(stage: &mut Stage, maps: Arc<IntervalMaps>, time: f32, width: f32) -> Entity {
    let path = maps.path.clone();
    stage
        .world
        .resource_mut::<IntervalLibrary>()
        .insert("ladder", maps);
    let light = Light::directional(Vec3::ONE, 3.0);
    let light = stage.spawn_light(light, Transform::IDENTITY, Some(settings(time, width)));
    stage.world.entity_mut(light).insert(path);
    light
}

/// What the camera sees of a stage.
pub fn seen(stage: &mut Stage) -> (RayScene, HitImage) {
    let scene = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).expect("the camera");
    let place = stage
        .world
        .get::<GlobalTransform>(stage.camera)
        .expect("its place");
    let size = stage.world.resource::<ViewportSize>().0;
    let hits = primary_hits(&scene, camera, place, size).expect("the camera is usable");
    (scene, hits)
}

pub fn towards(path: &LightPath, time: f32) -> DVec3 {
    match path.at(time) {
        PathPoint::Direction(direction) => -direction.as_dvec3(),
        PathPoint::Position(position) => panic!("{position} is no direction"),
    }
}

/// Truth at one point: the share of `samples` points of the window that it sees.
pub fn truth_at(
    scene: &RayScene,
    hit: &SurfaceHit,
    path: &LightPath,
    [start, end]: [f32; 2],
    samples: u32,
) -> f32 {
    let seen = (0..samples).filter(|i| {
        let time = start + (end - start) * (*i as f32 + 0.5) / samples as f32;
        let towards = towards(path, time);
        hit.normal.dot(towards) > 0.0
            && !scene.blocks_direction(hit.position, towards, Some(hit.triangle), u32::MAX)
    });
    seen.count() as f32 / samples as f32
}

/// Points of the plane of a surface around one of its points, up to a texel away. Half a texel counts, too: a texel below the foot
/// of a ladder is dark, though its neighbours are not.
pub fn around(hit: &SurfaceHit, texel: f64) -> impl Iterator<Item = SurfaceHit> {
    let hit = *hit;
    let (right, up) = hit.normal.any_orthonormal_pair();
    let offsets = [0.5, 1.0]
        .into_iter()
        .flat_map(|share| (0..9).map(move |i| (share, i)));
    offsets.map(move |(share, i)| {
        let offset = right * f64::from(i % 3 - 1) + up * f64::from(i / 3 - 1);
        let position = hit.position + offset * (texel * share);
        SurfaceHit { position, ..hit }
    })
}

/// Truth at every pixel that faces the light, and whether truth varies within a texel there.
pub fn truth(
    scene: &RayScene,
    hits: &HitImage,
    path: &LightPath,
    time: f32,
    width: f32,
) -> Vec<Option<(f32, bool)>> {
    truth_of(scene, hits, path, (time, width), TEXELS_PER_METRE)
}

/// The same for any density of texels.
pub fn truth_of(
    scene: &RayScene,
    hits: &HitImage,
    path: &LightPath,
    (time, width): (f32, f32),
    texels_per_metre: f32,
) -> Vec<Option<(f32, bool)>> {
    let span = Window::new(time, width, false).spans[0];
    let light = towards(path, time);
    let step = 1.0 / f64::from(texels_per_metre);
    let at_pixel = |hit: &Option<SurfaceHit>| {
        let hit = hit.as_ref().filter(|hit| hit.normal.dot(light) > 1e-3)?;
        let visibility = truth_at(scene, hit, path, span, 24);
        let varies =
            around(hit, step).any(|other| (truth_at(scene, &other, path, span, 8) - visibility).abs() > 0.13);
        Some((visibility, varies))
    };
    hits.hits.iter().map(at_pixel).collect()
}

/// The place of a hit on the pages of a scene's maps.
pub fn page_place(stage: &Stage, scene: &RayScene, hit: &SurfaceHit) -> (u32, Vec2) {
    let triangle = &scene.triangles()[hit.triangle as usize];
    let baked = stage
        .world
        .resource::<IntervalScenes>()
        .scene_of(0)
        .expect("the light has maps");
    let entity = triangle.entity.expect("of an object");
    let matched = baked
        .matched
        .iter()
        .find(|matched| matched.entity == entity)
        .expect("it is in the maps");
    let first = baked.maps.surfaces[matched.surface as usize].corners.start + 3 * triangle.source_index;
    let corners = &baked.maps.corners[first as usize..first as usize + 3];
    let [a, b, c] = triangle.corners;
    let normal = (b - a).cross(c - a);
    let weight =
        |from: DVec3, to: DVec3| (to - from).cross(hit.position - from).dot(normal) / normal.length_squared();
    let weights = [weight(b, c), weight(c, a), weight(a, b)];
    let texel = (0..3).map(|i| corners[i].texel * weights[i] as f32).sum();
    (corners[0].page, texel)
}
