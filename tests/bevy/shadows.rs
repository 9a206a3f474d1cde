//! Shadows in Bevy are those of our own renderer, and the truth.

use antumbra::bevy_adapter::prelude::*;
use antumbra::prelude::RenderSettings;
use antumbra::reference::{RayScene, VisibilityImage, compare_hard};
use antumbra::scene::{self, LightKind, MeshData, MorphTarget};
use bevy::light::NotShadowReceiver;
use bevy::prelude::*;

use crate::core_harness::support::stage::Stage;
use crate::core_harness::{ModelStage, model, strict_context, truth};
use crate::harness::Picture;
use crate::models::ModelGame;

const SIZE: UVec2 = UVec2::new(128, 72);

/// Visibility that Bevy's picture shows: what is left of the light where there is any; NaN elsewhere.
fn visibility(shadowed: &Picture, lit: &Picture) -> Vec<f32> {
    let pairs = shadowed.texels.iter().zip(&lit.texels);
    pairs
        .map(|(a, b)| {
            let (a, b) = (f32::from(a[1]), f32::from(b[1]));
            if b > 0.0 { a / b } else { f32::NAN }
        })
        .collect()
}

/// What a scene says.
#[derive(Debug, Default)]
struct Outcome {
    counted: usize,
    shadowed: usize,
    unlike_standalone: usize,
    wrong_inner: usize,
    wrong_all: usize,
}

impl Outcome {
    fn check(&self) {
        assert!(self.counted > 500 && self.shadowed > 50, "too little is seen");
        assert_eq!(self.unlike_standalone, 0);
        assert_eq!(self.wrong_inner, 0);
    }
}

fn compare(game: &mut ModelGame, path: &std::path::Path, case: usize, orthographic: bool) -> Outcome {
    let context = strict_context();
    let mut model = ModelStage::new(path, &context, SIZE).expect("triangles");
    let (mut label, mut case) = model.cases().swap_remove(case);
    if orthographic {
        let radius = model.bounds.half_size().length();
        case.camera = scene::Camera::orthographic(2.0 * radius, 0.0, 1000.0, case.camera.aspect);
        label += " orthographic";
    }
    model.set(&case, StencilVolume::default());
    let name = path.file_stem().unwrap().to_string_lossy();
    compare_stage(game, &mut model.stage, &format!("{name} {label}"))
}

