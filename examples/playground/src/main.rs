//! A window in which the techniques of each light are chosen, set, and compared with each other and with the truth.
//!
//! ```sh
//! cargo run --release --package antumbra_playground -- [SCENE.glb|SHOT.json]
//! cargo run --release --package antumbra_playground -- --script FILE --out DIR
//! ```
//!
//! A script holds a command in each line, as JSON; [`Command`](antumbra_playground::command::Command) lists them.
//! Any error is one line on stderr, with exit status 1.

#[cfg(feature = "window")]
mod window;

use std::path::PathBuf;
use std::process::ExitCode;

use antumbra::techniques::Techniques;
use antumbra_playground::session::{Session, headless_context};
use clap::Parser;
use glam::UVec2;

/// Tries the shadow techniques of antumbra on a scene.
#[derive(Parser)]
struct Arguments {
    /// A scene (.glb, .gltf) or a shot file (.json). Without it a file can be dropped on the window.
    file: Option<PathBuf>,
    /// Runs a script without a window.
    #[arg(long)]
    script: Option<PathBuf>,
    /// Folder for what is saved; created if missing.
    #[arg(long, default_value = "out/playground")]
    out: PathBuf,
    /// Size of the window, pixels.
    #[arg(long, default_value = "1280x800", value_parser = parse_size)]
    size: UVec2,
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    let parts = text.split_once('x').and_then(|(width, height)| {
        let size = UVec2::new(width.parse().ok()?, height.parse().ok()?);
        (size.min_element() >= 1 && size.max_element() <= 8192).then_some(size)
    });
    parts.ok_or_else(|| format!("`{text}` is no size such as 1280x800, of 1 to 8192 pixels"))
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            eprintln!("{}", line.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let Some(script) = &arguments.script else {
        return open_window(arguments);
    };
    let named = |error: String| format!("{}: {error}", script.display());
    let text = std::fs::read_to_string(script).map_err(|error| named(error.to_string()))?;
    let context = headless_context()?;
    let mut session = Session::new(context, Techniques::default(), arguments.size, &arguments.out)?;
    if let Some(file) = &arguments.file
        && !session.app.open(file)
    {
        let message = session.app.message.map(|message| message.text);
        return Err(message.unwrap_or_default());
    }
    session.run_script(&text).map_err(named)
}

#[cfg(feature = "window")]
fn open_window(arguments: &Arguments) -> Result<(), String> {
    window::open(arguments.file.as_deref(), &arguments.out, arguments.size)
}

#[cfg(not(feature = "window"))]
fn open_window(_: &Arguments) -> Result<(), String> {
    Err(
        "this playground was built without its feature `window`; run a script with --script FILE --out DIR"
            .to_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_size_are_checked() {
        assert_eq!(parse_size("8192x1"), Ok(UVec2::new(8192, 1)));
        for wrong in ["0x5", "5x0", "9000x5", "5x9000", "5", "5x", "-5x5"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
