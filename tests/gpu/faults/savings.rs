//! Counts the work that volumes and wedges leave out, because the pictures are the same without these savings.

use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::sets::OcclusionSettings;
use antumbra::techniques::penumbra_wedge::WedgeBounds;
use antumbra::techniques::stencil_volume::{CasterVolume, Counting, Extent, StencilVolumes};
use antumbra::techniques::{PenumbraWedge, PenumbraWedges, StencilVolume};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::scenes::{draw, ground, lamp, object, stage};
use crate::harness::support::stage::Stage;

fn volumes(stage: &mut Stage) -> Vec<CasterVolume> {
    stage.schedule.run(&mut stage.world);
    let volumes = stage.world.resource::<StencilVolumes>();
    volumes
        .lights
        .iter()
        .flat_map(|light| light.casters.clone())
        .collect()
}

fn box_at(stage: &mut Stage, at: Vec3) -> Entity {
    let mesh = MeshData::cuboid(Vec3::new(0.3, 0.2, 0.25));
    stage
        .world
        .spawn(object(mesh, Transform::from_translation(at)))
        .id()
}

fn sun(stage: &mut Stage, volume: StencilVolume) -> Entity {
    let light = Light {
        kind: LightKind::Directional,
        color: Vec3::ONE,
        intensity: 3.0,
        range: f32::INFINITY,
    };
    let place = Transform::default().looking_to(Vec3::new(0.3, -1.0, 0.2), Vec3::Y);
    stage.spawn_light(light, place, Some(volume))
}

/// The only volume that is not the ground's.
fn only(stage: &mut Stage, entity: Entity) -> Option<CasterVolume> {
    let all = volumes(stage);
    let object = stage
        .world
        .resource::<antumbra::sets::Objects>()
        .index_of(entity)?;
    all.into_iter().find(|volume| volume.object as usize == object)
}

#[test]
fn parts_of_volumes_out_of_view_are_left_out() {
    let mut stage = ground();
    let settings = StencilVolume {
        counting: Counting::DepthFail,
        ..StencilVolume::default()
    };
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.0, 5.0, 0.0), 30.0);
    stage.world.entity_mut(light).insert(settings);
    let caster = box_at(&mut stage, Vec3::new(0.0, 1.0, 0.0));
    let seen = only(&mut stage, caster).expect("it shadows the view");
    assert!(seen.near_cap && seen.far_cap, "{seen:?}");
    // To infinity, the far cap is below the view.
    stage.world.entity_mut(light).insert(StencilVolume {
        extent: Extent::Infinite,
        ..settings
    });
    let below = only(&mut stage, caster).expect("it shadows the view");
    assert!(below.near_cap && !below.far_cap, "{below:?}");
    stage.world.entity_mut(light).insert(settings);
    // Above the view, and its shadow falls into it.
    let above = Transform::from_xyz(0.0, 4.5, 0.0);
    stage.world.entity_mut(caster).insert(above);
    let out_of_view = only(&mut stage, caster).expect("it shadows the view");
    assert!(!out_of_view.near_cap && out_of_view.far_cap, "{out_of_view:?}");
    // Counted towards the viewer, a volume has no near cap, and to infinity no far cap.
    stage
        .world
        .entity_mut(caster)
        .insert(Transform::from_xyz(0.0, 1.0, 0.0));
    stage.world.entity_mut(light).insert(StencilVolume {
        extent: Extent::Infinite,
        ..StencilVolume::default()
    });
    let towards = only(&mut stage, caster).expect("it shadows the view");
    assert!(
        towards.depth_pass && !towards.near_cap && !towards.far_cap,
        "{towards:?}"
    );
}

/// A wall that is seen from the front, with a lamp and a box before it.
fn before_a_wall() -> (Stage, Entity, Entity) {
    let mut stage = stage(Vec3::new(0.0, 1.0, 8.0), Vec3::Y, Camera::default());
    let upright = Transform::from_xyz(0.0, 0.0, -3.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2));
    stage.world.spawn(object(MeshData::plane(6.0), upright));
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.0, 1.5, 6.0), 30.0);
    stage.world.entity_mut(light).insert(StencilVolume::default());
    let caster = box_at(&mut stage, Vec3::new(0.3, 1.0, 0.0));
    (stage, light, caster)
}

#[test]
fn far_caps_that_nothing_can_see_are_left_out() {
    let (mut stage, _, caster) = before_a_wall();
    let without_camera = OcclusionSettings {
        from_camera: false,
        ..OcclusionSettings::default()
    };
    stage.world.insert_resource(without_camera);
    let volume = only(&mut stage, caster).expect("it shadows the wall");
    assert!(
        volume.depth_pass && !volume.far_cap,
        "behind the wall: {volume:?}"
    );
    // Something is seen beside the wall that is farther than the far cap.
    let beyond = object(
        MeshData::cuboid(Vec3::splat(0.3)),
        Transform::from_xyz(10.0, 1.0, -8.0),
    );
    stage.world.spawn(beyond);
    let volume = only(&mut stage, caster).expect("it shadows the wall");
    assert!(volume.depth_pass && volume.far_cap, "{volume:?}");
    // The wall hides the far cap from the camera.
    stage.world.insert_resource(OcclusionSettings::default());
    let volume = only(&mut stage, caster).expect("it shadows the wall");
    assert!(volume.depth_pass && !volume.far_cap, "hidden: {volume:?}");
}