/// The first light of a stage that stands ready, with shadow volumes: alone, in a game, and in truth.
fn compare_stage(game: &mut ModelGame, stage: &mut Stage, name: &str) -> Outcome {
    let standalone = stage
        .render()
        .expect("the frame renders")
        .visibility
        .swap_remove(0);
    let shadowed = game.show(stage, StencilVolume::default()).picture();
    let lit = game.set_casting(false).picture();
    lit.save(&format!("shadows_{name}_lit"));
    shadowed.save(&format!("shadows_{name}"));
    let got = visibility(&shadowed, &lit);
    let scene = RayScene::from_world(&mut stage.world);
    let truth = truth(stage, &scene, 0);
    let mut outcome = Outcome::default();
    // What Bevy's light does not reach cannot be told.
    let told: Vec<f32> = truth
        .values()
        .iter()
        .zip(&got)
        .map(|(truth, got)| if got.is_nan() { f32::NAN } else { *truth })
        .collect();
    for ((truth, got), ours) in told.iter().zip(&got).zip(&standalone) {
        if !truth.is_nan() {
            outcome.counted += 1;
            outcome.shadowed += usize::from(*truth == 0.0);
            outcome.unlike_standalone += usize::from((*got > 0.5) != (*ours > 0.5));
        }
    }
    let got = got.iter().map(|got| if *got > 0.5 { 1.0 } else { 0.0 }).collect();
    let (told, got) = (
        VisibilityImage::new(SIZE, told).unwrap(),
        VisibilityImage::new(SIZE, got).unwrap(),
    );
    let error = compare_hard(&told, &got).unwrap();
    (outcome.wrong_inner, outcome.wrong_all) = (error.wrong_inner, error.wrong_all);
    println!("{name}: {outcome:?}");
    outcome
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn stencil_shadows_equal_the_standalone_mask_and_the_truth() {
    let mut game = ModelGame::new();
    for (name, case) in SCENES {
        compare(&mut game, &model(name), case, false).check();
    }
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn orthographic_cameras_show_the_shadows_of_truth() {
    let mut game = ModelGame::new();
    // A point, a spot and a directional light, outside of the picture and inside.
    for (scene, case) in [(0, 0), (0, 2), (0, 9), (1, 9), (2, 1)] {
        compare(&mut game, &model(SCENES[scene].0), case, true).check();
    }
}

/// A box that a morph target draws out to a pillar, on a ground.
fn morphing(weight: f32) -> Stage {
    let context = strict_context();
    let camera = scene::Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let view = Transform::from_xyz(2.0, 4.0, 6.0).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context, RenderSettings::default())
        .expect("shaders compose");
    let mut pillar = MeshData::cuboid(Vec3::splat(0.4));
    let raise = |p: &Vec3| if p.y > 0.0 { Vec3::Y * 1.5 } else { Vec3::ZERO };
    pillar.morph_targets = vec![MorphTarget {
        positions: pillar.positions.iter().map(raise).collect(),
        normals: vec![Vec3::ZERO; pillar.positions.len()],
        tangents: Vec::new(),
    }];
    for (mesh, place, weights) in [
        (MeshData::plane(8.0), Transform::IDENTITY, None),
        (pillar, Transform::from_xyz(0.0, 0.6, 0.0), Some(weight)),
    ] {
        let object = stage.world.spawn((
            scene::SceneMesh(std::sync::Arc::new(mesh)),
            scene::SceneMaterials([std::sync::Arc::new(scene::Material::matte(Vec3::ONE))].into()),
            (scene::ShadowCaster, scene::ShadowReceiver),
            place,
        ));
        let object = object.id();
        if let Some(weight) = weights {
            stage
                .world
                .entity_mut(object)
                .insert(scene::MorphWeights(vec![weight]));
        }
    }
    stage.world.insert_resource(scene::FaceCulling::None);
    let place = Transform::from_xyz(2.5, 4.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
    stage.spawn_light(
        scene::Light::point(Vec3::ONE, 40.0, 30.0),
        place,
        Some(StencilVolume::default()),
    );
    stage
}

#[test]
fn morphed_meshes_cast_the_shadow_of_their_shape() {
    let mut game = ModelGame::new();
    let mut shadowed = Vec::new();
    for weight in [0.0, 0.4, 1.0] {
        let outcome = compare_stage(&mut game, &mut morphing(weight), &format!("morphed by {weight}"));
        outcome.check();
        shadowed.push(outcome.shadowed);
    }
    assert!(
        shadowed[0] + 50 < shadowed[1] && shadowed[1] + 50 < shadowed[2],
        "{shadowed:?}: the shadow grows"
    );
}

const SCENES: [(&str, usize); 3] = [("many_cubes.glb", 0), ("interior.glb", 9), ("fox.glb", 0)];

/// Share of pixels whose visibility in Bevy is not the standalone one, and the pixels. `technique` may change the light.
fn soft(
    (game, model): (&mut ModelGame, &mut ModelStage),
    case: usize,
    kind: Option<LightKind>,
    technique: impl Bundle + Clone,
) -> (f64, usize) {
    let (label, mut case) = model.cases().swap_remove(case);
    if let Some(kind) = kind {
        case.light.kind = kind;
        case.place = case.place.looking_at(model.bounds.center(), Vec3::Y);
    }
    model.set(&case, technique.clone());
    let standalone = model
        .stage
        .render()
        .expect("the frame renders")
        .visibility
        .swap_remove(0);
    let shadowed = game.show(&mut model.stage, technique.clone()).picture();
    let lit = game.set_casting(false).picture();
    let got = visibility(&shadowed, &lit);
    let name = std::any::type_name_of_val(&technique)
        .rsplit("::")
        .next()
        .unwrap_or_default();
    shadowed.save(&format!("soft_{name}_{label}"));
    let told: Vec<(f32, f32)> = got
        .iter()
        .copied()
        .zip(standalone)
        .filter(|(got, _)| !got.is_nan())
        .collect();
    // Of two roundings to 16 bits, and of a mask of 8.
    let wrong = told
        .iter()
        .filter(|(got, ours)| (got - ours).abs() > 0.006)
        .count();
    let half = told.iter().filter(|(got, _)| *got > 0.05 && *got < 0.95).count();
    println!(
        "{name} {label}: {wrong} of {} pixels unlike, {half} in penumbrae",
        told.len()
    );
    assert!(told.iter().any(|(got, _)| *got < 0.05), "nothing is shadowed");
    (wrong as f64 / told.len() as f64, told.len())
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn every_technique_shadows_bevys_lights_as_our_own() {
    let mut model = ModelStage::new(&model("many_cubes.glb"), &strict_context(), SIZE).expect("triangles");
    let mut game = ModelGame::new();
    let rect = LightKind::Rect {
        width: 2.0,
        height: 1.0,
    };
    let outcomes = [
        // The picture of our own is of the share that is seen of the whole light; what shades, here and there, of the share
        // of what is above the surface's horizon. They differ where the light sets.
        (
            0.01,
            soft((&mut game, &mut model), 0, Some(rect), PenumbraWedge::default()),
        ),
        (0.002, soft((&mut game, &mut model), 0, None, OmniMap::default())),
        (
            0.002,
            soft((&mut game, &mut model), 1, None, ShadowMap::default()),
        ),
        (
            0.002,
            soft((&mut game, &mut model), 2, None, StencilVolume::default()),
        ),
    ];
    for (limit, (wrong, pixels)) in outcomes {
        assert!(wrong < limit && pixels > 500, "{wrong} of {pixels}");
    }
}

#[test]
fn what_receives_no_shadow_is_lit() {
    let mut game = crate::harness::dark_game();
    let world = game.world();
    let camera = crate::harness::marked_camera(world, Vec3::new(0.0, 6.0, 0.1));
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let floor = meshes.add(Plane3d::default().mesh().size(3.0, 3.0));
    let lid = meshes.add(Plane3d::default().mesh().size(0.1, 0.1));
    let matte = crate::harness::matte(world);
    // Under a small lid near the light lie two floors, of which the right one shows no shadow.
    let left = world
        .spawn((
            Mesh3d(floor.clone()),
            matte.clone(),
            Transform::from_xyz(-1.5, 0.0, 0.0),
        ))
        .id();
    let right = world
        .spawn((
            Mesh3d(floor),
            matte.clone(),
            Transform::from_xyz(1.5, 0.0, 0.0),
            NotShadowReceiver,
        ))
        .id();
    world.spawn((Mesh3d(lid), matte, Transform::from_xyz(0.0, 3.9, 0.0)));
    world.spawn((
        PointLight {
            intensity: 500_000.0,
            ..default()
        },
        StencilVolume::default(),
        Transform::from_xyz(0.0, 4.0, 0.0),
    ));
    let picture = game.run(5).settled(camera);
    picture.save("not_receiver");
    let size = picture.size;
    let at = |x: u32| f32::from(picture.texels[(size.y / 2 * size.x + x) as usize][1]);
    let (shaded, lit) = (at(size.x / 2 - 8), at(size.x / 2 + 8));
    println!("left of the middle {shaded}, right of it {lit}");
    assert!(shaded == 0.0 && lit > 0.0);
    // And the other way round, once they are exchanged.
    game.world().entity_mut(right).remove::<NotShadowReceiver>();
    game.world().entity_mut(left).insert(NotShadowReceiver);
    let picture = game.run(3).settled(camera);
    let at = |x: u32| f32::from(picture.texels[(size.y / 2 * size.x + x) as usize][1]);
    assert!(at(size.x / 2 - 8) > 0.0 && at(size.x / 2 + 8) == 0.0);
}
