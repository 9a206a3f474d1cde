// From sums to visibility: what one part of a light adds to the mask. Its share of the light is the blend constant.
// Host    src/techniques/penumbra_wedge/node.rs
// Groups  0 view, 1 receiver, 2 wedges, 3 the visibility buffer
#import antumbra::receiver::receiver_at
#import antumbra::wedge_light::{light, Maths, seat, seat_at, above, places_above, PLACE_STEPS, HARD_SHADOW, DEEP_HARD_SHADOW}

@group(3) @binding(0) var facing_sums: texture_2d<f32>;         // or what was added, in four bytes
@group(3) @binding(1) var facing_subtracted: texture_2d<f32>;
@group(3) @binding(2) var combined: texture_2d<f32>;            // coverage of the groups before
@group(3) @binding(3) var<storage, read_write> overflow: atomic<u32>;
@group(3) @binding(4) var averted_sums: texture_2d<f32>;
@group(3) @binding(5) var averted_subtracted: texture_2d<f32>;

// The light is a sphere, else a rectangle.
override IS_SPHERE: bool = false;
// The light is a textured rectangle.
override IS_TEXTURED: bool = false;
// The sums are four bytes each way.
override IS_SPLIT: bool = false;
// There is one sum for all colours.
override IS_SCALAR: bool = false;
// Beside a sum, hard shadows and places on the light are counted.
override IS_SAMPLED: bool = false;
// More layers may lie one behind the other than the digits of places have room for in steps.
override IS_DEEP: bool = false;
// The coverage of groups was combined.
override IS_COMBINED: bool = false;

@vertex
fn vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0;
    return vec4f(corner, 0.0, 1.0);
}

fn joined(added: vec4f, subtracted: vec4f) -> vec4f {
    if IS_SPLIT {
        let weights = vec4f(512.0, 64.0, 8.0, 1.0) * (255.0 / 4096.0);
        // A byte that is full may have lost a carry.
        if any(max(added, subtracted) >= vec4f(1.0)) {
            atomicAdd(&overflow, 1u);
        }
        return vec4f(dot(added - subtracted, weights));
    }
    return select(added, added.rrrr, IS_SCALAR);
}

// What is covered above the horizon, by layers.
struct Covered {
    facing: vec4f,
    averted: vec4f,
}

fn summed(pixel: vec2u, over: vec4f) -> Covered {
    let facing = joined(textureLoad(facing_sums, pixel, 0), textureLoad(facing_subtracted, pixel, 0));
    let averted = joined(textureLoad(averted_sums, pixel, 0), textureLoad(averted_subtracted, pixel, 0));
    return Covered(clamp(-facing, vec4f(0.0), over), clamp(-averted, vec4f(0.0), over));
}

// How often each place is hidden, told by three of them that one float holds beside the count of hard shadows. Digits have
// room for 32 times, or for 256: what is more is told as less, so a light with more layers than 30 takes the latter.
fn times_hidden(hard: f32, packed: f32) -> vec3f {
    let second = round(packed / 256.0);
    let third = round(second / 256.0);
    if IS_DEEP {
        return times_hidden_deep(hard, packed);
    }
    let told = hard - vec3f(packed - 256.0 * second, second - 256.0 * third, third) / PLACE_STEPS;
    return told - 32.0 * floor((told + 1.0) / 32.0);
}

// The same without steps. A digit that is out of its range, −128 to 127, has carried into the next: it is told first, and
// taken out of what the next are read from.
fn times_hidden_deep(hard: f32, packed: f32) -> vec3f {
    let first = within_256(hard - (packed - 256.0 * round(packed / 256.0)));
    let rest = (packed - (hard - first)) / 256.0;
    let second = within_256(hard - (rest - 256.0 * round(rest / 256.0)));
    return vec3f(first, second, hard - (rest - (hard - second)) / 256.0);
}

fn within_256(times: f32) -> f32 {
    return times - 256.0 * floor((times + 1.0) / 256.0);
}

// How often the places on the light are hidden in one layer.
struct Counts {
    covered: f32,                   // the sum of what is covered, overlaps as often as they are
    hidden: mat3x3f,
}

fn counts(sums: vec4f, over: f32, is_above: mat3x3f) -> Counts {
    let one = select(HARD_SHADOW, DEEP_HARD_SHADOW, IS_DEEP);
    let hard = -round(sums.r / one);
    let hidden = mat3x3f(
        times_hidden(hard, sums.g) * is_above[0],
        times_hidden(hard, sums.b) * is_above[1],
        times_hidden(hard, sums.a) * is_above[2],
    );
    return Counts(hard * over - (sums.r + hard * one), hidden);
}

// Sums over the places.
fn sum_of(values: mat3x3f) -> f32 {
    return dot(values[0] + values[1] + values[2], vec3f(1.0));
}

fn product(a: mat3x3f, b: mat3x3f) -> mat3x3f {
    return mat3x3f(a[0] * b[0], a[1] * b[1], a[2] * b[2]);
}

// A layer's account of what is hidden, and how well it accounts for what the places tell.
struct Account {
    hidden: f32,
    fit: f32,
}

