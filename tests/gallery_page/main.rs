//! The page of the gallery works in a browser: its pictures load, it sorts, its large view opens, wipes, zooms and closes,
//! by pointer and by keyboard, in a wide window and on a phone, and nothing is logged as an error.
//!
//! `scripts/ensure-chromium.sh` installs the browser. Pictures of the page are left in
//! `target/tmp/gallery_page/`.

mod browser;
#[path = "../built_example/mod.rs"]
mod built_example;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use browser::Browser;
use serde_json::{Value, json};

const DESK: (u32, u32) = (1440, 900);
const PHONE: (u32, u32) = (360, 740);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("gallery_page")
}

/// A small gallery with hard and with soft shadows, drawn once for all tests.
fn gallery() -> &'static Path {
    static DRAWN: OnceLock<PathBuf> = OnceLock::new();
    DRAWN.get_or_init(|| {
        let out = folder().join("out");
        if out.exists() {
            std::fs::remove_dir_all(&out).expect("the folder of the last run goes");
        }
        let drawn = Command::new(built_example::example("gallery"))
            .args([
                "--size",
                "96x54",
                "--scale",
                "1",
                "--only",
                "figures,soft-cylinder,uberlight,day",
                "--out",
            ])
            .arg(&out)
            .output()
            .expect("the example starts");
        let errors = String::from_utf8_lossy(&drawn.stderr);
        assert!(drawn.status.success(), "{errors}");
        let printed = String::from_utf8_lossy(&drawn.stdout);
        let index = out.join("index.html");
        assert_eq!(
            printed.lines().last(),
            Some(&*index.to_string_lossy()),
            "the last line is where the page is"
        );
        index
    })
}

/// Opens a file in a browser of one test's own.
fn open(test: &str, file: &Path, window: (u32, u32), is_dark: bool) -> Browser {
    let folder = folder().join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("what the browser of the last run remembers goes");
    }
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut browser = Browser::start(&folder);
    browser.open(file, window, is_dark);
    browser
}

/// Loads every picture that the page shows or could show, and returns those that are not there.
fn missing_pictures(browser: &mut Browser) -> Value {
    browser.eval(
        "(async () => {
           const files = new Set();
           for (const image of document.querySelectorAll('img')) if (image.src) files.add(image.src);
           const collect = (value) => {
             if (typeof value === 'string' && value.endsWith('.png')) files.add(new URL(value, location).href);
             else if (value && typeof value === 'object') Object.values(value).forEach(collect);
           };
           collect(JSON.parse(document.getElementById('results').textContent));
           const load = (file) => new Promise((done) => {
             const image = new Image();
             image.onload = () => done(image.naturalWidth > 0 ? null : file);
             image.onerror = () => done(file);
             image.src = file;
           });
           const answers = await Promise.all([...files].map(load));
           return { count: files.size, missing: answers.filter((file) => file !== null) };
         })()",
    )
}

/// Titles of the cards of the first row, in their order.
fn order(browser: &mut Browser) -> Vec<String> {
    let names = browser.eval(
        "[...document.querySelector('.row').querySelectorAll('.card[data-way]')].map((card) => card.dataset.way)",
    );
    serde_json::from_value(names).expect("a list of names")
}

fn is_open(browser: &mut Browser) -> bool {
    browser.eval("document.getElementById('viewer').open") == json!(true)
}

fn wipe(browser: &mut Browser) -> f64 {
    let value = browser.eval("Number(document.getElementById('wipe').getAttribute('aria-valuenow'))");
    value.as_f64().expect("a number")
}

