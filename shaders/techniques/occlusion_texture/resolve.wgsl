// Visibility of each pixel from the filtered pictures of the casters' slices, written into the mask.
// Host    src/techniques/occlusion_texture/gpu/recorder.rs
// Groups  0 view, 1 receiver, 2 light, 3 pictures
// Spaces  as in kernel.wgsl
// Twin    techniques::occlusion_texture::{kernel, filter}
#import antumbra::receiver::{Receiver, receiver_at}
#import antumbra::occlusion_kernel::{OcclusionLight, Kernel, slice_weight, slice_plane, slice_kernel, Lookup, over_own_plane, combine, add_overlapping, OVERLAP, WIDER, BEGINS, WHOLE}

@group(2) @binding(0) var<uniform> light: OcclusionLight;
@group(3) @binding(0) var pictures: texture_2d_array<f32>;
@group(3) @binding(1) var between_texels: sampler;
// For OVERLAP alone, else the pictures again: what each slice and all slices before it cover together; and 2 less the depth of
// casters below the top of their slice, in thicknesses of the slice, where there are casters.
@group(3) @binding(2) var unions: texture_2d_array<f32>;
@group(3) @binding(3) var depths: texture_2d_array<f32>;
// The sparse levels of N-buffers of all three; for other filters the pictures again.
@group(3) @binding(4) var sparse_pictures: texture_2d_array<f32>;
@group(3) @binding(5) var sparse_unions: texture_2d_array<f32>;
@group(3) @binding(6) var sparse_depths: texture_2d_array<f32>;

override SLICES: u32 = 1u;
override FACES: u32 = 1u;
override COMBINE: u32 = 0u;
override FILTER: u32 = 0u;
// Casters fill the next slice too.
override CLOSE: bool = false;

// Values of FILTER: techniques::occlusion_texture::SliceFilter in its order.
const N_BUFFERS: u32 = 0u;          // mirror: techniques::occlusion_texture::SliceFilter::NBuffers
const MIPMAPS: u32 = 1u;            // mirror: techniques::occlusion_texture::SliceFilter::Mipmaps
const SUMMED_AREAS: u32 = 2u;       // mirror: techniques::occlusion_texture::SliceFilter::SummedAreas

// Values of Picture.shows: what each slice covers, what it and all before it cover, and depths.
const COVERAGE: u32 = 0u;
const UNIONS: u32 = 1u;
const DEPTHS: u32 = 2u;

// The picture of one slice: a channel of a layer, or of several layers with levels.
struct Picture {
    face: u32,
    group: u32,
    channel: u32,
    shows: u32,
}

// The value of a picture in a texel of its layer, and that of the slice before it if that is in the same layer.
fn picked(texel: vec4f, picture: Picture) -> vec2f {
    return vec2f(texel[picture.channel], texel[max(picture.channel, 1u) - 1u]);
}

fn group_count() -> u32 {
    return (SLICES + 3u) / 4u;
}

// Share of a picture's side that a texel takes. The side is a power of two, so this is exact.
fn texel() -> f32 {
    return 1.0 / light.limits.z;
}

// The part of a kernel that is as wide as the picture at most, moved to where the kernel covers the picture.
fn narrowed(kernel: Kernel) -> Kernel {
    let room = max(kernel.half - 0.5, vec2f(0.0));
    return Kernel(kernel.center - clamp(kernel.center - 0.5, -room, room), min(kernel.half, vec2f(0.5)));
}

// Share of a kernel that `narrowed` leaves.
fn narrowed_share(kernel: Kernel) -> f32 {
    let wider = max(2.0 * kernel.half, vec2f(1.0));
    return 1.0 / (wider.x * wider.y);
}

// Share of a kernel around the nearest place inside the picture that a kernel beyond the border still reaches.
fn share_inside(kernel: Kernel) -> f32 {
    let beyond = abs(kernel.center - 0.5) - 0.5;
    let left = 1.0 - max(beyond / max(kernel.half, vec2f(0.5 * texel())), vec2f(0.0));
    return max(left.x, 0.0) * max(left.y, 0.0);
}

// Highest level of N-buffers that has a value at every texel. Each level above has half as many along a side as the one below.
const DENSE_LEVEL: u32 = 3u;        // mirror: techniques::occlusion_texture::filter::DENSE_LEVEL

// A value between those of a dense level. Levels are layers.
fn dense_texel(picture: Picture, place: vec2f, level: u32) -> vec4f {
    let layer = (picture.face * (DENSE_LEVEL + 1u) + level) * group_count() + picture.group;
    switch picture.shows {
        case UNIONS: {
            return textureSampleLevel(unions, between_texels, place, layer, 0.0);
        }
        case DEPTHS: {
            return textureSampleLevel(depths, between_texels, place, layer, 0.0);
        }
        default: {
            return textureSampleLevel(pictures, between_texels, place, layer, 0.0);
        }
    }
}

