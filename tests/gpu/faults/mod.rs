//! Faults that other test suites and bug reports found. Each test covers all cases of its fault.

mod area_placements;
mod coincident_surfaces;
mod flat_casters;
mod large_grounds;
mod leftovers;
mod light_cut;
mod light_cut_finely;
mod light_on_surface;
pub mod placements;
mod regions;
mod savings;
mod scenes;
mod stacks;
mod transforms;
