//! The part of a light from which an edge is a silhouette edge. The planes of the edge's triangles bound it.

use glam::{DVec3, DVec4};

/// The part of the light from which an edge is a silhouette edge; by default the whole light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sight {
    /// Planes through the edge that bound the part: `dot(xyz, p) + w`, light space.
    pub planes: [Option<DVec4>; 2],
    /// Whether the light's centre is outside of the part.
    pub is_beside: bool,
}

/// Returns the signed distance from a plane, times the length of the plane's normal.
pub(in crate::techniques::penumbra_wedge) fn side(plane: DVec4) -> impl Fn(DVec3) -> f64 {
    move |point| plane.truncate().dot(point) + plane.w
}

/// Orients a plane so that the origin is on its positive side.
pub(in crate::techniques::penumbra_wedge) fn towards_center(plane: DVec4) -> DVec4 {
    if plane.w < 0.0 { -plane } else { plane }
}

/// Share of the light's extent by which slivers are wider than the sight. A point in the plane of a triangle,
/// above all on the triangle itself, counts as seen from the centre, and the rasterizer moves it by up to
/// 1/512 of a pixel.
pub(in crate::techniques::penumbra_wedge) const SLIVER_MARGIN: f64 = 0.1;

/// Turns a plane through the edge about the edge by an angle, away from the origin or towards it. The origin
/// is on the plane's positive side, and a turn towards it stops there.
pub(in crate::techniques::penumbra_wedge) fn turned(
    plane: DVec4,
    [a, b]: [DVec3; 2],
    angle: f64,
    away: bool,
) -> DVec4 {
    let normal = plane.truncate();
    let across = (b - a).normalize_or_zero().cross(normal) * angle.tan();
    let through_edge = |normal: DVec3| normal.normalize_or_zero().extend(0.0);
    let [one, other] = [normal + across, normal - across].map(|normal| {
        let plane = through_edge(normal);
        plane.truncate().extend(-plane.truncate().dot(a))
    });
    let (nearer, farther) = if one.w < other.w {
        (one, other)
    } else {
        (other, one)
    };
    match (away, nearer.w < 0.0) {
        (true, _) => farther,
        (false, false) => nearer,
        (false, true) => {
            let separator = a.cross(b).normalize_or_zero();
            through_edge(separator * separator.dot(normal).signum())
        }
    }
}

/// Returns the distance from the origin to the line through both ends.
pub(in crate::techniques::penumbra_wedge) fn distance_of_line([a, b]: [DVec3; 2]) -> f64 {
    let along = (b - a).normalize_or_zero();
    (a - along * a.dot(along)).length()
}

/// Whether the line of the edge passes beside the light: it meets the light's plane farther from the centre
/// than the light reaches, or not at all.
pub(in crate::techniques::penumbra_wedge) fn passes_clear([a, b]: [DVec3; 2], corners: [DVec3; 4]) -> bool {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
    let reach = corners
        .iter()
        .map(|corner| corner.length_squared())
        .fold(0.0, f64::max);
    let (at_a, at_b) = (normal.dot(a), normal.dot(b));
    let meeting = a + (b - a) * (at_a / (at_a - at_b));
    // The negation is also true where there is no meeting.
    !(meeting.length_squared() <= 1.01 * reach)
}