// A value between those of a sparse level. Levels are mips.
fn sparse_texel(picture: Picture, place: vec2f, level: u32) -> vec4f {
    let layer = picture.face * group_count() + picture.group;
    let mip = f32(level - DENSE_LEVEL - 1u);
    switch picture.shows {
        case UNIONS: {
            return textureSampleLevel(sparse_unions, between_texels, place, layer, mip);
        }
        case DEPTHS: {
            return textureSampleLevel(sparse_depths, between_texels, place, layer, mip);
        }
        default: {
            return textureSampleLevel(sparse_pictures, between_texels, place, layer, mip);
        }
    }
}

// Means over the square of a level of N-buffers around a place, in texels of the picture.
fn square_mean(picture: Picture, place: vec2f, level: u32) -> vec2f {
    let apart = f32(1u << (max(level, DENSE_LEVEL) - DENSE_LEVEL));
    // The square around the place begins half its side before it. The first texel, whose middle is half of `apart` from the
    // border, holds the mean of the square that begins at the border.
    let corner = place - 0.5 * f32(1u << level);
    let middle = (corner + 0.5 * apart) * texel();
    // The last value is followed by those of squares outside the picture, which are 0.
    let inside = clamp((light.limits.z - corner) / apart, vec2f(0.0), vec2f(1.0));
    var mean = vec4f(0.0);
    if level > DENSE_LEVEL {
        mean = sparse_texel(picture, middle, level);
    } else {
        mean = dense_texel(picture, middle, level);
    }
    return picked(mean, picture) * inside.x * inside.y;
}

fn n_buffer_mean(picture: Picture, kernel: Kernel) -> vec2f {
    let side = light.limits.z;
    let last = u32(light.limits.w) - 1u;
    let taps = light.half_up.w;
    let size = 2.0 * kernel.half * side;
    let long = max(max(size.x, size.y), 1.0);
    let square = min(max(max(min(size.x, size.y), 1.0), long / taps), side);
    let level = min(u32(log2(square)), last);
    let between = clamp(square / f32(1u << level) - 1.0, 0.0, 1.0);
    let along = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), size.x > size.y) * max(long - square, 0.0);
    let spread = taps / max(taps - 1.0, 1.0);
    let center = clamp(kernel.center, vec2f(0.0), vec2f(1.0)) * side;
    var sum = vec2f(0.0);
    for (var tap = 0.0; tap < taps; tap += 1.0) {
        let place = center + along * (((tap + 0.5) / taps - 0.5) * spread);
        let fine = square_mean(picture, place, level);
        let coarse = square_mean(picture, place, min(level + 1u, last));
        // Squares cannot begin before the picture. The larger one fades out where it would, since it would find casters
        // beyond the kernel instead of the empty border.
        let start = clamp(place / (0.5 * f32(1u << level)) - 1.0, vec2f(0.0), vec2f(1.0));
        sum += mix(fine, coarse, between * start.x * start.y);
    }
    return sum / taps * share_inside(kernel);
}

// Side of the texels whose bilinear mean has the variance of a box of side 1: a texel's own variance of side² / 12, and that
// of the weights between texels, side² / 6, are 1 / 12 together.
const SMOOTHED: f32 = 0.57735;      // mirror: techniques::occlusion_texture::filter::SMOOTHED

fn mipmap_mean(picture: Picture, kernel: Kernel) -> vec2f {
    let layer = picture.face * group_count() + picture.group;
    let size = max(2.0 * SMOOTHED * kernel.half, vec2f(texel()));
    let center = clamp(kernel.center, vec2f(0.0), vec2f(1.0));
    let dx = vec2f(size.x, 0.0);
    let dy = vec2f(0.0, size.y);
    let share = share_inside(kernel);
    switch picture.shows {
        case UNIONS: {
            return picked(textureSampleGrad(unions, between_texels, center, layer, dx, dy), picture) * share;
        }
        case DEPTHS: {
            return picked(textureSampleGrad(depths, between_texels, center, layer, dx, dy), picture) * share;
        }
        default: {
            return picked(textureSampleGrad(pictures, between_texels, center, layer, dx, dy), picture) * share;
        }
    }
}

// Sum over all texels before a corner of the grid.
fn corner_sum(picture: Picture, x: f32, y: f32) -> vec2f {
    let last = i32(light.limits.z) - 1;
    let texel = vec2i(i32(x), i32(y)) - 1;
    if any(texel < vec2i(0)) {
        return vec2f(0.0);
    }
    let inside = min(texel, vec2i(last));
    let layer = picture.face * group_count() + picture.group;
    switch picture.shows {
        case UNIONS: {
            return picked(textureLoad(unions, inside, layer, 0), picture);
        }
        case DEPTHS: {
            return picked(textureLoad(depths, inside, layer, 0), picture);
        }
        default: {
            return picked(textureLoad(pictures, inside, layer, 0), picture);
        }
    }
}