// What is hidden, told by nine places, and better by the exact sum that goes with them: by so much as places that are
// hidden more often are those that are hidden at all. Where nothing overlaps, sum and places agree, and the sum is the
// answer; where all is hidden twice over, the sum says nothing.
//
// Source: regression with a control variate, as e.g. Owen 2013, "Monte Carlo theory, methods and examples", 8.9.
//
// What hides more of the light than lies between places hides some of them: the sum adds no more than that. It would where
// many hide the same rim of the light, and no place.
fn account(layer: Counts, is_hidden: mat3x3f) -> Account {
    // Share of the light that lies on one side of a line and holds no place, and what thin casters hide besides; by eye.
    const UNSEEN = 0.15;
    const COUNT = 9.0;
    // The weight of believing, against places that all tell the same; by trial over the models.
    const BELIEF = 0.25;
    let mean = sum_of(is_hidden) / COUNT;
    let mean_count = sum_of(layer.hidden) / COUNT;
    let together = sum_of(product(is_hidden, layer.hidden)) - COUNT * mean * mean_count;
    let spread = max(sum_of(product(layer.hidden, layer.hidden)) - COUNT * mean_count * mean_count, 0.0);
    let own_spread = COUNT * mean * (1.0 - mean);
    let believed = select(1.0, clamp(mean / max(mean_count, 1e-6), 0.0, 1.0), mean_count > 0.05);
    let slope = clamp((together + BELIEF * believed) / (spread + BELIEF), 0.0, 1.0);
    let fit = (together * together + BELIEF * believed) / (spread * own_spread + BELIEF);
    return Account(mean + min(slope * (layer.covered - mean_count), UNSEEN), fit);
}

// The layer whose account fits better tells; by turns where they fit alike within this, so that none jumps.
const FIT_WIDTH: f32 = 0.4;

fn sampled(pixel: vec2u, horizon: vec3f, over: f32) -> f32 {
    let is_above = places_above(horizon, IS_SPHERE);
    let facing = counts(textureLoad(facing_sums, pixel, 0), over, is_above);
    let averted = counts(textureLoad(averted_sums, pixel, 0), over, is_above);
    let is_hidden = mat3x3f(
        clamp(max(facing.hidden[0], averted.hidden[0]), vec3f(0.0), is_above[0]),
        clamp(max(facing.hidden[1], averted.hidden[1]), vec3f(0.0), is_above[1]),
        clamp(max(facing.hidden[2], averted.hidden[2]), vec3f(0.0), is_above[2]),
    );
    let by_facing = account(facing, is_hidden);
    let by_averted = account(averted, is_hidden);
    let to_averted = clamp(0.5 + (by_averted.fit - by_facing.fit) / FIT_WIDTH, 0.0, 1.0);
    return clamp(mix(by_facing.hidden, by_averted.hidden, to_averted), 0.0, over);
}

// What of the whole light lies above the horizon; never quite nothing.
fn whole_above(pixel: vec2f) -> f32 {
    let half_size = select(light.half_size / light.place.zw, vec2f(light.whole.w), IS_SPHERE);
    let at = seat_at(receiver_at(pixel), light.whole.xyz, half_size, IS_SPHERE);
    return max(above(at.horizon, Maths(IS_SPHERE, false, false)).a, 1e-3);
}

fn above_here(horizon: vec3f) -> vec4f {
    return above(horizon, Maths(IS_SPHERE, false, IS_TEXTURED));
}

// By colour: of what lies above the horizon, for light passes cut there too; of the area: of all.
@fragment
fn resolve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let at = seat(receiver_at(position.xy), IS_SPHERE);
    let over = above_here(at.horizon);
    var covered = vec4f(0.0);
    if IS_SAMPLED {
        covered = vec4f(sampled(pixel, at.horizon, over.a));
    } else if IS_COMBINED {
        let before = textureLoad(combined, pixel, 0);
        let by_layer = 0.5 * (before.xy + before.zw);
        covered = min(select(vec4f(max(by_layer.x, by_layer.y)), before, IS_TEXTURED), over);
    } else {
        let layers = summed(pixel, over);
        covered = max(layers.facing, layers.averted);
    }
    let visible = over - covered;
    return vec4f(visible.rgb / whole_above(position.xy), visible.a);
}

// Coverage between the extremes of no and all overlap: equation 1 is max + ½ min, of two groups. Of more, one after the
// other, it would depend on their order; half of the sum and the largest is the same of two, and does not. So the sum is kept
// in xy and the largest in zw: layers are two accounts of one shadow, and each is combined by itself. By colour there is no
// room for that: the layer that hides more counts, and groups are combined one after the other.
// Source: Assarsson et al. 2003, equation 1.
@fragment
fn combine(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let at = seat(receiver_at(position.xy), IS_SPHERE);
    let layers = summed(pixel, above_here(at.horizon));
    let by_color = max(layers.facing, layers.averted);
    let before = textureLoad(combined, pixel, 0);
    if IS_TEXTURED {
        return max(before, by_color) + 0.5 * min(before, by_color);
    }
    let now = vec2f(layers.facing.a, layers.averted.a);
    return vec4f(before.xy + now, max(before.zw, now));
}
