// Lambertian area lights: the irradiance that they give to a surface, in closed form, and the point of the
// light that a mirror shows. Tested against numerical integration by tests/gpu/area_lights.rs.
#define_import_path antumbra::area_light

#import antumbra::conventions::PI

// Smallest extent of a light, as a share of its distance; smaller lights count as this large. Below it,
// differences of directions vanish in rounding. It changes the irradiance of a point by 1e-5.
const LEAST_EXTENT: f32 = 0.004;

// Twice the irradiance that the edge from a to b of a polygon gives to a plane. Directions need not be unit
// vectors.
fn edge_integral(a: vec3f, b: vec3f, normal: vec3f) -> f32 {
    let axis = cross(a, b);
    let size = length(axis);
    return atan2(size, dot(a, b)) * dot(axis, normal) / max(size, 1e-20);
}

// Irradiance on a surface with normal `normal` from a rectangle of 1 candela along its axis. `to_light` goes
// from the surface to the centre. The polygon is cut at the horizon edge by edge. It is convex, so it leaves
// and enters the upper side at most once, and one more edge along the horizon closes it.
// Source: Lambert 1760; as a sum over edges e.g. Baum, Rushmeier & Winget 1989, "Improving Radiosity
// Solutions Through the Use of Analytically Determined Form-Factors".
fn rect_irradiance(to_light: vec3f, distance: f32, half_right: vec3f, half_up: vec3f, axis: vec3f, normal: vec3f) -> f32 {
    let least = LEAST_EXTENT * distance;
    let right_size = max(length(half_right), 1e-20);
    let up_size = max(length(half_up), 1e-20);
    let width = max(right_size, least);
    let height = max(up_size, least);
    let right = half_right * (width / right_size);
    let up = half_up * (height / up_size);
    // The corners are counter-clockwise as seen from the lit side.
    var corners = array<vec3f, 4>(
        to_light + right + up,
        to_light + right - up,
        to_light - right - up,
        to_light - right + up,
    );
    var sum = 0.0;
    var leaves = vec3f(0.0);
    var enters = vec3f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let a = corners[i];
        let b = corners[(i + 1u) % 4u];
        let over_a = dot(a, normal);
        let over_b = dot(b, normal);
        let crossing = mix(a, b, over_a / (over_a - over_b)); // used only where the signs differ
        let start = select(crossing, a, over_a >= 0.0);
        let end = select(crossing, b, over_b >= 0.0);
        sum += select(0.0, edge_integral(start, end, normal), over_a >= 0.0 || over_b >= 0.0);
        leaves = select(leaves, crossing, over_a >= 0.0 && over_b < 0.0);
        enters = select(enters, crossing, over_a < 0.0 && over_b >= 0.0);
    }
    sum += edge_integral(leaves, enters, normal);
    let radiance = 0.25 / (width * height);
    return select(0.0, 0.5 * radiance * abs(sum), dot(to_light, axis) < 0.0);
}

// Irradiance on a surface with normal `normal` from a sphere of 1 candela, cut at the horizon.
// Source: Snyder 1996, "Area Light Sources for Real-Time Graphics"; in this form Lagarde & de Rousiers 2014,
// "Moving Frostbite to Physically Based Rendering", section 4.7.2.
fn sphere_irradiance(towards: vec3f, distance: f32, radius: f32, normal: vec3f) -> f32 {
    let size = max(radius, LEAST_EXTENT * distance);
    let sin_sq = min(size * size / (distance * distance), 0.9999);
    let cosine = clamp(dot(normal, towards), -1.0, 1.0);
    let sine = sqrt(max(1.0 - cosine * cosine, 1e-12));
    let whole = PI * sin_sq * max(cosine, 0.0);
    let x = sqrt(1.0 / sin_sq - 1.0);
    let y = clamp(-x * (cosine / sine), -1.0, 1.0);
    let side = sine * sqrt(1.0 - y * y);
    let cut = (cosine * acos(y) - x * side) * sin_sq + atan(side / x);
    let share = select(max(cut, 0.0), whole, cosine * cosine > sin_sq);
    return select(share / (PI * size * size), 0.0, cosine < 0.0 && cosine * cosine > sin_sq);
}

// The point of a rectangle nearest to where a mirrored ray meets its plane, relative to the surface.
// Source: Karis 2013, "Real Shading in Unreal Engine 4": a representative point.
fn rect_highlight(to_light: vec3f, distance: f32, half_right: vec3f, half_up: vec3f, axis: vec3f, mirrored: vec3f) -> vec3f {
    let slope = dot(mirrored, axis);
    let along = dot(to_light, axis) / select(slope, -1e-4, slope > -1e-4);
    // A ray that leaves the plane stops at the point where it passes nearest to the centre.
    let reach = select(max(dot(mirrored, to_light), 0.0), along, slope < -1e-4 && along > 0.0);
    let offset = mirrored * min(reach, 1e4 * distance) - to_light;
    let right = clamp(dot(offset, half_right) / max(dot(half_right, half_right), 1e-20), -1.0, 1.0);
    let up = clamp(dot(offset, half_up) / max(dot(half_up, half_up), 1e-20), -1.0, 1.0);
    return to_light + half_right * right + half_up * up;
}

// The point of a sphere nearest to a mirrored ray, relative to the surface.
// Source: Karis 2013, "Real Shading in Unreal Engine 4": a representative point.
fn sphere_highlight(to_light: vec3f, radius: f32, mirrored: vec3f) -> vec3f {
    let to_ray = mirrored * dot(to_light, mirrored) - to_light;
    return to_light + to_ray * clamp(radius * inverseSqrt(max(dot(to_ray, to_ray), 1e-20)), 0.0, 1.0);
}