#[test]
fn volumes_behind_all_that_is_lit_are_left_out() {
    let (mut stage, light, caster) = before_a_wall();
    stage.world.insert_resource(OcclusionSettings {
        of_shadows: false,
        from_lights: false,
        ..OcclusionSettings::default()
    });
    stage.world.entity_mut(light).insert(StencilVolume {
        extent: Extent::Infinite,
        ..StencilVolume::default()
    });
    for (z, is_kept) in [(-5.0, false), (-1.0, true)] {
        let place = Transform::from_xyz(0.3, 1.0, z);
        stage.world.entity_mut(caster).insert(place);
        // The box itself must not count as lit.
        stage.world.entity_mut(caster).remove::<ShadowReceiver>();
        assert_eq!(only(&mut stage, caster).is_some(), is_kept, "at {z}");
        let culled = stage.world.resource::<StencilVolumes>().lights[0].culled;
        assert!(is_kept || culled >= 1, "{culled}");
    }
}

#[test]
fn sides_of_directional_volumes_are_triangles_without_a_far_cap() {
    for counting in [Counting::Auto, Counting::DepthFail] {
        let mut stage = ground();
        sun(
            &mut stage,
            StencilVolume {
                counting,
                ..StencilVolume::default()
            },
        );
        let caster = box_at(&mut stage, Vec3::new(0.0, 1.0, 0.0));
        let volume = only(&mut stage, caster).expect("it shadows the view");
        assert!(!volume.far_cap && volume.corners_per_edge() == 3, "{volume:?}");
    }
    let mut stage = ground();
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.0, 5.0, 0.0), 30.0);
    stage.world.entity_mut(light).insert(StencilVolume::default());
    let caster = box_at(&mut stage, Vec3::new(0.0, 1.0, 0.0));
    assert_eq!(
        only(&mut stage, caster).map(|volume| volume.corners_per_edge()),
        Some(4)
    );
}

#[test]
fn volumes_end_beyond_what_they_shadow() {
    let mut stage = ground();
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.0, 5.0, 0.0), 30.0);
    let caster = box_at(&mut stage, Vec3::new(0.0, 3.0, 0.0));
    let mut extrusion = |extent| {
        let settings = StencilVolume {
            extent,
            ..StencilVolume::default()
        };
        stage.world.entity_mut(light).insert(settings);
        only(&mut stage, caster).map(|volume| volume.extrusion)
    };
    assert_eq!(extrusion(Extent::Infinite), Some(0.0));
    // The caster's top is 1.8 m below the light, and the ground 5 m: 5 / 1.8 is 2.78.
    let finite = extrusion(Extent::Finite).expect("it shadows the view");
    assert!(finite > 2.7 && finite < 2.9, "{finite}");
}

#[test]
fn equal_volumes_are_one_draw() {
    let mut stage = ground();
    sun(&mut stage, StencilVolume::default());
    let mesh = Arc::new(MeshData::cuboid(Vec3::splat(0.1)));
    let batches = |stage: &mut Stage| {
        draw(stage);
        let renderer = stage.world.resource::<Renderer>();
        let lights = renderer.frame().lights.iter();
        lights
            .map(|light| renderer.shadow_batch_count(light))
            .sum::<usize>()
    };
    let add = |stage: &mut Stage, count: usize| {
        for i in 0..count {
            let at = Transform::from_xyz(-1.2 + 0.3 * (i % 8) as f32, 0.6, -1.0 + 0.3 * (i / 8) as f32);
            let id = stage.world.spawn(object(MeshData::default(), at)).id();
            stage.world.entity_mut(id).insert(SceneMesh(mesh.clone()));
        }
    };
    add(&mut stage, 1);
    let one = batches(&mut stage);
    add(&mut stage, 32);
    // Casters counted either way, with and without caps, are draws of their own.
    let many = batches(&mut stage);
    assert!(
        one >= 1 && many <= one + 6,
        "{one} draws of one box, {many} of 33"
    );
}

#[test]
fn wedges_end_below_the_ground_and_are_tight() {
    let mut stage = ground();
    let kind = LightKind::Rect {
        width: 1.5,
        height: 0.3,
    };
    let light = lamp(&mut stage, kind, Vec3::new(0.0, 5.0, 0.0), 30.0);
    let caster = box_at(&mut stage, Vec3::new(0.0, 1.0, 0.0));
    let mut widths = |bounds| {
        let settings = PenumbraWedge {
            bounds,
            ..PenumbraWedge::default()
        };
        stage.world.entity_mut(light).insert(settings);
        stage.schedule.run(&mut stage.world);
        let object = stage
            .world
            .resource::<antumbra::sets::Objects>()
            .index_of(caster)
            .unwrap();
        let wedges = stage.world.resource::<PenumbraWedges>();
        let at = wedges
            .casters
            .iter()
            .position(|draw| draw.object as usize == object)
            .unwrap();
        // One plane ends all rays of the caster, just below the ground.
        let [x, y, z, w] = wedges.caster_records[at].end_local;
        assert_eq!([x, y, z], [0.0, -1.0, 0.0]);
        assert!(w > 1.0 && w < 2.0, "{w}");
        let own = wedges.wedges.iter().filter(|wedge| wedge.caster as usize == at);
        let width = |wedge: &antumbra::insides::records::Wedge| {
            let rays = wedge.rims.map(|[x, y, z, _]| Vec3::new(x, y, z));
            let from = rays[0];
            rays.iter().map(|ray| ray.angle_between(from)).fold(0.0, f32::max)
        };
        let all: Vec<f32> = own.filter(|wedge| wedge.rims[0] != [0.0; 4]).map(width).collect();
        assert!(all.len() >= 4);
        all.iter().sum::<f32>() / all.len() as f32
    };
    let (tight, sphere) = (widths(WedgeBounds::Tight), widths(WedgeBounds::Sphere));
    assert!(tight < 0.75 * sphere, "{tight} of {sphere}");
}
