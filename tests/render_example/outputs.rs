//! What the example writes.

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

use super::*;

/// Names and samples of the channels of an EXR file, and its size.
fn channels(path: &Path) -> (Vec<(String, Vec<f32>)>, [usize; 2]) {
    let image =
        read_first_flat_layer_from_file(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let layer = image.layer_data;
    let size = [layer.size.x(), layer.size.y()];
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let samples: Vec<f32> = match channel.sample_data {
            FlatSamples::F32(samples) => samples,
            FlatSamples::F16(samples) => samples.into_iter().map(f32::from).collect(),
            FlatSamples::U32(_) => panic!("{}: integers", path.display()),
        };
        (channel.name.to_string(), samples)
    });
    (channels.collect(), size)
}

/// Renders a shot and gives its `stats.json`.
fn rendered(folder: &Path, shot: &Value) -> Value {
    write(folder, "shot.json", &shot.to_string());
    let output = run(folder, "shot.json", "out", &[]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.is_empty(), "a shot that renders is silent: {stderr}");
    let text = std::fs::read_to_string(folder.join("out/stats.json")).expect("there are statistics");
    serde_json::from_str(&text).expect("they are JSON")
}

fn is_count(value: &Value) -> bool {
    value.as_u64().is_some()
}

#[test]
fn wedges_take_their_settings_and_a_picture() {
    let folder = folder("wedges");
    write_scene(&folder);
    image::RgbImage::from_fn(4, 4, |x, _| image::Rgb([255, 40 * x as u8, 0]))
        .save(folder.join("window.png"))
        .expect("a writable folder");
    let mut shot = design_shot();
    shot["lights"][3]["texture"] = json!("window.png");
    shot["lights"][3]["shadow"] =
        json!({"technique": "penumbra_wedge", "split": [2, 2], "overlap": "paper", "buffer": "split8"});
    shot["lights"][4]["shadow"] =
        json!({"technique": "penumbra_wedge", "silhouette": "center", "buffer": "split8"});
    let stats = rendered(&folder, &shot);
    for light in [3, 4] {
        assert_eq!(stats["lights"][light]["technique"], "penumbra_wedge");
        let (mask, _) = channels(&folder.join("out").join(format!("light{light}.visibility.exr")));
        let samples = &mask[0].1;
        assert!(samples.iter().all(|x| (0.0..=1.0).contains(x)), "light {light}");
        let partly = samples.iter().filter(|x| **x > 0.05 && **x < 0.95).count();
        assert!(partly > 200, "light {light}: {partly} in the penumbra");
    }
}

#[test]
fn the_shot_of_the_design_renders() {
    let folder = folder("design");
    write_scene(&folder);
    let stats = rendered(&folder, &design_shot());
    let out = folder.join("out");

    let mut files: Vec<String> = std::fs::read_dir(&out)
        .expect("the results")
        .map(|entry| entry.expect("a file").file_name().to_string_lossy().into_owned())
        .collect();
    files.sort();
    let masks = (0..5).map(|light| format!("light{light}.visibility.exr"));
    let mut expected: Vec<String> = masks.collect();
    expected.extend(["image.exr", "image.png", "stats.json"].map(str::to_owned));
    expected.sort();
    assert_eq!(files, expected);

    let (image, size) = channels(&out.join("image.exr"));
    assert_eq!(size, [640, 360]);
    assert_eq!(
        image.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["B", "G", "R"]
    );
    assert!(
        image
            .iter()
            .all(|(_, samples)| samples.iter().all(|x| x.is_finite() && *x >= 0.0))
    );
    let png = image::open(out.join("image.png")).expect("a picture");
    assert_eq!([png.width(), png.height()], [640, 360]);

    for light in 0..5 {
        let (mask, size) = channels(&out.join(format!("light{light}.visibility.exr")));
        assert_eq!(size, [640, 360]);
        let [(name, samples)] = &mask[..] else {
            panic!("light {light}: {} channels", mask.len());
        };
        assert_eq!((name.as_str(), samples.len()), ("Y", 640 * 360));
        assert!(samples.iter().all(|x| (0.0..=1.0).contains(x)), "light {light}");
        let dark = samples.iter().filter(|x| **x == 0.0).count();
        // Those without a shadow are unshadowed.
        assert_eq!(dark > 500, light == 0 || light == 3, "light {light}: {dark} dark");
    }
    check_stats(&stats);
}

