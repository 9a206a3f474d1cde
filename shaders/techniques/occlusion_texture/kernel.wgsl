// The rectangle of each slice through which a receiver sees the light, and how the slices' hidden shares are combined.
// Host    src/techniques/occlusion_texture/records.rs
// Spaces  relative: world axes, origin at the eye
//         light: origin at the light, x right, y up, z away from the light
// Twin    techniques::occlusion_texture::kernel, functions of the same names
// Source: Eisemann & Décoret 2008, "Occlusion Textures for Plausible Soft Shadows": eq. 4, eq. 5, §3.4.
#define_import_path antumbra::occlusion_kernel

struct OcclusionFace {              // mirror: techniques::occlusion_texture::records::OcclusionFace
    row_x: vec4f,                   // rows of the transform from relative to light
    row_y: vec4f,
    row_z: vec4f,
    projection: vec4f,              // scales of x and y, then offsets of x and y
    depth: vec4f,                   // divisor of the projection: x z + y; top of the first slice; thickness behind the last
    bottoms: array<vec4f, 4>,       // depth at which each slice ends
}

struct OcclusionLight {             // mirror: techniques::occlusion_texture::records::OcclusionLight
    faces: array<OcclusionFace, 6>,
    kernel: vec4f,                  // half of the kernel's sides on the light; 1: at a position; 1: a sphere
    point_relative: vec4f,          // the light as a homogeneous point
    half_right: vec4f,              // half of the first side; radius of a sphere, or sine of half the angle
    half_up: vec4f,                 // half of the second side; squares of a lookup in N-buffers
    limits: vec4f,                  // nearest and farthest depth; texels along a side; levels that are built
}

// Values of COMBINE: techniques::occlusion_texture::SliceCombination in its order.
const PRODUCT: u32 = 0u;            // mirror: techniques::occlusion_texture::SliceCombination::Product
const MAXIMUM: u32 = 1u;            // mirror: techniques::occlusion_texture::SliceCombination::Maximum
const SUM: u32 = 2u;                // mirror: techniques::occlusion_texture::SliceCombination::Sum
const OVERLAP: u32 = 3u;            // mirror: techniques::occlusion_texture::SliceCombination::Overlap

// A rectangle of a slice's picture: the light as it is projected through a receiver.
struct Kernel {
    center: vec2f,                  // 0..1 inside the picture, from the upper left
    half: vec2f,                    // half of the sides
}

// Share of a slice's shadow that a receiver at a depth gets. A slice fades in over the thickness of the slice behind it.
fn slice_weight(bottom: f32, thickness: f32, depth: f32) -> f32 {
    return clamp((depth - bottom) / max(thickness, 1e-30), 0.0, 1.0);
}

// Depth at which the casters of a slice are taken to be: where the slice ends for a receiver just behind it, and in its
// middle for receivers that get its whole shadow.
fn slice_plane(top: f32, bottom: f32, weight: f32) -> f32 {
    return bottom - 0.5 * weight * (bottom - top);
}

// Texels around a kernel that its lookup touches, with the half texel by which what was drawn may be off.
const TOUCHED: f32 = 1.5;           // mirror: techniques::occlusion_texture::kernel::TOUCHED

// The rectangle at a depth through which a receiver behind it, in light space, sees the light, in the slice's picture.
fn slice_kernel(projection: vec4f, depth: vec4f, light: vec4f, receiver: vec3f, plane: f32) -> Kernel {
    let behind = max(receiver.z - plane, 0.0);
    let at_position = light.z > 0.5;
    let middle = receiver.xy * select(1.0, plane / receiver.z, at_position);
    // A sphere that is seen at an angle casts a longer cone on the slice.
    let slope = receiver.xy / receiver.z;
    let longer = select(vec2f(1.0), sqrt(1.0 + slope * slope), light.w > 0.5);
    let half = light.xy * longer * (behind / select(1.0, receiver.z, at_position));
    let scale = projection.xy / (depth.x * plane + depth.y);
    let ndc = middle * scale + projection.zw;
    return Kernel(ndc * vec2f(0.5, -0.5) + 0.5, half * scale * 0.5);
}

