//! The judge is judged: closed forms, brute force, and negative controls for every comparison.

#[path = "reference/analytic.rs"]
mod analytic;
#[path = "reference/comparison.rs"]
mod comparison;
#[path = "reference/harness.rs"]
mod harness;
#[path = "reference/intersection.rs"]
mod intersection;
#[path = "reference/scene.rs"]
mod scene;