// Sums are large; their differences are small and exact, so they are taken before anything is interpolated.
fn column_sum(picture: Picture, x: f32, y_from: f32, y_to: f32) -> vec2f {
    let low = floor(y_from);
    let high = floor(y_to);
    let at_low = corner_sum(picture, x, low);
    let at_high = corner_sum(picture, x, high);
    return (at_high - at_low) + (y_to - high) * (corner_sum(picture, x, high + 1.0) - at_high)
        - (y_from - low) * (corner_sum(picture, x, low + 1.0) - at_low);
}

fn summed_mean(picture: Picture, kernel: Kernel) -> vec2f {
    let side = light.limits.z;
    let half = max(kernel.half * side, vec2f(0.5));
    let center = kernel.center * side;
    let start = clamp(center - half, vec2f(0.0), vec2f(side));
    let end = clamp(center + half, vec2f(0.0), vec2f(side));
    let x_from = floor(start.x);
    let x_to = floor(end.x);
    let first = column_sum(picture, x_from, start.y, end.y);
    let last = column_sum(picture, x_to, start.y, end.y);
    let sum = (last - first) + (end.x - x_to) * (column_sum(picture, x_to + 1.0, start.y, end.y) - last)
        - (start.x - x_from) * (column_sum(picture, x_from + 1.0, start.y, end.y) - first);
    return sum / (4.0 * half.x * half.y);
}

// Means of a picture over a kernel, and of the slice before it if that is in the same layer.
fn mean_over(picture: Picture, kernel: Kernel) -> vec2f {
    if FILTER == SUMMED_AREAS {
        return summed_mean(picture, kernel);
    }
    let part = narrowed(kernel);
    if FILTER == MIPMAPS {
        return mipmap_mean(picture, part) * narrowed_share(kernel);
    }
    return n_buffer_mean(picture, part) * narrowed_share(kernel);
}

// Mean depth of a slice's casters below its top, in thicknesses of the slice. They cover a share of the kernel.
fn mean_depth(shown: Picture, kernel: Kernel, cover: f32) -> f32 {
    return clamp(2.0 - mean_over(shown, kernel).x / cover, 0.0, 1.0);
}

// Adds one more slice to the hidden share that the slices before it left. Unions are looked up only where they matter.
fn add_measured(hidden: f32, weight: f32, own: f32, picture: Picture, kernel: Kernel) -> f32 {
    if hidden <= 0.0 || weight <= 0.0 {
        return clamp(hidden + weight * own, 0.0, 1.0);
    }
    let united = mean_over(Picture(picture.face, picture.group, picture.channel, UNIONS), kernel);
    var above = united.y;
    if picture.channel == 0u {
        // Something is hidden, so there is a group of slices before.
        above = mean_over(Picture(picture.face, picture.group - 1u, 3u, UNIONS), kernel).x;
    }
    return add_overlapping(hidden, weight, own, above, united.x);
}

// Depth at which a slice ends.
fn bottom_of(face: u32, slice: u32) -> f32 {
    return light.faces[face].bottoms[slice / 4u][slice % 4u];
}

// Depth at which a slice begins.
fn top_of(face: u32, slice: u32) -> f32 {
    if slice == 0u {
        return light.faces[face].depth.z;
    }
    return bottom_of(face, slice - 1u);
}

// A lookup in a slice's picture whose casters are taken to be at one depth.
fn lookup_at(face: u32, slice: u32, plane: f32) -> Lookup {
    let first = select(slice, max(slice, 1u) - 1u, CLOSE);
    return Lookup(top_of(face, first), bottom_of(face, slice), plane, light.limits.z, light.half_up.w);
}

// The light as a receiver sees it through the plane of a lookup.
fn kernel_at(face: u32, at: Lookup, receiver: vec3f) -> Kernel {
    return slice_kernel(light.faces[face].projection, light.faces[face].depth, light.kernel, receiver, at.plane);
}

// The part of a kernel that does not show the receiver's own plane.
fn cut_kernel(face: u32, at: Lookup, receiver: vec3f, normal: vec3f, kernel: Kernel) -> Kernel {
    return over_own_plane(light.faces[face], at, receiver, normal, kernel);
}

