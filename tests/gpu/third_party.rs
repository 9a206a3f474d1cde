//! A technique of somebody else works from a shot file, in `stats.json` and in the gallery, and no file but its own knows it.

#![allow(dead_code, reason = "of the gallery a part is used")]

#[path = "../../examples/gallery/cost.rs"]
mod cost;
#[path = "../../examples/gallery/judge.rs"]
mod judge;
#[path = "../../examples/gallery/page.rs"]
mod page;
#[path = "../../examples/gallery/panels.rs"]
mod panels;
#[path = "../../examples/gallery/results.rs"]
mod results;
#[path = "../../examples/gallery/session.rs"]
mod session;
#[path = "../../examples/gallery/truth.rs"]
mod truth;
#[path = "../veil/mod.rs"]
mod veil;
#[path = "../../examples/gallery/way.rs"]
mod way;

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::{Settings, Techniques};
use antumbra_stage as support;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};
use serde_json::json;
use support::shot::Shot;
use support::stage::{PICTURE_FORMAT, Stage};
use support::stats;

use crate::harness::{own_context, strict_context};
use crate::occlusion_interval::companions::{visibility, with_boxes};
use veil::Veil;

fn techniques() -> Techniques {
    let mut techniques = Techniques::default();
    techniques.add_technique::<Veil>();
    techniques
}

fn shot(shadow: serde_json::Value) -> String {
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/models/bonsai_alpha_leaves.glb"
    );
    let light = json!({"kind": "point", "position": [2, 40, 2], "intensity": 2000, "shadow": shadow});
    json!({"scene": scene, "size": [64, 36], "lights": [light]}).to_string()
}

#[test]
fn it_works_from_a_shot_file_and_in_the_statistics() {
    let text = shot(json!({"technique": "veil", "seen": 0.5}));
    let shot = Shot::parse(&text, techniques()).expect("the shot is whole");
    let mut stage = Stage::of_shot(&shot).expect("the scene is there");
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    assert_eq!(PICTURE_FORMAT, wgpu::TextureFormat::Rgba8UnormSrgb);
    let rendered = stage.render().expect("the frame renders");
    let veiled = rendered.visibility[0].iter().filter(|&&v| v == 0.5).count();
    assert!(veiled > 100, "{veiled} pixels are veiled");
    assert!(rendered.visibility[0].iter().all(|&v| v == 0.5 || v == 1.0));
    let stats = stats::collect(&mut stage, &rendered);
    let light = &stats["lights"][0];
    assert_eq!(
        (&light["technique"], &light["veil"]),
        (&json!("veil"), &json!(0.5))
    );
    assert_eq!(light["shadow_batches"], json!(1));
    assert_eq!(light["casters_culled"], json!(0), "every light has the same keys");
}

#[test]
fn what_is_wrong_in_a_shot_file_is_named() {
    let refused = |shadow, techniques| Shot::parse(&shot(shadow), techniques).expect_err("it is wrong");
    for (shadow, parts) in [
        (
            json!({"technique": "veil", "seem": 0.5}),
            ["lights[0]: shadow", "seem"],
        ),
        (
            json!({"technique": "veil", "seen": "all"}),
            ["lights[0]: shadow.seen", "all"],
        ),
        (
            json!({"technique": "veil", "seen": 2}),
            ["lights[0]: shadow: seen is 2", "0 to 1"],
        ),
    ] {
        let line = refused(shadow, techniques());
        assert!(parts.iter().all(|part| line.contains(part)), "{line}");
    }
    let line = refused(json!({"technique": "veil"}), Techniques::default());
    assert!(
        line.contains("no technique is called `veil`; choose one of none, stencil_volume"),
        "{line}"
    );
}