/// Every field that DESIGN.md §6 lists.
fn check_stats(stats: &Value) {
    assert!(stats["adapter"].as_str().is_some_and(|name| !name.is_empty()));
    assert_eq!(stats["objects"], 2);
    assert_eq!(stats["triangles"], 14);
    assert_eq!(stats["F"], 2);
    assert_eq!(stats["V"], 2);
    let lights = stats["lights"].as_array().expect("a list");
    assert_eq!(lights.len(), 5);
    for (index, light) in lights.iter().enumerate() {
        for field in ["L", "I", "S"] {
            assert_eq!(light[field], 2, "light {index}: {field}");
        }
        let scissor = light["scissor"].as_array().expect("a rectangle");
        assert!(
            scissor.len() == 4 && scissor.iter().all(is_count),
            "light {index}"
        );
        let (near, far) = (&light["depth_bounds"]["near"], &light["depth_bounds"]["far"]);
        assert!(near.as_f64() < far.as_f64(), "light {index}: {near} {far}");
        for field in [
            "silhouette_edges",
            "silhouette_loops",
            "casters_depth_pass",
            "casters_depth_fail",
        ] {
            assert!(is_count(&light[field]), "light {index}: {field}");
        }
        assert!(light["light_batches"].as_u64() >= Some(1), "light {index}");
        let shadowed = index == 0 || index == 3;
        assert_eq!(
            light["technique"],
            if shadowed { "stencil_volume" } else { "none" }
        );
        assert_eq!(
            light["shadow_batches"].as_u64() > Some(0),
            shadowed,
            "light {index}"
        );
        assert_eq!(
            light["silhouette_edges"].as_u64() > Some(0),
            shadowed,
            "light {index}"
        );
        assert_eq!(
            light["silhouette_loops"].as_u64() > Some(0),
            shadowed,
            "light {index}"
        );
    }
    assert_eq!(lights[3]["casters_depth_pass"], 0, "counting is depth_fail");
    let batches = &stats["batches"];
    let sum: u64 = ["ambient", "shadow", "light", "blended"]
        .iter()
        .map(|part| batches[part].as_u64().expect("a count"))
        .sum();
    assert_eq!(batches["frame"], sum);
    for set in antumbra::schedule::AntumbraSystems::ALL {
        assert!(
            stats["cpu_ms"][set.name()].as_f64() >= Some(0.0),
            "{}",
            set.name()
        );
    }
    let passes = stats["gpu_ms"].as_object().expect("GPU times by pass");
    for pass in ["ambient", "light 0", "light 4", "tonemap"] {
        assert!(passes.contains_key(pass), "{pass} is not in {passes:?}");
    }
}

#[test]
fn image_exr_is_linear_and_image_png_is_not() {
    let folder = folder("linear");
    write_scene(&folder);
    let mut shot = small_shot();
    shot["lights"] = json!([]);
    let mut ambient = |radiance: f32| {
        shot["ambient"] = json!([radiance, radiance, radiance]);
        let stats = rendered(&folder, &shot);
        assert_eq!(stats["lights"], json!([]));
        let (image, _) = channels(&folder.join("out/image.exr"));
        let brightest = image[0].1.iter().copied().fold(0.0, f32::max);
        let png = image::open(folder.join("out/image.png"))
            .expect("a picture")
            .to_rgb8();
        (brightest, png.pixels().map(|pixel| pixel.0[0]).max().unwrap_or(0))
    };
    // A surface of half reflects half of what arrives from everywhere; half floats have 11 bits.
    let (quarter, quarter_png) = ambient(0.25);
    let (half, half_png) = ambient(0.5);
    assert!((quarter - 0.125).abs() < 1e-3, "{quarter}");
    assert!((half - 0.25).abs() < 1e-3, "{half}");
    // The tonemap takes 0.04 off, then sRGB: 0.085 → 0.324, 0.21 → 0.496.
    assert!(
        quarter_png.abs_diff(83) <= 2 && half_png.abs_diff(126) <= 2,
        "{quarter_png} {half_png}"
    );
}

#[test]
fn animation_poses_the_scene() {
    let folder = folder("animation");
    write_scene(&folder);
    let shot_at = |time: f32| {
        let mut shot = small_shot();
        shot["animation"]["time"] = json!(time);
        rendered(&folder, &shot);
        channels(&folder.join("out/light0.visibility.exr")).0
    };
    let (start, end) = (shot_at(0.0), shot_at(2.0));
    assert_ne!(start, end);
    let mut still = small_shot();
    still.as_object_mut().expect("an object").remove("animation");
    rendered(&folder, &still);
    assert_eq!(channels(&folder.join("out/light0.visibility.exr")).0, start);
    // Halfway through the clip, the box is where a scene without a clip has it at that height.
    let halfway = shot_at(1.0);
    write_house(&folder, "raised", 1.2);
    still["scene"] = json!("models/raised.glb");
    rendered(&folder, &still);
    let raised = channels(&folder.join("out/light0.visibility.exr")).0;
    let differing = |other: &[(String, Vec<f32>)]| {
        let pairs = raised[0].1.iter().zip(&other[0].1);
        pairs.filter(|(a, b)| a != b).count()
    };
    assert!(differing(&halfway) <= 2, "{}", differing(&halfway));
    assert!(differing(&start) > 20, "{}", differing(&start));
}

