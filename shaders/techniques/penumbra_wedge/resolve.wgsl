// From sums to visibility: adds one part of a light to the mask. The part's share of the light is the blend
// constant.
// Host    src/techniques/penumbra_wedge/gpu/recorder.rs
// Groups  0 view, 1 receiver, 2 wedges, 3 the visibility buffer
#import antumbra::receiver::receiver_at
#import antumbra::light_places::{Places, Sampling, places_above, PLACE_STEPS}
#import antumbra::wedge_light::{light, Maths, seat, seat_at, above}
#import antumbra::wedge_sums::{HARD_SHADOW, DEEP_HARD_SHADOW, SPLIT_STEPS}

@group(3) @binding(0) var facing_sums: texture_2d<f32>;         // with IS_SPLIT: the bytes that were added
@group(3) @binding(1) var facing_second: texture_2d<f32>;       // with IS_SPLIT: bytes that were subtracted; with IS_DENSE: further places
@group(3) @binding(2) var combined: texture_2d<f32>;            // coverage of the groups before this one
@group(3) @binding(3) var<storage, read_write> overflow: atomic<u32>;
@group(3) @binding(4) var averted_sums: texture_2d<f32>;
@group(3) @binding(5) var averted_second: texture_2d<f32>;

// The light is a sphere; otherwise it is a rectangle.
override IS_SPHERE: bool = false;
// The light is a textured rectangle.
override IS_TEXTURED: bool = false;
// The sums are four bytes for what is added and four for what is subtracted.
override IS_SPLIT: bool = false;
// One channel holds the sum for all colours.
override IS_SCALAR: bool = false;
// Besides the sum, the channels count hard shadows and places on the light.
override IS_SAMPLED: bool = false;
// Twenty-one places are counted instead of nine.
override IS_DENSE: bool = false;
// More casters may lie one behind the other than the digits of places have room for in steps, so places are
// either hidden or not.
override IS_DEEP: bool = false;
// The coverage of groups has been combined.
override IS_COMBINED: bool = false;

fn joined(added: vec4f, subtracted: vec4f) -> vec4f {
    if IS_SPLIT {
        let weights = vec4f(512.0, 64.0, 8.0, 1.0) * (255.0 / SPLIT_STEPS);
        // A byte that is full may have lost a carry.
        if any(max(added, subtracted) >= vec4f(1.0)) {
            atomicAdd(&overflow, 1u);
        }
        return vec4f(dot(added - subtracted, weights));
    }
    return select(added, added.rrrr, IS_SCALAR);
}

// Coverage of the part above the horizon, by layer.
struct Covered {
    facing: vec4f,
    averted: vec4f,
}

fn summed(pixel: vec2u, over: vec4f) -> Covered {
    let facing = joined(textureLoad(facing_sums, pixel, 0), textureLoad(facing_second, pixel, 0));
    let averted = joined(textureLoad(averted_sums, pixel, 0), textureLoad(averted_second, pixel, 0));
    return Covered(clamp(-facing, vec4f(0.0), over), clamp(-averted, vec4f(0.0), over));
}

// How often three places are hidden: the count of hard shadows, less the signed counts of edges that one
// float holds for the three. A digit has room for 32 times, or for 256 without steps; higher counts wrap around
// to lower ones. So a light with more than 30 casters one behind the other leaves the steps out.
fn times_hidden(hard: f32, packed: f32) -> vec3f {
    let second = round(packed / 256.0);
    let third = round(second / 256.0);
    if IS_DEEP {
        return times_hidden_deep(hard, packed);
    }
    let times = hard - vec3f(packed - 256.0 * second, second - 256.0 * third, third) / PLACE_STEPS;
    return times - 32.0 * floor((times + 1.0) / 32.0);
}

// As times_hidden, for digits without steps. A digit outside of its range, −128 to 127, has carried into the next
// one. So each digit is determined first and subtracted from what the next ones are read from.
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
    covered: f32,                   // sum of coverages; each overlap counts again
    hidden: Places,
}

