//! Animation clips.