#[test]
fn without_camera_and_lights_those_of_the_scene_serve() {
    let folder = folder("defaults");
    write_scene(&folder);
    let stats = rendered(&folder, &json!({"scene": "models/house.glb"}));
    assert_eq!(stats["size"], json!([640, 360]));
    let lights = stats["lights"].as_array().expect("a list");
    assert_eq!(lights.len(), 1);
    assert_eq!(lights[0]["technique"], "stencil_volume");
    let (mask, _) = channels(&folder.join("out/light0.visibility.exr"));
    assert!(mask[0].1.contains(&0.0), "the scene's light casts");
    // The same picture as with the scene's camera written out.
    let own = channels(&folder.join("out/image.exr"));
    let mut camera = json!({"eye": [0, 1, 6], "target": [0, 1, 0], "near": 0.1});
    camera["vfov_deg"] = json!(0.8_f32.to_degrees());
    rendered(&folder, &json!({"scene": "models/house.glb", "camera": camera}));
    let written_out = channels(&folder.join("out/image.exr"));
    let differing = (0..3)
        .flat_map(|channel| own.0[channel].1.iter().zip(&written_out.0[channel].1))
        .filter(|(a, b)| (*a - *b).abs() > 0.01)
        .count();
    // The angle goes to degrees and back: a pixel at an edge may change sides.
    assert!(differing < 100, "{differing} values differ");
}

#[test]
fn cookies_and_profiles_scale_their_lights() {
    let folder = folder("textures");
    write_scene(&folder);
    image::RgbImage::from_pixel(4, 2, image::Rgb([188, 0, 255]))
        .save(folder.join("violet.png"))
        .expect("a picture");
    let profile = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 1\n0 180\n0\n100 100\n";
    write(&folder, "even.ies", profile);
    let mut shot = small_shot();
    shot["ambient"] = json!([0, 0, 0]);
    shot["lights"] = json!([shot["lights"][0]]);
    rendered(&folder, &shot);
    let (plain, _) = channels(&folder.join("out/image.exr"));
    let light = &mut shot["lights"][0];
    light["cookie"] = json!({"path": "violet.png", "turn_deg": 30, "offset": [1, 0], "density": 1});
    light["profile"] = json!("even.ies");
    rendered(&folder, &shot);
    let (scaled, _) = channels(&folder.join("out/image.exr"));
    for ((name, plain), (_, scaled)) in plain.iter().zip(&scaled) {
        let share = match name.as_str() {
            "R" => 0.502_886_5,
            "G" => 0.0,
            _ => 1.0,
        };
        for (plain, scaled) in plain.iter().zip(scaled) {
            assert!(
                (scaled - plain * share).abs() <= plain * share / 500.0,
                "{name}: {scaled} of {plain}"
            );
        }
    }
}

#[test]
fn a_picture_is_compared_before_it_is_replaced() {
    let folder = folder("against");
    write_scene(&folder);
    let mut shot = small_shot();
    let against = |shot: &Value, other: &str| {
        write(&folder, "shot.json", &shot.to_string());
        let output = Command::new(example("render"))
            .arg(folder.join("shot.json"))
            .arg("--out")
            .arg(folder.join("out"))
            .arg("--against")
            .arg(folder.join(other))
            .env("XDG_RUNTIME_DIR", &folder)
            .output()
            .expect("the example starts");
        (
            output.status.success(),
            String::from_utf8_lossy(&output.stdout).into_owned(),
        )
    };
    rendered(&folder, &shot);
    let (_, same) = against(&shot, "out");
    assert!(same.contains(" 0 of "), "{same}");
    shot["ambient"] = json!([1, 1, 1]);
    let (_, other) = against(&shot, "out");
    assert!(other.contains(" of ") && !other.contains(" 0 of "), "{other}");
    // Without a picture to compare with, nothing is written.
    std::fs::remove_dir_all(folder.join("out")).expect("the folder goes");
    assert!(!against(&shot, "nowhere").0);
    assert!(!folder.join("out").exists());
}

#[test]
fn a_panel_under_the_ceiling_needs_no_direction_of_its_height() {
    let folder = folder("panel");
    write_scene(&folder);
    let mut shot = small_shot();
    let panel = |direction: [f32; 3]| {
        json!([{"kind": "rect", "position": [0.2, 3, 0.1], "direction": direction, "width": 1, "height": 0.5,
            "shadow": {"technique": "stencil_volume"}}])
    };
    shot["lights"] = panel([0.0, -1.0, 0.0]);
    rendered(&folder, &shot);
    let down = channels(&folder.join("out/image.exr")).0;
    let lit = down[0].1.iter().filter(|radiance| **radiance > 0.1).count();
    assert!(lit > 100, "{lit}");
    shot["lights"] = panel([0.0, 1.0, 0.0]);
    rendered(&folder, &shot);
    assert_ne!(channels(&folder.join("out/image.exr")).0, down);
}
