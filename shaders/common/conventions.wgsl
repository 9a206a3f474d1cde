// The constants of src/conventions.rs that shaders need. tests/gpu/layout_contract.rs checks that they are equal.
#define_import_path antumbra::conventions

// Depth of the near plane, and of a vertex with w = 0.
const DEPTH_NEAR: f32 = 1.0;
const DEPTH_INFINITY: f32 = 0.0;

const PI: f32 = 3.14159265358979;

// Largest finite value of the radiance target's half floats.
const RADIANCE_MAX: f32 = 65504.0;
