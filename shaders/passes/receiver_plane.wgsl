// The plane of the triangle that each pixel shows, for techniques that compare points in that plane. The
// depth test is "equal", so triangles that were discarded or culled are not drawn.
// Host    src/render/nodes/receiver_plane.rs
// Groups  0 view, 2 material (not read)
#import antumbra::view::to_eye
#import antumbra::surface::{VertexIn, Fragment, surface_vertex}
#import antumbra::receiver::{octahedral_from_unit, unit_from_octahedral, NO_PLANE}

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

// The derivatives of a position lie in its triangle. Unlike a normal from the depth of adjacent pixels, they
// do not depend on neighbouring triangles.
@fragment
fn fragment(in: Fragment) -> @location(0) vec2u {
    let p = in.position_relative;
    let dx = dpdx(p);
    let dy = dpdy(p);
    // The derivatives are scaled before they are multiplied, because squares of millimetres leave the range
    // of an f32.
    let longest = max(max(length(dx), length(dy)), 1e-30);
    let across = cross(dx / longest, dy / longest);
    let size = length(across);
    if !(size > 1e-9) {
        return vec2u(NO_PLANE, 0u);
    }
    let seen = across * (select(-1.0, 1.0, dot(across, to_eye(p)) > 0.0) / size);
    let packed = pack2x16snorm(octahedral_from_unit(seen));
    // The offset is computed from the normal as it will be read, so that the plane goes through the point.
    let normal = unit_from_octahedral(unpack2x16snorm(packed));
    return vec2u(packed, bitcast<u32>(dot(normal, p)));
}
