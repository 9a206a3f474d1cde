//! The judge is judged: closed forms, brute force, and negative controls for every comparison.

mod analytic;
mod comparison;
mod harness;
mod intersection;
mod scene;