#[test]
fn pictures_load_and_nothing_is_logged() {
    let mut browser = open("pictures", gallery(), DESK, false);
    let loaded = missing_pictures(&mut browser);
    assert_eq!(loaded["missing"], json!([]));
    assert!(loaded["count"].as_u64() >= Some(50), "{loaded}");
    // Every technique of the list has a card in every row, and a line in the table.
    let techniques = antumbra::techniques::Techniques::default().rows().len();
    let rows = browser.eval("[...document.querySelectorAll('.row')].map((row) => row.children.length)");
    let rows: Vec<usize> = serde_json::from_value(rows).expect("counts");
    assert_eq!(rows[..3], [techniques + 1; 3], "with the truth");
    assert!(rows[3] >= 7, "the looks of the light model: {rows:?}");
    assert_eq!(rows[4..], [12; 2], "a day in pictures, and a strip of truth");
    assert_eq!(
        browser.eval("document.querySelectorAll('#measured tbody tr').length"),
        json!(techniques)
    );
    assert!(
        browser
            .eval("document.querySelectorAll('#choices tbody tr').length")
            .as_u64()
            >= Some(3)
    );
    browser.screenshot(&folder().join("desk-light.png"));
    assert_eq!(browser.problems, Vec::<String>::new());
}

/// Brightness of the pixels of a picture of the gallery, 0 to 1.
fn brightness(file: &str) -> Vec<f32> {
    let path = gallery().with_file_name(file);
    let picture = image::open(&path).expect("the picture is there").to_luma32f();
    picture.into_raw()
}

/// The day's pictures look like the truth below them, and not like that of another hour.
#[test]
fn pictures_of_the_day_are_those_of_the_truth() {
    let difference = |a: &[f32], b: &[f32]| {
        let sum: f32 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
        sum / a.len() as f32
    };
    let strip = |what: &str| -> Vec<Vec<f32>> {
        let of_hour = |hour: usize| brightness(&format!("day-{what}-{hour:02}.png"));
        (0..12).map(of_hour).collect()
    };
    let (maps, truth) = (strip("maps"), strip("truth"));
    for hour in 0..12 {
        let (own, other) = (
            difference(&maps[hour], &truth[hour]),
            difference(&maps[hour], &truth[(hour + 6) % 12]),
        );
        println!("picture {hour}: {own:.4}, {other:.4} to the truth of another hour");
        assert!(own < 0.03 && own < 0.6 * other, "picture {hour}: {own}, {other}");
    }
}

#[test]
fn a_missing_picture_and_an_error_are_noticed() {
    let bad = gallery().with_file_name("bad.html");
    let text = std::fs::read_to_string(gallery()).expect("the page is there");
    let end = "<img src=\"nothing.png\"><script>console.error('it broke')</script></body>";
    std::fs::write(&bad, text.replace("</body>", end)).expect("a writable folder");
    let mut browser = open("bad", &bad, DESK, false);
    let loaded = missing_pictures(&mut browser);
    assert!(
        loaded["missing"][0]
            .as_str()
            .is_some_and(|file| file.ends_with("nothing.png")),
        "{loaded}"
    );
    let problems = browser.problems.join("\n");
    assert!(
        problems.contains("it broke") && problems.contains("not loaded"),
        "{problems}"
    );
}

