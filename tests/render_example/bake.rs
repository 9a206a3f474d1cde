//! `examples/bake` bakes each folder of a shot once, or nothing.

use super::*;

/// A light whose maps are in a folder.
fn light(maps: &str, texels_per_metre: f32) -> Value {
    json!({
        "kind": "directional", "direction": [-1, -0.6, -0.5], "path": {"axis": [0, 0, 1], "degrees": 120},
        "shadow": {"technique": "occlusion_interval", "maps": maps, "texels_per_metre": texels_per_metre},
    })
}

/// Runs the example on a shot with two lights.
fn bake(folder: &Path, lights: [Value; 2]) -> Output {
    let shot = json!({"scene": "models/house.glb", "size": [64, 36], "lights": lights});
    write(folder, "shot.json", &shot.to_string());
    Command::new(example("bake"))
        .arg(folder.join("shot.json"))
        .output()
        .expect("the example starts")
}

#[test]
fn lights_that_want_different_maps_in_one_folder_are_found_before_anything_is_baked() {
    let folder = folder("bake");
    write_scene(&folder);
    for name in ["maps", "./maps", "missing/../maps"] {
        let output = bake(&folder, [light("maps", 1.0), light(name, 2.0)]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {stderr}");
        for part in ["shot.json", "lights[1].shadow.maps", "lights[0]"] {
            assert!(stderr.contains(part), "{name}: {part} is not in {stderr}");
        }
        assert!(output.stdout.is_empty(), "{name}");
        assert!(!folder.join("maps").exists(), "{name}: something was baked");
    }
    let output = bake(&folder, [light("maps", 1.0), light("missing/../maps", 1.0)]);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(folder.join("maps").exists(), "the lights share their maps");
    assert_eq!(
        stdout.matches("texels,").count(),
        1,
        "they are baked once: {stdout}"
    );
}
