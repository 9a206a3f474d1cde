//! A headless Chromium, driven through the DevTools protocol over two pipes. Keys and pointers are the browser's own input
//! events, not calls of the page's functions.
//!
//! Source: Chromium's `--remote-debugging-pipe`: JSON messages that end with a zero byte, read from descriptor 3 and
//! written to descriptor 4.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use base64::prelude::*;
use serde_json::{Value, json};

/// The same names in the same order as in `scripts/ensure-chromium.sh`.
const NAMES: [&str; 5] = [
    "chromium-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];
const ON_MACOS: &str = "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome";

/// Time within which the browser must answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser with one page.
pub struct Browser {
    process: Child,
    commands: ChildStdin,
    messages: Receiver<Value>,
    session: String,
    next_id: u64,
    /// What went wrong since the page was opened: errors and warnings of the log, exceptions, requests that failed or that
    /// left the machine.
    pub problems: Vec<String>,
}

/// A key as the protocol names it, with its number on Windows.
pub const KEYS: [(&str, u32); 8] = [
    ("ArrowLeft", 37),
    ("ArrowUp", 38),
    ("ArrowRight", 39),
    ("ArrowDown", 40),
    ("Escape", 27),
    ("Enter", 13),
    ("Tab", 9),
    (" ", 32),
];

fn program() -> PathBuf {
    if let Some(named) = std::env::var_os("ANTUMBRA_CHROMIUM") {
        return named.into();
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let in_path = NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    in_path
        .chain([PathBuf::from(ON_MACOS)])
        .find(|path| path.is_file())
        .expect("no Chromium is there to open the gallery with: run scripts/ensure-chromium.sh, or name one in ANTUMBRA_CHROMIUM")
}

impl Browser {
    /// Starts a browser, whose profile is in `folder`, with an empty page.
    pub fn start(folder: &Path) -> Self {
        // Descriptors 3 and 4 are those of the pipes; the shell becomes the browser.
        let mut process = Command::new("sh")
            .args([
                "-c",
                r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >/dev/null 2>"$BROWSER_LOG""#,
            ])
            .arg(program())
            .args([
                "--headless",
                "--remote-debugging-pipe",
                "--no-first-run",
                "--disable-gpu",
            ])
            // Root of a container has no sandbox and little shared memory; only files of this test are opened.
            .args(["--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"])
            .arg(format!("--user-data-dir={}", folder.join("profile").display()))
            .arg("about:blank")
            .env("BROWSER_LOG", folder.join("browser.log"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a shell starts the browser");
        let commands = process.stdin.take().expect("it is piped");
        let answers = process.stdout.take().expect("it is piped");
        let (send, messages) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(answers).split(0) {
                let Ok(message) = message else { break };
                let message = serde_json::from_slice(&message).expect("the browser writes JSON");
                if send.send(message).is_err() {
                    break;
                }
            }
        });
        let mut browser = Self {
            process,
            commands,
            messages,
            session: String::new(),
            next_id: 0,
            problems: Vec::new(),
        };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let attached = browser.call("Target.attachToTarget", attach);
        browser.session = attached["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Calls a method of the protocol and returns its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.next_id += 1;
        let mut message = json!({"id": self.next_id, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        write!(self.commands, "{message}\0").expect("the browser reads");
        self.commands.flush().expect("the browser reads");
        loop {
            let mut answer = self.receive(method);
            if answer["id"] == json!(self.next_id) {
                assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
        }
    }

    fn receive(&mut self, waiting_for: &str) -> Value {
        let message = self.messages.recv_timeout(PATIENCE);
        let message =
            message.unwrap_or_else(|error| panic!("{waiting_for}: the browser does not answer: {error}"));
        self.problems.extend(problem(&message));
        message
    }

    /// Opens a file and waits until it is loaded. `width` and `height` are those of the window, CSS pixels.
    pub fn open(&mut self, file: &Path, (width, height): (u32, u32), is_dark: bool) {
        self.problems.clear();
        let metrics =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500});
        self.call("Emulation.setDeviceMetricsOverride", metrics);
        let scheme = if is_dark { "dark" } else { "light" };
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.call("Emulation.setEmulatedMedia", json!({"features": features}));
        self.call(
            "Page.navigate",
            json!({"url": format!("file://{}", file.display())}),
        );
        while self.receive("the page")["method"] != json!("Page.loadEventFired") {}
    }

    /// Evaluates an expression in the page. A promise is awaited.
    pub fn eval(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let mut answer = self.call("Runtime.evaluate", parameters);
        let failed = &answer["exceptionDetails"];
        assert!(failed.is_null(), "{expression}: {failed}");
        answer["result"]["value"].take()
    }

    /// Presses and releases a key: one of [`KEYS`], or a character.
    pub fn press(&mut self, key: &str) {
        let named = KEYS.iter().find(|(name, _)| *name == key);
        let code = named.map_or_else(
            || u32::from(key.as_bytes()[0].to_ascii_uppercase()),
            |(_, code)| *code,
        );
        let mut event = json!({"type": "keyDown", "key": key, "windowsVirtualKeyCode": code});
        if key.len() == 1 {
            event["text"] = json!(key);
        } else if key == "Enter" {
            event["text"] = json!("\r");
        }
        self.call("Input.dispatchKeyEvent", event);
        let event = json!({"type": "keyUp", "key": key, "windowsVirtualKeyCode": code});
        self.call("Input.dispatchKeyEvent", event);
    }

    /// Moves the pointer to the first place, presses it there, moves it along the others, and releases it.
    pub fn drag(&mut self, places: &[(f64, f64)]) {
        let mut send = |kind: &str, (x, y): (f64, f64), buttons: u32| {
            let button = if buttons > 0 || kind == "mouseReleased" {
                "left"
            } else {
                "none"
            };
            let event =
                json!({"type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1});
            self.call("Input.dispatchMouseEvent", event);
        };
        send("mouseMoved", places[0], 0);
        send("mousePressed", places[0], 1);
        for &place in &places[1..] {
            send("mouseMoved", place, 1);
        }
        send("mouseReleased", places[places.len() - 1], 0);
    }

    /// Scrolls an element into view and clicks at its middle.
    pub fn click(&mut self, selector: &str) {
        let middle = self.middle(selector);
        self.drag(&[middle]);
    }

    /// Scrolls an element into view and returns its middle, CSS pixels of the window.
    pub fn middle(&mut self, selector: &str) -> (f64, f64) {
        let place = self.eval(&format!(
            "(() => {{ const found = document.querySelector({selector:?}); found.scrollIntoView({{block: 'center', behavior: 'instant'}}); \
             const box = found.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; }})()"
        ));
        (
            place[0].as_f64().expect("a number"),
            place[1].as_f64().expect("a number"),
        )
    }

    /// Writes what the window shows as PNG.
    pub fn screenshot(&mut self, path: &Path) {
        let answer = self.call("Page.captureScreenshot", json!({"format": "png"}));
        let text = answer["data"].as_str().expect("a picture");
        let picture = BASE64_STANDARD.decode(text).expect("base 64");
        std::fs::write(path, picture).expect("a writable folder");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its other processes end with it.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns what is wrong, if an event says so.
fn problem(message: &Value) -> Option<String> {
    let parameters = &message["params"];
    let is_bad = |level: &Value| matches!(level.as_str(), Some("error" | "warning" | "assert"));
    match message["method"].as_str()? {
        "Runtime.exceptionThrown" => Some(format!("exception: {}", parameters["exceptionDetails"])),
        "Runtime.consoleAPICalled" => {
            is_bad(&parameters["type"]).then(|| format!("console: {}", parameters["args"]))
        }
        "Log.entryAdded" => {
            is_bad(&parameters["entry"]["level"]).then(|| format!("log: {}", parameters["entry"]))
        }
        "Network.loadingFailed" => {
            let is_canceled = parameters["canceled"] == json!(true);
            (!is_canceled).then(|| format!("not loaded: {parameters}"))
        }
        "Network.requestWillBeSent" => {
            let url = parameters["request"]["url"].as_str().unwrap_or_default();
            let is_local = ["file:", "data:", "about:"]
                .iter()
                .any(|start| url.starts_with(start));
            (!is_local).then(|| format!("a request to {url}"))
        }
        _ => None,
    }
}
