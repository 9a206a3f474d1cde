//! The playground: a window in which the techniques of each light are chosen, set, and compared with each other and
//! with ray-traced truth.
//!
//! Everything but the window itself is here, so that scripts can do what a user does, without a display.

pub mod app;
pub mod bevy_code;
pub mod command;
pub mod compare;
pub mod document;
pub mod handles;
pub mod history;
pub mod light;
pub mod measures;
pub mod opening;
pub mod orbit;
pub mod overlay;
pub mod paint;
pub mod schema;
pub mod session;
pub mod side;
pub mod target;
pub mod times;
pub mod truth;
pub mod ui;
pub mod widgets;
