//! Shot files with paths and maps.

use std::path::Path;

use antumbra::baking::{BakeSettings, bake_into};
use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use bevy_transform::prelude::Transform;
use glam::Vec3;
use serde_json::{Value, json};

use crate::harness::strict_context;
use crate::harness::support::shot::Shot;
use crate::harness::support::stage::Stage;
use crate::harness::support::stats;

fn shot(light: Value) -> Value {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models");
    json!({"scene": models.join("suzanne.glb"), "size": [64, 36], "lights": [light]})
}

fn arc() -> Value {
    json!({
        "kind": "directional", "direction": [-1, -0.6, -0.5], "path": {"axis": [0, 0, 1], "degrees": 120},
        "shadow": {"technique": "occlusion_interval", "maps": "maps", "texels_per_metre": 4, "time": 0.4, "width": 0.02},
    })
}

#[test]
fn keys_that_cannot_be_used_are_named() {
    let refused = |change: &dyn Fn(&mut Value), part: &str| {
        let mut light = arc();
        change(&mut light);
        let refused = Shot::parse(&shot(light).to_string(), Techniques::default());
        let line = refused.expect_err(part);
        assert!(line.contains("lights") && line.contains(part), "{part}: {line}");
    };
    assert!(Shot::parse(&shot(arc()).to_string(), Techniques::default()).is_ok());
    refused(
        &|light| light["path"] = json!({"axis": [0, 0, 0], "degrees": 90}),
        "path.axis",
    );
    refused(
        &|light| light["path"]["degrees"] = json!(400),
        "path.degrees is 400",
    );
    refused(&|light| light["path"]["speed"] = json!(1), "speed");
    refused(&|light| light["path"] = json!({}), "path: needs axis and degrees");
    refused(
        &|light| light["path"] = json!({"latitude_deg": 91, "day": 1}),
        "path.latitude_deg is 91",
    );
    refused(
        &|light| light["path"] = json!({"positions": [[0, 0, 0], [1, 0, 0]]}),
        "path: positions",
    );
    refused(
        &|light| drop(light.as_object_mut().map(|light| light.remove("path"))),
        "path: occlusion_interval",
    );
    refused(
        &|light| light["shadow"] = json!({"technique": "stencil_volume"}),
        "path: needs the technique",
    );
    refused(&|light| light["shadow"]["width"] = json!(2), "width is 2");
    for time in [-0.1, 1.5] {
        let part = format!("time is {time}");
        refused(&|light| light["shadow"]["time"] = json!(time), &part);
    }
    for density in [1e-9, 1e9] {
        refused(
            &|light| light["shadow"]["texels_per_metre"] = json!(density),
            "texels_per_metre is",
        );
    }
    refused(
        &|light| light["shadow"]["texels_per_metre"] = json!(0),
        "texels_per_metre is 0",
    );
    refused(&|light| light["shadow"]["maps"] = json!(""), "maps is not given");
    refused(&|light| light["shadow"]["texels"] = json!(8), "texels");
    // The second technique.
    for (moving, part) in [
        (
            json!("shadow_map"),
            "shadow.moving: \"shadow_map\" must be an object",
        ),
        (
            json!({"technique": "shadow"}),
            "shadow.moving.technique: no technique is called `shadow`",
        ),
        (
            json!({"technique": "stencil_volume", "slices": 3}),
            "shadow.moving.slices: unknown field `slices`",
        ),
        (json!({"technique": "omni_map"}), "shadow.moving: "),
        (
            json!({"technique": "occlusion_interval", "maps": "maps"}),
            "shadow.moving.technique: occlusion_interval cannot be the second",
        ),
    ] {
        refused(&|light| light["shadow"]["moving"] = moving.clone(), part);
    }
    refused(
        &|light| {
            let shadow = json!({"technique": "stencil_volume", "moving": {"technique": "shadow_map"}});
            light["shadow"] = shadow;
            light.as_object_mut().map(|light| light.remove("path"));
        },
        "unknown field `moving`",
    );
}