#[test]
fn rows_and_table_sort() {
    let mut browser = open("sort", gallery(), DESK, true);
    let list = order(&mut browser);
    browser.click("#sort .choice:nth-of-type(2)");
    let key = "(way) => { const shot = results.scenes[0].shots[0]; \
               return errorOf(shot, shot.ways.find(({ name }) => name === way)).value; }";
    let by_error = order(&mut browser);
    let errors = browser.eval(&format!("{}.map({key})", json!(by_error)));
    let errors: Vec<f64> = serde_json::from_value(errors).expect("numbers");
    assert!(errors.is_sorted(), "{by_error:?} {errors:?}");
    browser.click("#sort .choice:nth-of-type(3)");
    let costs = "(way) => costOf(results.scenes[0].shots[0].ways.find(({ name }) => name === way), 'rest')";
    let by_cost = order(&mut browser);
    let costs = browser.eval(&format!(
        "{}.map({costs}).map((cost) => Number.isFinite(cost) ? cost : 1e9)",
        json!(by_cost)
    ));
    let costs: Vec<f64> = serde_json::from_value(costs).expect("numbers");
    assert!(costs.is_sorted(), "{by_cost:?} {costs:?}");
    browser.click("#sort .choice:nth-of-type(1)");
    assert_eq!(order(&mut browser), list);

    browser.click("#measured [data-sort=rest]");
    let head = "document.querySelector('#measured [data-sort=rest]').closest('th').getAttribute('aria-sort')";
    assert_eq!(browser.eval(head), json!("ascending"));
    let column =
        "[...document.querySelectorAll('#measured tbody tr')].map((row) => row.cells[3].textContent)";
    // What was not measured is last in either order.
    let measured = |column: Value| {
        let mut cells: Vec<String> = serde_json::from_value(column).expect("a list");
        let count = cells.iter().filter(|cell| *cell != "–").count();
        assert!(cells[count..].iter().all(|cell| cell == "–"), "{cells:?}");
        cells.truncate(count);
        cells
    };
    let up = measured(browser.eval(column));
    browser.click("#measured [data-sort=rest]");
    assert_eq!(browser.eval(head), json!("descending"));
    assert!(up.len() >= 3, "{up:?}");
    let number = |cell: &String| cell.trim_end_matches('×').parse::<f64>().expect("a ratio");
    assert!(up.iter().map(number).is_sorted(), "{up:?}");
    let mut down = measured(browser.eval(column));
    down.reverse();
    // Equal numbers may stand in either order.
    assert_eq!(down, up);
    browser.screenshot(&folder().join("desk-dark.png"));
    assert_eq!(browser.problems, Vec::<String>::new());
}

#[test]
fn the_large_view_opens_wipes_zooms_and_closes() {
    let mut browser = open("viewer", gallery(), DESK, false);
    browser.click(".card[data-way] .thumb");
    assert!(is_open(&mut browser));
    assert_eq!(wipe(&mut browser), 50.0);

    // The line follows the pointer, and what it hides is hidden.
    let (x, y) = browser.middle("#wipe");
    browser.drag(&[(x, y), (x + 60.0, y), (x + 360.0, y)]);
    assert_eq!(wipe(&mut browser), 75.0);
    let clip = browser.eval("getComputedStyle(document.getElementById('right-pane')).clipPath");
    assert_eq!(clip, json!("inset(0px 0px 0px 75%)"));
    browser.press("ArrowLeft");
    assert_eq!(wipe(&mut browser), 73.0);

    // Both pictures are moved and zoomed alike.
    let transforms =
        "[...document.querySelectorAll('.pane .base')].map((image) => getComputedStyle(image).transform)";
    for _ in 0..3 {
        browser.press("+");
    }
    browser.press("d");
    let zoomed = browser.eval(transforms);
    assert_eq!(zoomed[0], zoomed[1]);
    assert!(
        zoomed[0]
            .as_str()
            .is_some_and(|text| text.starts_with("matrix(3.375,")),
        "{zoomed}"
    );
    let (x, y) = browser.middle("#stage");
    browser.drag(&[(x - 200.0, y), (x - 230.0, y - 20.0)]);
    let moved = browser.eval(transforms);
    assert!(moved[0] != zoomed[0] && moved[0] == moved[1], "{moved}");

    // The error lies over the technique, and not over the truth.
    browser.press("e");
    let errors = "[...document.querySelectorAll('.pane .errors')].map((image) => !image.hidden)";
    assert_eq!(browser.eval(errors), json!([true, false]));
    let name = "document.getElementById('left-tag').textContent";
    let first = browser.eval(name);
    browser.press("ArrowDown");
    assert_ne!(browser.eval(name), first);
    browser.press("2");
    let file = browser.eval("document.querySelector('#left-pane .base').getAttribute('src')");
    assert!(
        file.as_str()
            .is_some_and(|file| file.ends_with("-visibility.png")),
        "{file}"
    );
    assert_eq!(missing_pictures(&mut browser)["missing"], json!([]));
    browser.screenshot(&folder().join("desk-viewer.png"));

    browser.press("Escape");
    assert!(!is_open(&mut browser));
    let focused = browser.eval("document.activeElement.className");
    assert!(
        focused.as_str().is_some_and(|class| class.contains("thumb")),
        "the focus goes back: {focused}"
    );
    // Looks have neither errors nor a truth: the large view shows two of them.
    browser.click("#uberlight .thumb");
    let off = browser
        .eval("[...document.querySelectorAll('input[name=viewer-view]')].map((input) => input.disabled)");
    assert_eq!(off, json!([false, true, true, true]));
    let right = browser.eval(
        "(async () => { const image = document.querySelector('#right-pane .base'); \
         await image.decode(); return image.naturalWidth; })()",
    );
    assert!(right.as_u64() > Some(0), "{right}");
    browser.press("Escape");
    browser.eval("document.querySelector('.card[data-way] .thumb').focus()");
    // By keyboard alone.
    browser.press("Enter");
    assert!(is_open(&mut browser));
    browser.click("#viewer-close");
    assert!(!is_open(&mut browser));
    assert_eq!(browser.problems, Vec::<String>::new());
}

