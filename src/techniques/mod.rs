//! Shadow techniques.
