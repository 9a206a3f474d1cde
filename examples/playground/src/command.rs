//! The commands of scripts. Most call the functions that the window calls; the others stand for mouse and keyboard.

use std::path::PathBuf;

use serde::Deserialize;
use serde_json::Value;

use crate::compare::Show;
use crate::document::Side;
use crate::overlay::Overlay;

/// A line of a script.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Opens a scene or a shot file.
    Open {
        /// The file.
        path: PathBuf,
    },
    /// Drops files on the window; the first is opened.
    Drop {
        /// The files.
        paths: Vec<PathBuf>,
    },
    /// Selects a light.
    Select {
        /// Index of the light; `null` selects none.
        light: Option<usize>,
    },
    /// Gives the selected light a technique with its default settings.
    Technique {
        /// The side.
        side: Side,
        /// Name of the technique, or `none`.
        name: String,
    },
    /// Sets a setting of the selected light's technique.
    Set {
        /// The side.
        side: Side,
        /// Path of the setting, such as `cascades/count`.
        key: String,
        /// Its value; `null` sets the default.
        value: Value,
    },
    /// Sets a key of the selected light.
    Light {
        /// Path of the key, such as `intensity`.
        key: String,
        /// Its value; `null` removes the key.
        value: Value,
    },
    /// Moves the selected light.
    Move {
        /// Offset, metres.
        by: [f32; 3],
    },
    /// Adds a light in front of the viewer.
    Add {
        /// Kind of the light.
        kind: String,
    },
    /// Adds a copy of the selected light.
    Duplicate,
    /// Deletes the selected light.
    Delete,
    /// Undoes the last change.
    Undo,
    /// Redoes the change that was undone last.
    Redo,
    /// Chooses what the halves of the view show.
    Show {
        /// The left half.
        left: Show,
        /// The right half.
        right: Show,
    },
    /// Moves the divider between the halves.
    Divider {
        /// Share of the width left of it.
        at: f32,
    },
    /// Goes around the target.
    Orbit {
        /// Angles to the left and up, degrees.
        by: [f32; 2],
    },
    /// Looks around.
    Look {
        /// Angles to the left and up, degrees.
        by: [f32; 2],
    },
    /// Flies along the axes of the view.
    Fly {
        /// Metres to the right, up and forward.
        by: [f32; 3],
    },
    /// Goes nearer to the target.
    Dolly {
        /// Factor on the distance.
        factor: f32,
    },
    /// Starts or stops the animation.
    Play {
        /// Whether it plays.
        on: bool,
    },
    /// Poses the scene.
    Time {
        /// Index of the clip.
        #[serde(default)]
        clip: usize,
        /// Time within the clip.
        seconds: f32,
    },
    /// Traces the truth, and waits until it has all its samples.
    Truth {
        /// Samples on each area light.
        samples: u32,
    },
    /// Shows or hides lines over the picture.
    Overlay {
        /// The lines.
        name: Overlay,
        /// Whether they are shown.
        on: bool,
    },
    /// Shows or hides the techniques' own debug views.
    Debug {
        /// Whether they are shown.
        on: bool,
    },
    /// Opens or closes the graph of times.
    Times {
        /// Whether it is open.
        on: bool,
    },
    /// Draws frames.
    Frames {
        /// Number of frames.
        count: usize,
    },
    /// Changes the size of the window.
    Size {
        /// Width and height, pixels.
        to: [u32; 2],
    },
    /// Changes the number of pixels for each point.
    Scale {
        /// The number.
        to: f32,
    },
    /// Presses and releases a key.
    Key {
        /// Name of the key, such as `F1`.
        key: String,
        /// Holds the control key meanwhile.
        #[serde(default)]
        ctrl: bool,
    },
    /// Holds a key down while frames are drawn, and releases it.
    Hold {
        /// Name of the key, such as `W`.
        key: String,
        /// Number of frames.
        frames: usize,
    },
    /// Clicks on the middle of a text of the window.
    Click {
        /// The text.
        text: String,
    },
    /// Moves the pointer.
    Pointer {
        /// Place, points from the window's top left corner.
        to: [f32; 2],
    },
    /// Moves the pointer to a light of the list in the view.
    PointLight {
        /// Index of the light.
        light: usize,
        /// Offset, points.
        #[serde(default)]
        offset: [f32; 2],
    },
    /// Presses a button of the mouse: 0 left, 1 right, 2 middle.
    Press {
        /// The button.
        #[serde(default)]
        button: usize,
    },
    /// Releases a button of the mouse.
    Release {
        /// The button.
        #[serde(default)]
        button: usize,
    },
    /// Turns the wheel of the mouse.
    Wheel {
        /// Lines.
        lines: f32,
    },
    /// Loses the device, as happens when a driver is reset.
    LoseDevice,
    /// Writes a picture of the window.
    Screenshot {
        /// Name of the file in the folder of the results.
        file: PathBuf,
    },
    /// Writes the picture of a half of the view.
    Picture {
        /// What it shows.
        show: Show,
        /// Name of the file in the folder of the results.
        file: PathBuf,
    },
    /// Saves the shot.
    Save {
        /// The side whose techniques it has.
        side: Side,
        /// Name of the file in the folder of the results.
        file: PathBuf,
    },
    /// Writes the lights as Bevy code.
    Bevy {
        /// The side whose techniques it has.
        side: Side,
        /// Name of the file in the folder of the results.
        file: PathBuf,
    },
    /// Writes what is known about the frame: lights, errors, times and the message, as JSON.
    Report {
        /// Name of the file in the folder of the results.
        file: PathBuf,
    },
}
