//! The sets of a frame.
