//! Stencil shadow volumes against the ray caster, on every model, from outside and inside of shadows.

mod harness;

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};
use harness::cases::{KINDS, PLACEMENTS, case};
use harness::support::stage::Stage;
use harness::{judge, make_alpha_solid, models_below, models_folder, strict_context};

const SIZE: UVec2 = UVec2::new(160, 90);

/// Share of wrong pixels outside of the edge band that a shot may have.
const ALLOWED: f64 = 0.001;

#[test]
fn stencil_equals_ray_cast_on_every_model() {
    let Some(folder) = models_folder("stencil_equals_ray_cast_on_every_model") else {
        return;
    };
    let context = strict_context(RequestedFeatures::default());
    let mut failures = Vec::new();
    let only = std::env::var("ONLY").ok();
    for path in models_below(&folder) {
        if only.as_ref().is_some_and(|only| !path.to_string_lossy().contains(only.as_str())) {
            continue;
        }
        let mut stage = Stage::empty(SIZE, Camera::default(), Transform::IDENTITY);
        stage.world.insert_resource(FaceCulling::None);
        stage
            .add_renderer(context.clone(), RenderSettings::default())
            .expect("shaders compose");
        let loaded = load_gltf(&path).expect("the model loads");
        let spawned = spawn_scene(&mut stage.world, &loaded, None).expect("the model spawns");
        for &light in &spawned.lights {
            stage.world.entity_mut(light).remove::<Light>();
        }
        for &camera in &spawned.cameras {
            stage.world.entity_mut(camera).remove::<Camera>();
        }
        make_alpha_solid(&mut stage);
        stage.schedule.run(&mut stage.world);
        let bounds = stage.scene_bounds();
        if bounds.is_empty() {
            println!("{:<32} has no triangles", name(&path));
            continue;
        }
        let vertex = some_vertex(&mut stage);
        let radius = bounds.half_size().length().max(1e-3);
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::plane(6.0 * radius))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(bounds.center().with_y(bounds.min.y - 0.01 * radius)),
        ));
        stage.schedule.run(&mut stage.world);
        let scene = RayScene::from_world(&mut stage.world);
        let mut worst = (0.0, String::new());
        let (mut inner, mut dark) = (0, 0);
        for placement in PLACEMENTS {
            for kind in KINDS {
                let case = case(bounds, vertex, placement, kind, 16.0 / 9.0);
                let camera = stage.camera;
                stage.world.entity_mut(camera).insert((case.camera, case.view));
                let light = stage.spawn_light(case.light, case.place, Some(StencilVolume::default()));
                let rendered = stage.render().expect("the frame renders");
                let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
                inner += error.inner;
                dark += rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
                let share = error.share().unwrap_or(0.0);
                let label = format!("{placement:?} {kind}: {error:?}");
                if share > worst.0 {
                    worst = (share, label.clone());
                }
                if share > ALLOWED {
                    failures.push(format!("{}: {label}", path.display()));
                }
                stage.world.despawn(light);
                stage.lights.clear();
            }
        }
        println!(
            "{:<32} {inner:>7} judged {dark:>7} dark, worst {:.5} {}",
            name(&path),
            worst.0,
            worst.1
        );
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn name(path: &std::path::Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A vertex of the first mesh, world space.
fn some_vertex(stage: &mut Stage) -> Vec3 {
    let mut query = stage.world.query::<(&SceneMesh, &GlobalTransform)>();
    query
        .iter(&stage.world)
        .find_map(|(mesh, transform)| {
            let middle = mesh.0.positions.get(mesh.0.positions.len() / 2)?;
            Some(transform.transform_point(*middle))
        })
        .unwrap_or_default()
}