#[test]
fn suns_need_no_direction_and_polylines_no_position() {
    let sun = json!({
        "kind": "directional", "path": {"latitude_deg": 50, "day": 172},
        "shadow": {"technique": "occlusion_interval", "maps": "maps"},
    });
    let line = json!({
        "kind": "point", "path": {"positions": [[0, 2, 0], [4, 2, 0]]},
        "shadow": {"technique": "occlusion_interval", "maps": "maps"},
    });
    for light in [sun, line] {
        let shot = Shot::parse(&shot(light).to_string(), Techniques::default()).expect("it is whole");
        let lights = shot.lights.as_ref().expect("its lights");
        let parts = lights[0].parts(&shot.techniques).expect("its parts");
        assert!(parts.path.is_some());
    }
}

#[test]
fn a_shot_is_baked_beside_its_file_and_drawn_from_there() {
    let folder = std::env::temp_dir().join(format!("antumbra-{}-shot", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("shot.json");
    std::fs::write(&file, shot(arc()).to_string()).expect("it is written");
    let shot = Shot::load(&file, Techniques::default()).expect("the shot");
    let mut stage = Stage::of_shot(&shot).expect("the scene");
    stage.world.insert_resource(FaceCulling::None);
    let missing = stage.load_files().expect_err("there are no maps");
    assert!(
        missing.contains("lights[0].shadow.maps") && missing.contains("maps.json"),
        "{missing}"
    );
    stage.schedule.run(&mut stage.world);
    let light = stage.lights[0];
    let settings = stage
        .world
        .get::<OcclusionInterval>(light)
        .expect("the technique")
        .clone();
    let path = stage.world.get::<LightPath>(light).expect("the path").clone();
    assert_eq!(Path::new(&settings.maps), folder.join("maps"));
    let bake_settings = BakeSettings {
        texels_per_metre: settings.texels_per_metre,
        ..Default::default()
    };
    let maps = folder.join("maps");
    bake_into(&maps, &mut stage.world, &path, &bake_settings, |_| ()).expect("it is baked");

    let mut stage = Stage::of_shot(&shot).expect("the scene");
    stage.world.insert_resource(FaceCulling::None);
    stage.load_files().expect("the maps are there");
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let rendered = stage.render().expect("the frame renders");
    let dark = rendered.visibility[0].iter().filter(|&&v| v < 0.5).count();
    assert!(dark > 20, "{dark} pixels are in shadow");
    // With a second technique, what is put into the scene later casts.
    let mut light = arc();
    light["shadow"]["moving"] = json!({"technique": "stencil_volume"});
    std::fs::write(&file, self::shot(light).to_string()).expect("it is written");
    let moving = Shot::load(&file, Techniques::default()).expect("the shot");
    let mut moved = Stage::of_shot(&moving).expect("the scene");
    moved.world.insert_resource(FaceCulling::None);
    moved
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let mut drawn = moved.render().expect("the frame renders");
    assert!(drawn.visibility == rendered.visibility, "nothing moves yet");
    let stats = stats::collect(&mut moved, &drawn);
    assert_eq!(stats["lights"][0]["moving"]["on_known"]["S"], json!(0));
    assert_eq!(stats["lights"].as_array().map(Vec::len), Some(1));
    super::scenes::spawn(
        &mut moved.world,
        MeshData::cuboid(Vec3::new(1.0, 0.05, 1.0)),
        Transform::from_xyz(0.4, 1.4, 0.3),
    );
    drawn = moved.render().expect("the frame renders");
    let more = drawn.visibility[0].iter().filter(|&&v| v < 0.5).count();
    println!("{dark} pixels are in shadow, {more} with a plate that is not in the maps");
    assert!(more > dark + 100, "{more} after {dark}");
    let stats = stats::collect(&mut moved, &drawn);
    let light = &stats["lights"][0];
    assert_eq!(light["technique"], json!("occlusion_interval"));
    let parts = &light["moving"];
    assert_eq!(
        (&parts["on_known"]["technique"], &parts["on_known"]["S"]),
        (&json!("stencil_volume"), &json!(1))
    );
    assert!(parts["on_others"]["I"].is_u64(), "{light:#}");
    assert_eq!(stats["reports"], json!([]));
    let picture = maps.join("page0.pair0.rise.png");
    let bytes = std::fs::read(&picture).expect("a page");
    std::fs::write(&picture, &bytes[..bytes.len() / 2]).expect("it is cut");
    let cut = stage.load_files().expect_err("the page is cut");
    assert!(cut.contains("page0.pair0.rise.png"), "{cut}");
    std::fs::remove_dir_all(&folder).expect("it is removed");
}
