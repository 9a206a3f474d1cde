//! Silhouettes.
