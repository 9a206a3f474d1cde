//! A frame that a host draws and lights: its depth is not ours to the last bit, its targets are larger than the view, its
//! projection is its own. What lights see must be what they see in a frame of our own.

mod companions;
mod comparison;
mod host;
mod scaled;
mod scenes;
mod techniques;
mod textured;
mod unseen;
mod views;
