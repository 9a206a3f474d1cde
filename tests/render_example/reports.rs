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
