//! What is drawn is what the maps say.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::IntervalLibrary;
use antumbra::techniques::occlusion_interval::{
    BakeStatistics, BakedSurface, Corner, IntervalMaps, Page, intervals_of, surface_hash,
};
use bevy_transform::prelude::Transform;
use glam::{Affine3A, Vec2, Vec3};

use super::scenes::{SIZE, add_light, lit_ladder, maps, page_place, path, seen, settings};
use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};

#[test]
fn the_mask_holds_what_the_twin_computes() {
    let maps = maps();
    let mut stage = lit_ladder(maps.clone(), 0.0, 0.0);
    let light = stage.lights[0];
    let (scene, hits) = seen(&mut stage);
    for (time, width) in [(0.5, 0.0), (0.35, 0.08), (0.02, 0.1), (1.0, 0.5)] {
        stage.world.entity_mut(light).insert(settings(time, width));
        let rendered = stage.render().expect("the frame renders");
        let window = maps.window(time, width);
        let other = maps.window(if time > 0.5 { time - 0.07 } else { time + 0.07 }, width);
        let (mut wrong, mut wrong_of_other, mut soft, mut all) = (0, 0, 0, 0);
        for (hit, drawn) in hits.hits.iter().zip(&rendered.visibility[0]) {
            let Some(hit) = hit else { continue };
            let (page, texel) = page_place(&stage, &scene, hit);
            let is_wrong = |expected: f32| usize::from((expected - drawn).abs() > 6e-3);
            wrong += is_wrong(maps.visibility(page, texel, &window));
            wrong_of_other += is_wrong(maps.visibility(page, texel, &other));
            soft += usize::from((0.02..0.98).contains(drawn));
            all += 1;
        }
        println!(
            "{time} {width}: {wrong} of {all} differ, {soft} are soft; {wrong_of_other} of another time"
        );
        assert!(all > 1000 && soft > 20, "{all} pixels, {soft} soft");
        // A ray and a rasterizer may see different sides of an edge.
        assert!(wrong * 250 <= all, "{time} {width}: {wrong} of {all}");
        assert!(
            wrong_of_other * 60 > all,
            "the comparison can fail: {wrong_of_other}"
        );
    }
}

/// A plane of 4 m whose every texel sees the light when `seen` says.
pub fn plane(seen: fn(usize) -> bool, path: LightPath) -> (Stage, Arc<IntervalMaps>) {
    let view = Transform::from_xyz(0.0, 4.0, 0.0).looking_at(Vec3::ZERO, Vec3::Z);
    let mut stage = Stage::empty(SIZE, Camera::default(), view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let mesh = MeshData::plane(2.0);
    let intervals = intervals_of(seen);
    let mut page = Page::dark(8, intervals.len().div_ceil(4).max(1));
    for texel in 0..64 {
        page.write(texel, &intervals);
    }
    let corner = |&index: &u32| Corner {
        page: 0,
        texel: Vec2::new(mesh.positions[index as usize].x, mesh.positions[index as usize].z) + 4.0,
    };
    let maps = IntervalMaps {
        key: 0,
        path,
        texels_per_metre: 1.0,
        size: 8,
        pages: vec![page],
        surfaces: vec![BakedSurface {
            mesh: "plane".to_owned(),
            hash: surface_hash(&mesh, &mesh.submeshes[0]),
            world_from_local: Affine3A::IDENTITY.to_cols_array(),
            is_two_sided: true,
            casts: true,
            corners: 0..6,
        }],
        corners: mesh.indices.iter().map(corner).collect(),
        statistics: BakeStatistics::default(),
    };
    stage.world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::IDENTITY,
    ));
    (stage, Arc::new(maps))
}

/// Visibility in the middle of the picture at a time.
pub fn at(stage: &mut Stage, time: f32, width: f32) -> f32 {
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(settings(time, width));
    let rendered = stage.render().expect("the frame renders");
    rendered.visibility[0][(SIZE.y / 2 * SIZE.x + SIZE.x / 2) as usize]
}

#[test]
fn a_point_that_is_lit_twelve_times_is_drawn_lit_twelve_times() {
    let (mut stage, maps) = plane(|step| step % 20 < 7 && step < 240, path());
    assert_eq!(maps.pair_count(), 3);
    add_light(&mut stage, maps, 0.0, 0.0);
    for interval in [0, 1, 3, 4, 7, 8, 11] {
        let start = 20.0 * interval as f32 / 256.0;
        assert!(at(&mut stage, start + 3.5 / 256.0, 0.0) > 0.998, "{interval}");
        assert_eq!(at(&mut stage, start + 10.5 / 256.0, 0.0), 0.0, "{interval}");
        let half = at(&mut stage, start + 7.0 / 256.0, 10.0 / 256.0);
        assert!((half - 0.5).abs() < 2e-3, "{interval}: {half}");
    }
}

