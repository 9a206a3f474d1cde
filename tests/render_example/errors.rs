//! What the example says when it cannot render: one line that names the file and the element, and writes nothing.

use super::*;

/// Asserts that a run failed as it must: status 1, one line with all of `parts`, nothing written.
#[track_caller]
fn assert_refused(folder: &Path, what: &str, output: &Output, parts: &[&str]) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{what}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
    assert!(output.stdout.is_empty(), "{what}");
    for part in parts {
        assert!(stderr.contains(part), "{what}: {part:?} is not in {stderr:?}");
    }
    assert!(!folder.join("out").exists(), "{what}: something was written");
}

/// A change of the small shot, and what the line must name beside the shot file.
type Spoilt = (&'static str, fn(&mut Value), &'static [&'static str]);

const SPOILT: [Spoilt; 53] = [
    (
        "a barn map without barn doors",
        |s| s["lights"][1]["barn_map"] = json!({}),
        &["lights[1]", "barn_map", "shape"],
    ),
    (
        "a light for a layer that the scene has not",
        |s| s["lights"][1]["affects"] = json!(["nobody"]),
        &["lights[1].affects", "nobody"],
    ),
    (
        "a blurred ground that the scene has not",
        |s| s["blurred_grounds"] = json!([{"node": "nobody", "radius": 0.2}]),
        &["blurred_grounds[0]", "nobody"],
    ),
    (
        "no scene",
        |s| drop(s.as_object_mut().map(|s| s.remove("scene"))),
        &["scene"],
    ),
    (
        "a shadow darker than dark",
        |s| s["lights"][1]["shadow_darkness"] = json!(2),
        &["lights[1]", "shadow_darkness", "0 to 1"],
    ),
    (
        "a weight below 0",
        |s| s["lights"][1]["weights"] = json!({"diffuse": -1}),
        &["lights[1]", "weights.diffuse", "at least 0"],
    ),
    (
        "a direction of shadows for a light with a place",
        |s| s["lights"][0]["shadow_direction"] = json!([0, -1, 0]),
        &["lights[0]", "shadow_direction", "position"],
    ),
    (
        "a softness of a filter that has none",
        |s| {
            s["lights"][0]["shadow"] =
                json!({"technique": "omni_map", "filter": "bilinear", "softness": 0.02})
        },
        &["lights[0]", "shadow.softness", "`bilinear`", "jittered"],
    ),
    ("unknown key", |s| s["fog"] = json!(1), &["fog"]),
    (
        "unknown camera key",
        |s| s["camera"]["roll"] = json!(1),
        &["camera", "roll"],
    ),
    (
        "unknown light kind",
        |s| s["lights"][1]["kind"] = json!("laser"),
        &["lights[1]", "laser"],
    ),
    (
        "unknown light key",
        |s| s["lights"][0]["colour"] = json!([1, 1, 1]),
        &["lights[0]", "colour"],
    ),
    (
        "unknown technique",
        |s| s["lights"][0]["shadow"]["technique"] = json!("magic"),
        &["lights[0]", "magic"],
    ),
    (
        "unknown setting of a technique",
        |s| s["lights"][0]["shadow"]["bias"] = json!(0.1),
        &["lights[0]", "bias"],
    ),
    (
        "unknown value of a setting",
        |s| s["lights"][3]["shadow"]["counting"] = json!("fast"),
        &["lights[3]", "fast"],
    ),
    (
        "no part of a split light",
        |s| s["lights"][3]["shadow"] = json!({"technique": "penumbra_wedge", "split": [2, 0]}),
        &["lights[3]", "split"],
    ),
    (
        "unknown silhouette",
        |s| s["lights"][3]["shadow"] = json!({"technique": "penumbra_wedge", "silhouette": "mine"}),
        &["lights[3]", "mine"],
    ),
    (
        "unknown overlap",
        |s| s["lights"][3]["shadow"] = json!({"technique": "penumbra_wedge", "overlap": "most"}),
        &["lights[3]", "most"],
    ),
    (
        "unknown buffer",
        |s| s["lights"][3]["shadow"] = json!({"technique": "penumbra_wedge", "buffer": "f64"}),
        &["lights[3]", "f64"],
    ),
    (
        "a picture on a light without wedges",
        |s| s["lights"][3]["texture"] = json!("window.png"),
        &["lights[3]", "texture"],
    ),
    (
        "a picture that is not there",
        |s| {
            s["lights"][3]["shadow"] = json!({"technique": "penumbra_wedge"});
            s["lights"][3]["texture"] = json!("window.png");
        },
        &["lights[3].texture", "window.png"],
    ),
    (
        "a cookie that is not there",
        |s| s["lights"][1]["cookie"] = json!({"path": "nowhere.png"}),
        &["lights[1].cookie.path", "nowhere.png"],
    ),
    (
        "an unknown key of a cookie",
        |s| s["lights"][1]["cookie"] = json!({"path": "window.png", "blur": 1}),
        &["lights[1]", "cookie", "blur"],
    ),
    (
        "a cookie too dense",
        |s| s["lights"][1]["cookie"] = json!({"path": "window.png", "density": 1.5}),
        &["lights[1]", "cookie", "1.5"],
    ),
    (
        "a cookie without size",
        |s| s["lights"][2]["cookie"] = json!({"path": "window.png", "size": 0}),
        &["lights[2]", "cookie", "size"],
    ),
    (
        "a profile of a directional light",
        |s| s["lights"][2]["profile"] = json!("lamp.ies"),
        &["lights[2]", "profile"],
    ),
    (
        "a profile in no known format",
        |s| s["lights"][0]["profile"] = json!("lamp.txt"),
        &["lights[0].profile", "lamp.txt", ".ies"],
    ),
    ("size 0", |s| s["size"] = json!([0, 36]), &["size"]),
    ("negative size", |s| s["size"] = json!([-4, 36]), &["size"]),
    ("three sizes", |s| s["size"] = json!([4, 36, 1]), &["size"]),
    (
        "size beyond the device",
        |s| s["size"] = json!([4, 1_000_000]),
        &["size", "1000000", "device"],
    ),
    (
        "a near plane that is no distance",
        |s| s["camera"]["near"] = json!(1e-30),
        &["camera.near", "1e-30"],
    ),
    (
        "an eye beyond all scenes",
        |s| s["camera"]["eye"][0] = json!(1e30),
        &["camera: eye", "1e30"],
    ),
    (
        "a target beyond all scenes",
        |s| s["camera"]["target"][1] = json!(-1e30),
        &["camera: target", "1e30"],
    ),
    (
        "a light beyond all scenes",
        |s| s["lights"][0]["position"][2] = json!(1e30),
        &["lights[0]: position", "1e30"],
    ),
    (
        "an angle of the light and another of its shadow",
        |s| {
            s["lights"][2]["angle_deg"] = json!(0.5);
            s["lights"][2]["shadow"] = json!({"technique": "occlusion_texture", "angle_deg": 2});
        },
        &["lights[2]: angle_deg", "both"],
    ),
    (
        "an angle of a light without a shadow",
        |s| {
            let light = s["lights"][2].as_object_mut().expect("a light");
            light.remove("shadow");
            light.insert("angle_deg".into(), json!(0.5));
        },
        &["lights[2]: angle_deg", "no shadow"],
    ),
    (
        "up along a long direction",
        |s| {
            s["lights"][3]["direction"] = json!([0, -1e30, 0]);
            s["lights"][3]["up"] = json!([0, 1e-30, 0]);
        },
        &["lights[3]: up", "direction"],
    ),
    (
        "negative ambient",
        |s| s["ambient"][1] = json!(-0.5),
        &["ambient", "-0.5"],
    ),
    (
        "infinite ambient",
        |s| s["ambient"][1] = json!(1e60),
        &["ambient"],
    ),
    (
        "eye at the target",
        |s| s["camera"]["eye"] = json!([0, 0, 0]),
        &["camera", "target - eye"],
    ),
    (
        "up along the view",
        |s| s["camera"]["up"] = json!([3, 3, 5]),
        &["camera", "up"],
    ),
    (
        "field of view 180",
        |s| s["camera"]["vfov_deg"] = json!(180),
        &["camera", "vfov_deg"],
    ),
    (
        "far before near",
        |s| s["camera"]["orthographic"] = json!({"height": 4, "far": 0.05}),
        &["camera", "far 0.05"],
    ),
    ("near 0", |s| s["camera"]["near"] = json!(0), &["camera", "near"]),
    (
        "infinite eye",
        |s| s["camera"]["eye"][0] = json!(1e60),
        &["camera"],
    ),
    (
        "text for a number",
        |s| s["lights"][0]["intensity"] = json!("bright"),
        &["lights[0]", "bright"],
    ),
    (
        "negative intensity",
        |s| s["lights"][0]["intensity"] = json!(-1),
        &["lights[0]", "intensity"],
    ),
    (
        "range 0",
        |s| s["lights"][0]["range"] = json!(0),
        &["lights[0]", "range"],
    ),
    (
        "crossed cones",
        |s| s["lights"][1]["inner_deg"] = json!(40),
        &["lights[1]", "40.00° inside and 30.00° outside"],
    ),
    (
        "no direction",
        |s| s["lights"][2]["direction"] = json!([0, 0, 0]),
        &["lights[2]", "direction"],
    ),
    (
        "negative radius",
        |s| s["lights"][4]["radius"] = json!(-1),
        &["lights[4]", "size"],
    ),
    (
        "no such clip",
        |s| s["animation"]["clip"] = json!(7),
        &["animation.clip 7"],
    ),
];

#[test]
fn spoilt_shots_are_refused_with_one_line() {
    let folder = folder("spoilt");
    write_scene(&folder);
    for (what, spoil, parts) in SPOILT {
        let mut shot = small_shot();
        spoil(&mut shot);
        write(&folder, "spoilt.json", &shot.to_string());
        let output = run(&folder, "spoilt.json", "out", &[]);
        // The clip is one of the scene's, and named with its file.
        let file = if what == "no such clip" {
            "house.glb"
        } else {
            "spoilt.json"
        };
        assert_refused(&folder, what, &output, &[&[file], parts].concat());
    }
}

#[test]
fn a_whole_shot_with_directions_of_any_length_is_not_refused() {
    let folder = folder("whole");
    write_scene(&folder);
    let mut shot = small_shot();
    for (light, length) in [(1, 1e30), (2, 1e-30)] {
        for axis in 0..3 {
            let of_shot = shot["lights"][light]["direction"][axis].as_f64();
            shot["lights"][light]["direction"][axis] = json!(of_shot.expect("a direction") * length);
        }
    }
    write(&folder, "shot.json", &shot.to_string());
    assert!(run(&folder, "shot.json", "out", &[]).status.success());
    assert!(folder.join("out/image.png").exists());
}

#[test]
fn files_that_are_missing_or_cut_short_are_named() {
    let folder = folder("files");
    write_scene(&folder);
    let output = run(&folder, "none.json", "out", &[]);
    assert_refused(&folder, "missing shot", &output, &["none.json"]);

    let text = small_shot().to_string();
    for (what, text) in [
        ("empty", ""),
        ("cut short", &text[..text.len() / 2]),
        ("followed by more", &format!("{text} {{}}")),
        ("not JSON", "scene: house"),
    ] {
        write(&folder, "bad.json", text);
        let output = run(&folder, "bad.json", "out", &[]);
        assert_refused(&folder, what, &output, &["bad.json"]);
    }

    let model = std::fs::read(folder.join("models/house.glb")).expect("the scene");
    let with_scene = |name: &str| {
        let mut shot = small_shot();
        shot["scene"] = json!(format!("models/{name}"));
        write(&folder, "shot.json", &shot.to_string());
        run(&folder, "shot.json", "out", &[])
    };
    assert_refused(&folder, "missing model", &with_scene("none.glb"), &["none.glb"]);
    for length in [0, 3, 11, 40, model.len() / 2, model.len() - 1] {
        std::fs::write(folder.join("models/cut.glb"), &model[..length]).expect("a cut model");
        assert_refused(
            &folder,
            &format!("{length} bytes of a model"),
            &with_scene("cut.glb"),
            &["cut.glb"],
        );
    }
}

#[test]
fn an_out_that_is_a_file_is_named() {
    let folder = folder("out");
    write_scene(&folder);
    write(&folder, "shot.json", &small_shot().to_string());
    write(&folder, "taken", "a file");
    let output = run(&folder, "shot.json", "taken", &[]);
    assert_refused(&folder, "out is a file", &output, &["taken"]);
    let kept = std::fs::read_to_string(folder.join("taken")).expect("it is still there");
    assert_eq!(kept, "a file");
}

#[test]
fn without_an_adapter_the_line_says_so() {
    let folder = folder("adapter");
    write_scene(&folder);
    write(&folder, "shot.json", &small_shot().to_string());
    let nowhere = [
        ("WGPU_BACKEND", "vulkan"),
        ("VK_ICD_FILENAMES", "/nonexistent"),
        ("VK_DRIVER_FILES", "/nonexistent"),
    ];
    let output = run(&folder, "shot.json", "out", &nowhere);
    let parts = [
        "shot.json",
        "no GPU adapter",
        "apt-get install libvulkan1 mesa-vulkan-drivers",
    ];
    assert_refused(&folder, "no adapter", &output, &parts);
    let unknown = [("WGPU_ADAPTER_NAME", "Voodoo 2")];
    let output = run(&folder, "shot.json", "out", &unknown);
    let parts = ["shot.json", "Voodoo 2", "WGPU_ADAPTER_NAME", "there are: "];
    assert_refused(&folder, "unknown adapter", &output, &parts);
}

#[test]
fn a_broken_profile_is_named_with_its_line() {
    let folder = folder("broken_profile");
    write_scene(&folder);
    write(
        &folder,
        "lamps/lamp.ies",
        "IESNA91\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5 ?\n",
    );
    let mut shot = small_shot();
    shot["lights"][0]["profile"] = json!("lamps/lamp.ies");
    write(&folder, "shot.json", &shot.to_string());
    let output = run(&folder, "shot.json", "out", &[]);
    let parts = ["shot.json", "lights[0].profile", "lamp.ies: line 7", "\"?\""];
    assert_refused(&folder, "a broken profile", &output, &parts);
}

/// A full disk takes small files into buffers that are lost when they are dropped.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_for_every_file() {
    for name in ["image.png", "image.exr", "light0.visibility.exr"] {
        let folder = folder(&format!("full_{name}"));
        write_scene(&folder);
        let mut shot = small_shot();
        shot["size"] = json!([16, 9]);
        write(&folder, "shot.json", &shot.to_string());
        std::fs::create_dir(folder.join("out")).expect("a folder for the results");
        std::os::unix::fs::symlink("/dev/full", folder.join("out").join(name)).expect("a link");
        let output = run(&folder, "shot.json", "out", &[]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {stderr}");
        assert!(stderr.contains(name), "{stderr}");
    }
}
