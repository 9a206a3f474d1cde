// Angles, more exact than the built-in functions must be.
#define_import_path antumbra::angles

const PI: f32 = 3.14159265;
const TAU: f32 = 6.28318531;

// The angle of a vector from the first axis towards the second, in −π..=π. The error is below 1e-6; built-in
// functions of devices may err by 4096 units in the last place. The zero vector gives 0.
// The polynomial is the minimax fit of atan(t) / t in t² over 0..=1, found by weighted least squares.
fn angle(first: f32, second: f32) -> f32 {
    let across = abs(first);
    let along = abs(second);
    let t = min(across, along) / max(max(across, along), 1e-30);
    let s = t * t;
    var p = -0.004054560791701078;
    p = p * s + 0.0218629352748394;
    p = p * s - 0.05591229721903801;
    p = p * s + 0.09642194956541061;
    p = p * s - 0.1390862911939621;
    p = p * s + 0.19946566224098206;
    p = p * s - 0.33329859375953674;
    p = p * s + 0.9999993443489075;
    let octant = p * t;
    let quadrant = select(octant, 0.5 * PI - octant, along > across);
    let half = select(quadrant, PI - quadrant, first < 0.0);
    return select(half, -half, second < 0.0);
}