#[test]
fn time_wraps_around_a_closed_path_and_stops_at_the_ends_of_an_open_one() {
    let arc = |degrees: f32| LightPath::Arc {
        direction: Vec3::new(-1.0, -2.0, -0.5),
        axis: Vec3::Y,
        degrees,
    };
    let (mut closed, maps) = plane(|step| step < 64, arc(360.0));
    add_light(&mut closed, maps, 0.0, 0.1);
    assert!((at(&mut closed, 0.0, 0.1) - 0.5).abs() < 2e-3);
    assert!(
        (at(&mut closed, 1.0, 0.1) - 0.5).abs() < 2e-3,
        "the end is the start"
    );
    assert!(
        (at(&mut closed, -3.99, 0.1) - 0.6).abs() < 2e-3,
        "a hundredth after it"
    );
    let (mut open, maps) = plane(|step| step < 64, arc(359.0));
    add_light(&mut open, maps, 0.0, 0.1);
    assert!(at(&mut open, 0.0, 0.1) > 0.998);
    assert_eq!(at(&mut open, 1.0, 0.1), 0.0);
}

#[test]
fn a_light_follows_its_path_and_steady_frames_make_nothing() {
    let mut stage = lit_ladder(maps(), 0.25, 0.02);
    // Tests that share a device share its pipelines, and these are counted.
    stage
        .add_renderer(
            own_context(RequestedFeatures::default()),
            RenderSettings::default(),
        )
        .expect("shaders compose");
    let light = stage.lights[0];
    let first = stage.render().expect("the frame renders");
    let direction = stage.world.resource::<FrameLights>().lights[0].direction;
    let antumbra::scene::PathPoint::Direction(expected) = path().at(0.25) else {
        panic!("an arc has directions");
    };
    assert!(direction.distance(expected) < 1e-5, "{direction} {expected}");
    let made = |stage: &Stage| stage.world.resource::<Renderer>().pipelines_created();
    let pipelines = made(&stage);
    let second = stage.render().expect("the frame renders");
    assert_eq!(first.picture, second.picture);
    assert_eq!(made(&stage), pipelines);
    stage.world.entity_mut(light).insert(settings(0.6, 0.02));
    let third = stage.render().expect("the frame renders");
    assert_ne!(first.picture, third.picture, "time is a setting of the frame");
    assert_eq!(made(&stage), pipelines);
}

#[test]
fn the_sun_lights_nothing_at_night_whether_it_is_in_the_maps_or_not() {
    let day = LightPath::Sun {
        latitude_degrees: 0.0,
        day: 81.0,
        hours: [0.0, 24.0],
    };
    let (mut stage, maps) = plane(|step| (64..192).contains(&step), day);
    // Something that is not in the maps hides the middle of the plane.
    let mut stranger = MeshData::plane(0.4);
    stranger.name = "stranger".to_owned();
    stage.world.spawn((
        SceneMesh(Arc::new(stranger)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_xyz(0.0, 0.5, 0.0),
    ));
    let light = add_light(&mut stage, maps.clone(), 0.0, 0.02);
    let seen = |stage: &mut Stage, time: f32| {
        stage.world.entity_mut(light).insert(settings(time, 0.02));
        let rendered = stage.render().expect("the frame renders");
        let visibility = &rendered.visibility[0];
        let at = |x: u32| visibility[(SIZE.y / 2 * SIZE.x + x) as usize];
        [at(SIZE.x / 2), at(SIZE.x / 2 + SIZE.y / 4)]
    };
    for (time, share) in [(0.0, 0.0), (0.1, 0.0), (0.25, 0.5), (0.5, 1.0), (0.9, 0.0)] {
        let [stranger, baked] = seen(&mut stage, time);
        assert!((stranger - share).abs() < 2e-3, "{time}: {stranger}");
        assert!((baked - share).abs() < 2e-3, "{time}: {baked}");
    }
    // Lights whose maps cannot be used keep their nights.
    stage.world.resource_mut::<IntervalLibrary>().forget("ladder");
    assert_eq!(seen(&mut stage, 0.1), [0.0; 2]);
    assert_eq!(seen(&mut stage, 0.5), [1.0; 2]);
}

#[test]
fn triangles_on_no_page_show_no_shadow() {
    let (mut stage, maps) = plane(|_| false, path());
    add_light(&mut stage, maps.clone(), 0.5, 0.0);
    assert_eq!(at(&mut stage, 0.5, 0.0), 0.0, "the light is never seen");
    let mut without = (*maps).clone();
    without.corners.fill(Corner::NOWHERE);
    let mut library = stage.world.resource_mut::<IntervalLibrary>();
    library.insert("ladder", Arc::new(without));
    assert_eq!(at(&mut stage, 0.5, 0.0), 1.0);
}
