//! Occlusion interval maps: against a ray-traced linear light, against their CPU twin, and when something is wrong.

mod appearance;
mod by_hand;
pub mod companions;
mod drawn;
mod exactness;
pub mod faults;
mod left_out;
pub mod scenes;
mod shots;