fn counts(sums: vec4f, more: vec4f, over: f32, is_above: Places) -> Counts {
    let one = select(HARD_SHADOW, DEEP_HARD_SHADOW, IS_DEEP);
    let hard = -round(sums.r / one);
    var hidden: Places;
    hidden.first = mat3x3f(
        times_hidden(hard, sums.g) * is_above.first[0],
        times_hidden(hard, sums.b) * is_above.first[1],
        times_hidden(hard, sums.a) * is_above.first[2],
    );
    if IS_DENSE {
        hidden.more = mat4x3f(
            times_hidden(hard, more.r) * is_above.more[0],
            times_hidden(hard, more.g) * is_above.more[1],
            times_hidden(hard, more.b) * is_above.more[2],
            times_hidden(hard, more.a) * is_above.more[3],
        );
    }
    return Counts(hard * over - (sums.r + hard * one), hidden);
}

// Sum over all places.
fn sum_of(values: Places) -> f32 {
    let first = values.first[0] + values.first[1] + values.first[2];
    return dot(first + values.more[0] + values.more[1] + values.more[2] + values.more[3], vec3f(1.0));
}

fn product(a: Places, b: Places) -> Places {
    return Places(
        mat3x3f(a.first[0] * b.first[0], a.first[1] * b.first[1], a.first[2] * b.first[2]),
        mat4x3f(a.more[0] * b.more[0], a.more[1] * b.more[1], a.more[2] * b.more[2], a.more[3] * b.more[3]),
    );
}

// The larger of two counts at each place, but at most `limit`.
fn at_most(a: vec3f, b: vec3f, limit: vec3f) -> vec3f {
    return clamp(max(a, b), vec3f(0.0), limit);
}

fn hidden_in_any(a: Places, b: Places, limit: Places) -> Places {
    return Places(
        mat3x3f(
            at_most(a.first[0], b.first[0], limit.first[0]),
            at_most(a.first[1], b.first[1], limit.first[1]),
            at_most(a.first[2], b.first[2], limit.first[2]),
        ),
        mat4x3f(
            at_most(a.more[0], b.more[0], limit.more[0]),
            at_most(a.more[1], b.more[1], limit.more[1]),
            at_most(a.more[2], b.more[2], limit.more[2]),
            at_most(a.more[3], b.more[3], limit.more[3]),
        ),
    );
}

// A layer's estimate of the hidden share, and how well its counts fit the hidden places.
struct Account {
    hidden: f32,
    fit: f32,
}

// Estimates the hidden share from the samples, corrected by the exact sum of coverages (a control variate).
// The correction is weighted by how well sample counts correlate with being hidden. Where nothing overlaps,
// sum and samples agree and the sum is the answer. Where everything is hidden twice, the sum says nothing.
//
// A caster that hides more of the light than the gap between two places hides some of the places as well. So the
// sum may add no more than the share of that gap. Without this limit it would add more where many casters hide the same
// rim of the light but no place.
//
// Source: regression with a control variate, as e.g. Owen 2013, "Monte Carlo theory, methods and examples",
// 8.9.
fn account(layer: Counts, is_hidden: Places) -> Account {
    // Share of the light that lies on one side of a line and holds no place, with a margin for thin casters. By eye.
    const UNSEEN = 0.15;
    let count = select(9.0, 21.0, IS_DENSE);
    // Weight of the prior slope (`believed`), which decides where all places have equal counts. By trial over
    // the models.
    const BELIEF = 0.25;
    let mean = sum_of(is_hidden) / count;
    let mean_count = sum_of(layer.hidden) / count;
    let together = sum_of(product(is_hidden, layer.hidden)) - count * mean * mean_count;
    let spread = max(sum_of(product(layer.hidden, layer.hidden)) - count * mean_count * mean_count, 0.0);
    let own_spread = count * mean * (1.0 - mean);
    let believed = select(1.0, clamp(mean / max(mean_count, 1e-6), 0.0, 1.0), mean_count > 0.05);
    let slope = clamp((together + BELIEF * believed) / (spread + BELIEF), 0.0, 1.0);
    let fit = (together * together + BELIEF * believed) / (spread * own_spread + BELIEF);
    return Account(mean + min(slope * (layer.covered - mean_count), UNSEEN), fit);
}