#[test]
fn it_fits_a_phone() {
    let mut browser = open("phone", gallery(), PHONE, true);
    let wide = "[document.documentElement.scrollWidth, innerWidth]";
    assert_eq!(browser.eval(wide), json!([360, 360]));
    browser.screenshot(&folder().join("phone-top.png"));
    browser.click(".card[data-way] .thumb");
    assert!(is_open(&mut browser));
    // Everything of the large view is within the window.
    let outside = browser.eval(
        "[...document.querySelectorAll('#viewer button, #viewer select, #viewer label, #stage, #viewer-numbers')]
         .filter((part) => { const box = part.getBoundingClientRect();
           return box.left < -1 || box.right > innerWidth + 1 || box.top < -1 || box.bottom > innerHeight + 1; })
         .map((part) => part.outerHTML)",
    );
    assert_eq!(outside, json!([]));
    let height = browser.eval("document.getElementById('stage').clientHeight");
    assert!(
        height.as_u64() >= Some(240),
        "{height} pixels are left for the pictures"
    );
    let (x, y) = browser.middle("#wipe");
    browser.drag(&[(x, y), (x - 90.0, y)]);
    assert_eq!(wipe(&mut browser), 25.0);
    browser.screenshot(&folder().join("phone-viewer.png"));
    browser.click("#viewer-close");
    assert!(!is_open(&mut browser));
    assert_eq!(browser.problems, Vec::<String>::new());
}

#[test]
fn colours_follow_the_system_and_the_button() {
    let mut browser = open("colours", gallery(), DESK, true);
    let brightness = "Number(getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0])";
    let system = browser.eval(brightness).as_f64().expect("a number");
    assert!(system < 64.0, "dark as the system: {system}");
    browser.click("#theme");
    let light = browser.eval(brightness).as_f64().expect("a number");
    assert!(light > 192.0, "light by the button: {light}");
    browser.click("#theme");
    assert_eq!(browser.eval(brightness).as_f64(), Some(system));
}

#[test]
fn everything_that_can_be_used_has_a_name() {
    let mut browser = open("names", gallery(), DESK, false);
    browser.click(".card[data-way] .thumb");
    // The browser's own computation of what a screen reader says.
    let tree = browser.call("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().expect("a tree");
    let used = ["button", "slider", "combobox", "checkbox", "radio", "link"];
    let roles = |node: &Value| node["role"]["value"].as_str().unwrap_or_default().to_owned();
    let nameless: Vec<&Value> = nodes
        .iter()
        .filter(|node| used.contains(&&*roles(node)) && node["ignored"] != json!(true))
        .filter(|node| {
            node["name"]["value"]
                .as_str()
                .unwrap_or_default()
                .trim()
                .is_empty()
        })
        .collect();
    assert!(nameless.is_empty(), "{nameless:?}");
    assert!(
        nodes.iter().any(|node| roles(node) == "slider"),
        "the slider is seen"
    );
}