// Share of the light that the slices of one picture hide, from the depths and overlaps of their casters.
fn measured_share(face: u32, receiver: vec3f, normal: vec3f) -> f32 {
    var hidden = 0.0;
    for (var slice = 0u; slice < SLICES; slice++) {
        let top = top_of(face, slice);
        if receiver.z <= top {
            break;
        }
        let bottom = bottom_of(face, slice);
        let covered = Picture(face, slice / 4u, slice % 4u, COVERAGE);
        let shown = Picture(face, slice / 4u, slice % 4u, DEPTHS);
        // Where the slice's casters are, around the kernel in the middle of the slice.
        var at = lookup_at(face, slice, 0.5 * (top + min(bottom, receiver.z)));
        let middle = kernel_at(face, at, receiver);
        let around = cut_kernel(face, at, receiver, normal, Kernel(middle.center, WIDER * middle.half));
        let cover = mean_over(covered, around).x;
        if cover <= 0.0 {
            continue;
        }
        at.plane = mix(top, bottom, mean_depth(shown, around, cover));
        if at.plane >= receiver.z {
            continue;
        }
        var kernel = kernel_at(face, at, receiver);
        // In the receiver's slice, depths tell its own surface from others, unless the slice before fills it.
        if CLOSE || receiver.z > bottom {
            kernel = cut_kernel(face, at, receiver, normal, kernel);
        }
        let own = mean_over(covered, kernel).x;
        if own <= 0.0 {
            continue;
        }
        var weight = 1.0;
        let thickness = bottom - top;
        if receiver.z < bottom + WHOLE * thickness {
            let inside = mix(top, bottom, mean_depth(shown, kernel, own));
            weight = slice_weight(inside + BEGINS * thickness, (WHOLE - BEGINS) * thickness, receiver.z);
        }
        hidden = add_measured(hidden, weight, own, covered, kernel);
    }
    return hidden;
}

// Share of the light that the slices of one picture hide, by the paper's combinations.
fn combined_share(face: u32, receiver: vec3f, normal: vec3f) -> f32 {
    var hidden = 0.0;
    for (var slice = 0u; slice < SLICES; slice++) {
        let bottom = bottom_of(face, slice);
        if receiver.z <= bottom {
            break;
        }
        var behind = light.faces[face].depth.w;         // thickness of the slice behind
        if slice + 1u < SLICES {
            behind = bottom_of(face, slice + 1u) - bottom;
        }
        let weight = slice_weight(bottom, behind, receiver.z);
        let at = lookup_at(face, slice, slice_plane(top_of(face, slice), bottom, weight));
        let kernel = cut_kernel(face, at, receiver, normal, kernel_at(face, at, receiver));
        let mean = mean_over(Picture(face, slice / 4u, slice % 4u, COVERAGE), kernel).x;
        hidden = combine(COMBINE, hidden, clamp(weight * mean, 0.0, 1.0));
    }
    return hidden;
}

// Share of the light that the slices of one picture hide.
fn hidden_share(face: u32, receiver: vec3f, normal: vec3f) -> f32 {
    if COMBINE == OVERLAP {
        return measured_share(face, receiver, normal);
    }
    return combined_share(face, receiver, normal);
}

// Share of the light that is above the receiver's horizon, as if the light were as long in all directions as it is along
// the normal.
fn share_above(receiver: Receiver) -> f32 {
    let n = receiver.normal;
    let to_light = light.point_relative.xyz - receiver.position * light.point_relative.w;
    let height = dot(n, to_light);
    let extent = abs(dot(n, light.half_right.xyz)) + abs(dot(n, light.half_up.xyz)) + light.half_right.w;
    let share = clamp(0.5 + 0.5 * height / max(extent, 1e-20), 0.0, 1.0);
    return select(share, 1.0, all(n == vec3f(0.0)) || extent == 0.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let receiver = receiver_at(position.xy);
    // No surface is there, or it is out of the light's reach: the value is not used.
    if receiver.depth == 0.0 || receiver.depth > light.limits.x || receiver.depth < light.limits.y {
        return vec4f(1.0);
    }
    let p = vec4f(receiver.position, 1.0);
    var face = 0u;
    var along = dot(light.faces[0].row_z, p);
    for (var other = 1u; other < FACES; other++) {
        let along_other = dot(light.faces[other].row_z, p);
        face = select(face, other, along_other > along);
        along = max(along, along_other);
    }
    let in_light = vec3f(dot(light.faces[face].row_x, p), dot(light.faces[face].row_y, p), along);
    let rows = transpose(mat3x3f(
        light.faces[face].row_x.xyz,
        light.faces[face].row_y.xyz,
        light.faces[face].row_z.xyz,
    ));
    let seen = clamp(1.0 - hidden_share(face, in_light, rows * receiver.normal), 0.0, 1.0);
    return vec4f(vec3f(seen), seen * share_above(receiver));
}
