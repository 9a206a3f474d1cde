//! From where on a light an edge is one of the silhouette: between the planes of the triangles beside it.

use glam::{DVec3, DVec4};

/// From where on the light an edge is one of the silhouette; by default from everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sight {
    /// Planes through the edge that bound that part: `dot(xyz, p) + w`, light space.
    pub planes: [Option<DVec4>; 2],
    /// The light's centre is not in the part.
    pub is_beside: bool,
}

/// Signed distance from a plane, times the length of its normal.
pub(in crate::techniques::penumbra_wedge) fn side(plane: DVec4) -> impl Fn(DVec3) -> f64 {
    move |point| plane.truncate().dot(point) + plane.w
}

/// The plane with the origin on its positive side.
pub(in crate::techniques::penumbra_wedge) fn towards_center(plane: DVec4) -> DVec4 {
    if plane.w < 0.0 { -plane } else { plane }
}

/// Share of the light's extent by which slivers are wider than the sight: what lies in the plane of a triangle, above all
/// its own surface, counts as seen from the centre, and the rasterizer moves it by up to 1/512 of a pixel.
pub(in crate::techniques::penumbra_wedge) const SLIVER_MARGIN: f64 = 0.1;

/// A plane through the edge, turned about it by an angle: away from the origin, which is on its positive side, or towards
/// it; no farther than to it.
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

/// Of the line through both ends from the origin.
pub(in crate::techniques::penumbra_wedge) fn distance_of_line([a, b]: [DVec3; 2]) -> f64 {
    let along = (b - a).normalize_or_zero();
    (a - along * a.dot(along)).length()
}

/// Whether the line of the edge meets the light's plane farther from the centre than the light reaches, if at all.
pub(in crate::techniques::penumbra_wedge) fn passes_clear([a, b]: [DVec3; 2], corners: [DVec3; 4]) -> bool {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
    let reach = corners
        .iter()
        .map(|corner| corner.length_squared())
        .fold(0.0, f64::max);
    let (at_a, at_b) = (normal.dot(a), normal.dot(b));
    let meeting = a + (b - a) * (at_a / (at_a - at_b));
    // Also where there is no meeting.
    !(meeting.length_squared() <= 1.01 * reach)
}