/// It is the second technique of a light with baked shadows, and shadows by what is not in the maps.
#[test]
fn it_is_the_second_technique_of_a_light_with_baked_shadows() {
    let mut stage = with_boxes(0.4, 0.0);
    let alone = visibility(&mut stage);
    stage.shadow(stage.lights[0], &Settings::of(Veil { seen: 0.5 }));
    let both = visibility(&mut stage);
    let count = |of: f32| both.iter().filter(|&&v| v == of).count();
    assert!(
        count(0.5) > 2000 && count(0.0) > 500,
        "{} {}",
        count(0.5),
        count(0.0)
    );
    for (both, alone) in both.iter().zip(&alone) {
        let is_nothing = *both == 1.0 && *alone == 1.0;
        assert!(
            is_nothing || *both == alone.min(0.5),
            "the darker of both: {both} {alone}"
        );
    }
    stage.world.entity_mut(stage.lights[0]).remove::<Veil>();
    assert!(visibility(&mut stage) == alone);
}

#[test]
fn it_works_in_the_gallery() {
    let view = page::view([3.0, 3.0, 5.0], [0.0, 0.0, 0.0], 45.0);
    let ball = |mesh, height| page::PlacedMesh {
        mesh: Arc::new(mesh),
        material: Material::matte(Vec3::ONE),
        transform: Transform::from_xyz(0.0, height, 0.0),
    };
    // Of the list, the first and the last, which is that of the stranger.
    let mut of_list = way::ways_of(&techniques());
    of_list.drain(1..of_list.len() - 1);
    let page = page::Page {
        objects: vec![
            ball(MeshData::plane(4.0), 0.0),
            ball(MeshData::icosphere(0.5, 3), 0.8),
        ],
        lights: vec![page::NamedLight {
            name: "lamp",
            light: Light::point(Vec3::ONE, 40.0, 20.0),
            transform: Transform::from_xyz(1.0, 4.0, 1.0),
        }],
        shots: vec![page::PageShot {
            name: "ball",
            caption: "",
            camera: view,
            light: "lamp",
            exposure: 1.0,
        }],
        ways: of_list,
        ..page::Page::new("veil", "A veil", "")
    };
    let out = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("third_party");
    std::fs::create_dir_all(&out).expect("a folder");
    let context = own_context(RequestedFeatures {
        timestamps: true,
        ..Default::default()
    });
    let has_timers = context
        .device
        .features()
        .contains(wgpu::Features::TIMESTAMP_QUERY);
    let bench = judge::Workbench::on(context, UVec2::new(64, 36), 1).expect("shaders compose");
    let result = bench.judge_page(&page, &out).expect("the page is drawn");
    let shot = &result.shots[0];
    let [Ok(exact), Ok(veiled)] = &shot.ways[..] else {
        panic!("both are judged");
    };
    assert_eq!(veiled.stats["lights"][0]["technique"], json!("veil"));
    for cost in [veiled.cost.ratio(), veiled.cost.moving_ratio()] {
        assert_eq!(
            cost.is_some(),
            has_timers,
            "its cost is that of the light without it"
        );
    }
    // The picture with ray-cast visibility is that of the exact technique, but for edges; it is not that of the veil.
    let picture = |file: &str| image::open(out.join(file)).expect("a picture").into_rgb8();
    let truth = picture(shot.truth_picture.as_ref().expect("nothing is cut out"));
    let apart = |way: &results::WayResult| {
        let got = picture(&way.files[0]);
        let pixels = got.pixels().zip(truth.pixels());
        let differ = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).any(|i| a[i].abs_diff(b[i]) > 3);
        pixels.filter(differ).count()
    };
    let (exact, veiled) = (apart(exact), apart(veiled));
    assert!(
        exact < 64 * 36 / 50,
        "{exact} pixels of the exact picture differ from the truth"
    );
    assert!(
        veiled > 64 * 36 / 4,
        "{veiled} pixels of the veiled picture differ from the truth"
    );
    let json = results::json(&[(&page, result)], &techniques());
    let names = json["techniques"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|row| &row["name"]);
    assert!(names.into_iter().any(|name| name == "veil"), "the page lists it");
    assert_eq!(
        json["scenes"][0]["shots"][0]["ways"][1]["technique"],
        json!("veil")
    );
}
