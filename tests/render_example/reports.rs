//! What is wrong with a shot that renders is a line on stderr, and stands in `stats.json`.

use super::*;

/// Renders a shot; the lines on stderr, and the reports of `stats.json`.
fn rendered(folder: &Path, shot: &Value) -> (Vec<String>, Value) {
    write(folder, "shot.json", &shot.to_string());
    let output = run(folder, "shot.json", "out", &[]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let text = std::fs::read_to_string(folder.join("out/stats.json")).expect("there are statistics");
    let stats: Value = serde_json::from_str(&text).expect("they are JSON");
    let lines = stderr.lines().map(str::to_owned).collect();
    (lines, stats["reports"].clone())
}

#[test]
fn a_technique_that_does_not_fit_is_said_of_its_light() {
    let folder = folder("reports");
    write_scene(&folder);
    let mut shot = design_shot();
    let (lines, reports) = rendered(&folder, &shot);
    assert_eq!((lines, reports), (Vec::new(), json!([])));
    shot["lights"][0]["shadow"] = json!({"technique": "penumbra_wedge"});
    let (lines, reports) = rendered(&folder, &shot);
    let [line] = &lines[..] else {
        panic!("one line: {lines:#?}");
    };
    assert!(line.contains("shot.json: light 0: PenumbraWedge"), "{line}");
    let report = &reports[0];
    assert_eq!(reports.as_array().map(Vec::len), Some(1), "{reports}");
    assert_eq!(report["topic"], "penumbra_wedge");
    assert_eq!(report["entity"], "light 0");
    let message = report["message"].as_str().expect("a sentence");
    assert!(
        line.ends_with(message) && message.contains("no size"),
        "{message}"
    );
}

#[test]
fn what_a_file_loses_is_said_in_a_line_each() {
    let folder = folder("import_reports");
    let scene = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {}, "mode": 0}, {"attributes": {}, "mode": 1}]}],
        "extensionsUsed": ["KHR_materials_sheen"],
        "images": [{"uri": "not_there.png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    });
    write(&folder, "lossy.gltf", &scene.to_string());
    let mut shot = design_shot();
    shot["scene"] = json!("lossy.gltf");
    shot["size"] = json!([32, 18]);
    shot["lights"] = json!([]);
    shot.as_object_mut().expect("an object").remove("animation");
    let (lines, reports) = rendered(&folder, &shot);
    let reports = reports.as_array().expect("a list");
    assert!(
        reports.iter().all(|report| report["topic"] == "import"),
        "{reports:?}"
    );
    for part in [
        "Points have no surface",
        "Lines have no surface",
        "KHR_materials_sheen is ignored",
        "not_there.png",
    ] {
        let said = |text: &str| text.contains(part) && text.contains("lossy.gltf: ");
        assert_eq!(
            lines.iter().filter(|line| said(line)).count(),
            1,
            "{part}: {lines:#?}"
        );
        let messages = reports.iter().filter_map(|report| report["message"].as_str());
        assert_eq!(
            messages.filter(|message| said(message)).count(),
            1,
            "{part}: {reports:?}"
        );
    }
    assert_eq!(reports.len(), 4);
}