// The layer whose estimate fits better is used. Within this difference of fits the two are blended, so that
// none jumps.
const FIT_WIDTH: f32 = 0.4;

// Coverage of about one place of 21. Below it, a layer's share of what is hidden is not measured against more, because
// the places may hold none of it.
const LEAST_COVERED: f32 = 0.05;

fn sampled(pixel: vec2u, horizon: vec3f, over: f32) -> f32 {
    let is_above = places_above(horizon, Sampling(IS_SPHERE, IS_DENSE, PLACE_STEPS));
    let facing = counts(textureLoad(facing_sums, pixel, 0), textureLoad(facing_second, pixel, 0), over, is_above);
    let averted = counts(textureLoad(averted_sums, pixel, 0), textureLoad(averted_second, pixel, 0), over, is_above);
    let is_hidden = hidden_in_any(facing.hidden, averted.hidden, is_above);
    let by_facing = account(facing, is_hidden);
    let by_averted = account(averted, is_hidden);
    // A layer's fit counts by the share of what is hidden that this layer hides. Otherwise a layer that hides nothing
    // would fit best and take half of the other layer's correction away.
    let mean = sum_of(is_hidden) / select(9.0, 21.0, IS_DENSE);
    let most = max(mean, clamp(max(facing.covered, averted.covered), 1e-4, LEAST_COVERED));
    let known = clamp(vec2f(facing.covered, averted.covered) / most, vec2f(0.0), vec2f(1.0));
    let to_averted = clamp(0.5 + (known.y * by_averted.fit - known.x * by_facing.fit) / FIT_WIDTH, 0.0, 1.0);
    return clamp(mix(by_facing.hidden, by_averted.hidden, to_averted), 0.0, over);
}

// Share of the whole light that lies above the horizon, at least a little more than 0.
fn whole_above(pixel: vec2f) -> f32 {
    let half_size = select(light.half_size / light.place.zw, vec2f(light.whole.w), IS_SPHERE);
    let own_seat = seat_at(receiver_at(pixel), light.whole.xyz, half_size, IS_SPHERE);
    return max(above(own_seat.horizon, Maths(IS_SPHERE, false, false)).a, 1e-3);
}

fn above_here(horizon: vec3f) -> vec4f {
    return above(horizon, Maths(IS_SPHERE, false, IS_TEXTURED));
}

// Writes visibility. a: the visible share of the whole emitter. rgb: the visible share of that part of the
// emitter which is above the surface's horizon; the light pass already leaves out the part below it.
@fragment
fn resolve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let own_seat = seat(receiver_at(position.xy), IS_SPHERE);
    let over = above_here(own_seat.horizon);
    var covered = vec4f(0.0);
    if IS_SAMPLED {
        covered = vec4f(sampled(pixel, own_seat.horizon, over.a));
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

// Combines coverages halfway between no and full overlap. For two groups, equation 1 is the largest plus half of
// the smaller, which equals half of the sum plus half of the largest. The latter does not depend on the order of
// the groups if there are more than two. So xy holds the sum and zw the largest. The two layers are two estimates
// of one shadow, so each is combined by itself. Textured lights have no room for that; there the layer that hides
// more counts, and groups are combined one after the other.
// Source: Assarsson et al. 2003, equation 1.
@fragment
fn combine(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let own_seat = seat(receiver_at(position.xy), IS_SPHERE);
    let layers = summed(pixel, above_here(own_seat.horizon));
    let by_color = max(layers.facing, layers.averted);
    let before = textureLoad(combined, pixel, 0);
    if IS_TEXTURED {
        return max(before, by_color) + 0.5 * min(before, by_color);
    }
    let now = vec2f(layers.facing.a, layers.averted.a);
    return vec4f(before.xy + now, max(before.zw, now));
}
