//! The CPU judge.
