// The sums that wedges and caps are added to: values by layer, and their layout in the targets.
// Host    src/techniques/penumbra_wedge/gpu/form.rs
#define_import_path antumbra::wedge_sums

// Steps of coverage in 1 where it is split over four bytes.
const SPLIT_STEPS: f32 = 4096.0;

// Value of a hard shadow in the channel that also sums the shares. Shares sum to less than half of it.
const HARD_SHADOW: f32 = 64.0;
// Value of a hard shadow where up to 254 casters lie one behind the other. Places are then hidden or not, without
// steps between.
const DEEP_HARD_SHADOW: f32 = 256.0;

// Bits of layers.
const FACING: u32 = 1u;             // mirror: techniques::penumbra_wedge::geometry::silhouette_layers::FACING
const AVERTED: u32 = 2u;            // mirror: techniques::penumbra_wedge::geometry::silhouette_layers::AVERTED

// Layout of sampled sums: the first channel holds the share and the count of hard shadows. Each other channel
// holds three places as digits of −128 to 127 steps, within the 24 bits of a float.
const DIGITS: vec3f = vec3f(1.0, 256.0, 65536.0);

// A value in the facing and in the averted layer.
struct Layers {
    facing: Value,
    averted: Value,
}

// The numbers that a fragment adds to the sums of a layer.
struct Value {
    sums: vec4f,
    more: vec4f,                    // further places; 0 unless dense
}

// The targets of sums. Without dense sums there are up to two: facing, averted. With dense sums there are up to four:
// facing and its further places, averted and its further places. Casters whose layers are the same have the first half.
struct Targets {
    @location(0) a: vec4f,
    @location(1) b: vec4f,
    @location(2) c: vec4f,
    @location(3) d: vec4f,
}

fn times(value: Value, factor: f32) -> Value {
    return Value(value.sums * factor, value.more * factor);
}

fn layered(value: vec4f, layers: u32) -> Layers {
    let both = Value(value, vec4f(0.0));
    return Layers(times(both, f32(layers & FACING)), times(both, f32((layers & AVERTED) >> 1u)));
}

const NOTHING = Layers();

fn doubled_less(soft: Value, hard: Value) -> Value {
    return Value(2.0 * soft.sums - hard.sums, 2.0 * soft.more);
}

fn scaled(value: Layers, factor: f32) -> Layers {
    return Layers(times(value.facing, factor), times(value.averted, factor));
}

fn is_nothing(value: Layers) -> bool {
    let facing = all(value.facing.sums == vec4f(0.0)) && all(value.facing.more == vec4f(0.0));
    return facing && all(value.averted.sums == vec4f(0.0)) && all(value.averted.more == vec4f(0.0));
}

// Twelve bits over four bytes, three in each; the upper five bits of a byte are for carries. What is added
// and what is subtracted are in separate textures.
struct Split {
    @location(0) facing_added: vec4f,
    @location(1) facing_subtracted: vec4f,
    @location(2) averted_added: vec4f,
    @location(3) averted_subtracted: vec4f,
}

fn digits(value: f32) -> vec4f {
    let steps = u32(round(max(value, 0.0) * SPLIT_STEPS));
    return vec4f(vec4u(steps >> 9u, (steps >> 6u) & 7u, (steps >> 3u) & 7u, steps & 7u)) / 255.0;
}

fn split(value: Layers) -> Split {
    let facing = value.facing.sums.r;
    let averted = value.averted.sums.r;
    return Split(digits(facing), digits(-facing), digits(averted), digits(-averted));
}