// Where a slice is, and how finely a lookup sees it.
struct Lookup {
    top: f32,                       // depth at which casters of the slice begin
    bottom: f32,
    plane: f32,                     // depth at which they are taken to be
    side: f32,                      // texels of the picture
    taps: f32,                      // squares of a lookup in N-buffers
}

// The part of a kernel that shows no surface in the receiver's own plane: a flat surface hides nothing from itself. Taking the
// casters of a slice to be at one depth moves them along the rays of the picture, into the room before their plane wherever
// these rays are not in the plane. The kernel's lower side is raised above them and above the texels that a lookup touches.
fn over_own_plane(face: OcclusionFace, at: Lookup, receiver: vec3f, normal: vec3f, kernel: Kernel) -> Kernel {
    let is_along_x = abs(normal.x) > abs(normal.y);
    let steepness = select(normal.y, normal.x, is_along_x);
    if abs(steepness) < 1e-4 {
        return kernel;
    }
    let divisors = face.depth.x * vec3f(at.top, at.bottom, at.plane) + face.depth.y;
    let metres = 2.0 * divisors.z / face.projection.xy;     // sides of the picture at the plane
    let ndc = (kernel.center - 0.5) * vec2f(2.0, -2.0) - face.projection.zw;
    let middle = vec3f(0.5 * metres * ndc, at.plane);
    // A lookup covers at least this.
    let least = vec2f(max(max(kernel.half.x, kernel.half.y) / at.taps, 0.5 / at.side));
    let half = max(kernel.half, least);
    let lowest = dot(normal, middle - receiver) - dot(abs(normal.xy), half * metres);
    // Height that a point in the plane gains for each metre by which it is moved, times the divisor where it was.
    let rate = face.depth.x * dot(normal, receiver) + face.depth.y * normal.z;
    let gained = (at.plane - vec2f(at.top, at.bottom)) * rate / divisors.xy;
    let texel = max(metres.x, metres.y) / at.side;
    let missing = max(max(gained.x, gained.y), 0.0) + TOUCHED * texel * length(normal.xy) - lowest;
    if missing <= 0.0 {
        return kernel;
    }
    let axis = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), is_along_x);
    let cut = missing / (abs(steepness) * dot(axis, metres));
    let full = dot(axis, half);
    let left = max(full - 0.5 * cut, dot(axis, least));
    let upwards = vec2f(1.0, -1.0) * axis * sign(steepness);
    return Kernel(kernel.center + upwards * (cut + left - full), mix(kernel.half, min(kernel.half, vec2f(left)), axis));
}

// Adds the hidden share that one more slice leaves to what the slices before it left.
fn combine(combination: u32, hidden: f32, more: f32) -> f32 {
    if combination == MAXIMUM {
        return max(hidden, more);
    }
    if combination == SUM {
        return min(hidden + more, 1.0);
    }
    return 1.0 - (1.0 - hidden) * (1.0 - more);
}

// How much wider than a kernel the rectangle is in which the depth of its casters is looked for.
const WIDER: f32 = 2.0;             // mirror: techniques::occlusion_texture::kernel::WIDER

// Distances behind a caster at which its shadow begins and at which it is whole, in thicknesses of the caster's slice.
const BEGINS: f32 = 0.15;           // mirror: techniques::occlusion_texture::kernel::BEGINS
const WHOLE: f32 = 0.75;            // mirror: techniques::occlusion_texture::kernel::WHOLE

// Adds one more slice to the hidden share that the slices before it left. `own` is the share of the kernel that the slice covers,
// `above` the share that all slices before it cover in the pictures, and `united` the share that any of these cover.
fn add_overlapping(hidden: f32, weight: f32, own: f32, above: f32, united: f32) -> f32 {
    let beside = max(united - above, 0.0);
    let behind = max(own - beside, 0.0);
    let among_behind = beside + behind * (1.0 - hidden / max(above, 1e-6));
    let among_beside = beside * (1.0 - hidden) / max(1.0 - above, 1e-6);
    return clamp(hidden + weight * select(among_beside, among_behind, hidden < above), 0.0, 1.0);
}
