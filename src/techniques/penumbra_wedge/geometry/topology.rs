//! Which triangles a wedge consists of: one index list for all wedges.
//!
//! A wedge has named vertices. The list has four consecutive parts, all wound with their front out of the half that they
//! close:
//!
//! ```text
//! [ separator, front to the inner half | outer shell | inner shell | separator, front to the outer half ]
//!   └────────── outer half ──────────┘               └───────────── inner half ──────────────────────┘
//!                                        └─── shells ───┘
//! ```
//!
//! The separator consists of the side of the hard shadow's volume and, on either side of it, the triangles
//! that close the halves (figure 2 of the paper). All parts share the vertices at their seams, so a ray that
//! crosses from one half into the other crosses exactly one triangle of the separator.

use std::ops::Range;

use super::shell::RIM;

/// The start of the edge.
pub const START: u16 = 0;
/// The end of the edge.
pub const END: u16 = 1;
/// The start of the edge pushed to infinity, away from the light's centre.
pub const FAR_START: u16 = 2;
/// The end of the edge pushed to infinity, away from the light's centre.
pub const FAR_END: u16 = 3;
/// First of [`RIM`] rim points of the outer half, which those of the inner half follow.
pub const FIRST_RIM: u16 = 4;
/// First of the apexes: for each rim point, the end of the edge from which its ray starts.
pub const FIRST_APEX: u16 = FIRST_RIM + 2 * RIM as u16;

const SEPARATOR: usize = 7 * 3;
const SHELL: usize = 3 * (RIM - 1) * 3;

/// Indices of the outer half.
pub const OUTER_HALF: Range<u32> = 0..(SEPARATOR + SHELL) as u32;
/// Indices of the inner half.
pub const INNER_HALF: Range<u32> = OUTER_HALF.end..2 * OUTER_HALF.end;
/// Indices of both shells.
pub const SHELLS: Range<u32> = SEPARATOR as u32..(SEPARATOR + 2 * SHELL) as u32;
/// Indices of the separator, with its front out of the hard shadow.
pub const SEPARATORS: Range<u32> = (SEPARATOR + 2 * SHELL) as u32..2 * (SEPARATOR + SHELL) as u32;
/// Indices of the separator's triangles that bound the hard shadow.
pub const HARD_SIDE: Range<u32> = SEPARATORS.start..SEPARATORS.start + 6;

/// Returns all indices.
pub fn indices() -> Vec<u16> {
    let mut all = separator();
    flip(&mut all);
    all.extend(shell(0));
    let mut inner = shell(1);
    flip(&mut inner);
    all.extend(inner);
    all.extend(separator());
    all
}

/// The side of the hard shadow, then the two triangles and their companions that extend it to the rims, and the
/// triangle between its far end and the last rim.
///
/// The first vertex of a triangle tells the fragment stage whether the triangle bounds the hard shadow: rim
/// points do not. The companions are degenerate unless both rims start from one end of the edge; then the
/// extension of the other end is a quad. The last triangle is degenerate where all rays end at infinity or on
/// one plane. In orthographic views they end at different distances.
fn separator() -> Vec<u16> {
    let (first, last) = (FIRST_RIM, FIRST_RIM + RIM as u16 - 1);
    let apex = |rim: u16| rim - FIRST_RIM + FIRST_APEX;
    [
        [END, START, FAR_START],
        [END, FAR_START, FAR_END],
        [first, FAR_START, START],
        [apex(first), first, START],
        [last, END, FAR_END],
        [last, apex(last), END],
        [last, FAR_END, FAR_START],
    ]
    .concat()
}

/// The shell of one half: triangles between its rays, and triangles at infinity. The first vertex of each
/// triangle belongs to this half alone, which tells the fragment stage the half.
fn shell(half: u16) -> Vec<u16> {
    let rim = |i: u16| FIRST_RIM + half * RIM as u16 + i;
    let apex = |i: u16| FIRST_APEX + half * RIM as u16 + i;
    let last = RIM as u16 - 1;
    let mut all = Vec::with_capacity(SHELL);
    for i in 0..last {
        all.extend([apex(i), rim(i), rim(i + 1)]);
        all.extend([apex(i), rim(i + 1), apex(i + 1)]);
        all.extend([rim(i), FAR_START, rim(i + 1)]);
    }
    all
}

fn flip(triangles: &mut [u16]) {
    for triangle in triangles.chunks_exact_mut(3) {
        triangle.swap(1, 2);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use glam::DVec3;

    use super::*;
    use crate::techniques::penumbra_wedge::geometry::shell::{Shell, quad_shell, sphere_shell};
    use crate::techniques::penumbra_wedge::geometry::sight::Sight;

    const ENDS: [DVec3; 2] = [DVec3::new(-0.7, 0.4, -2.0), DVec3::new(0.9, 0.1, -2.5)];

    fn quad() -> [DVec3; 4] {
        [
            DVec3::new(0.5, 0.3, 0.0),
            DVec3::new(-0.5, 0.3, 0.0),
            DVec3::new(-0.5, -0.3, 0.0),
            DVec3::new(0.5, -0.3, 0.0),
        ]
    }

    /// The vertices of a wedge, with those at infinity brought near.
    fn vertices(ends: [DVec3; 2], shell: &Shell) -> Vec<DVec3> {
        let far = |apex: usize, direction: DVec3| ends[apex] + direction * 50.0;
        let shared = |i: usize| far(shell.rims[0][i].apex, shell.rims[0][i].direction);
        let fars = match shell.only {
            None => [far(0, ends[0]), far(1, ends[1])],
            Some(_) => [shared(0), shared(RIM - 1)],
        };
        let mut all = vec![ends[0], ends[1], fars[0], fars[1]];
        let rims = shell.rims.iter().flatten();
        all.extend(rims.clone().map(|point| far(point.apex, point.direction)));
        all.extend(rims.map(|point| ends[point.apex]));
        all
    }

    /// Six times the signed volume, and whether every directed edge between places has its reverse.
    fn measure(vertices: &[DVec3], indices: &[u16]) -> (f64, bool) {
        let mut balance: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
        let key = |v: u16| vertices[v as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut volume = 0.0;
        for triangle in indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| vertices[triangle[i] as usize]);
            volume += a.dot(b.cross(c));
            for i in 0..3 {
                let (from, to) = (key(triangle[i]), key(triangle[(i + 1) % 3]));
                *balance.entry([from, to]).or_default() += 1;
                *balance.entry([to, from]).or_default() -= 1;
            }
        }
        (volume, balance.values().all(|&count| count == 0))
    }

    fn shells() -> Vec<([DVec3; 2], Shell)> {
        let pointing = [DVec3::new(0.05, 0.02, -1.0), DVec3::new(0.12, 0.02, -2.0)];
        vec![
            (ENDS, quad_shell(ENDS, quad(), &Sight::default()).unwrap()),
            (ENDS, sphere_shell(ENDS, 0.4, &Sight::default()).unwrap()),
            (pointing, quad_shell(pointing, quad(), &Sight::default()).unwrap()),
            (pointing, sphere_shell(pointing, 0.4, &Sight::default()).unwrap()),
            (
                [ENDS[1], ENDS[0]],
                quad_shell([ENDS[1], ENDS[0]], quad(), &Sight::default()).unwrap(),
            ),
        ]
    }

    #[test]
    fn halves_are_closed_and_wound_outward() {
        let indices = indices();
        assert_eq!(indices.len(), SEPARATORS.end as usize);
        for (ends, shell) in shells() {
            let vertices = vertices(ends, &shell);
            for half in [OUTER_HALF, INNER_HALF] {
                let range = half.start as usize..half.end as usize;
                let (volume, closed) = measure(&vertices, &indices[range]);
                assert!(closed, "{ends:?}");
                assert!(volume > 1.0, "{volume} {ends:?}");
            }
            // A half without its separator is open.
            let shells = SHELLS.start as usize..SHELLS.end as usize / 2;
            assert!(!measure(&vertices, &indices[shells]).1);
        }
    }

    /// A ray that crosses from one half into the other would meet a triangle of the shells there with a face of each
    /// half, and their values cancel.
    #[test]
    fn no_shell_has_a_triangle_between_the_halves() {
        let indices = indices();
        for (ends, shell) in shells() {
            let vertices = vertices(ends, &shell);
            let normal = ends[0].cross(ends[1]).normalize();
            // The size of a triangle, and the greatest distance of its corners from the plane between the halves.
            let measure = |triangle: &[u16]| {
                let corners @ [a, b, c] = [0, 1, 2].map(|i| vertices[triangle[i] as usize]);
                let off = corners.map(|corner| normal.dot(corner).abs()).into_iter();
                ((b - a).cross(c - a).length(), off.fold(0.0, f64::max))
            };
            let range = |part: Range<u32>| part.start as usize..part.end as usize;
            for triangle in indices[range(SHELLS)].chunks_exact(3) {
                let (size, off) = measure(triangle);
                assert!(size < 1e-9 || off > 1e-6, "{triangle:?}: {size} {off}, {ends:?}");
            }
            for triangle in indices[range(SEPARATORS)].chunks_exact(3) {
                let (_, off) = measure(triangle);
                assert!(off < 1e-9, "{triangle:?}: {off}, {ends:?}");
            }
        }
    }

    /// Pseudo-random numbers, uniform in 0..1.
    fn random() -> impl FnMut() -> f64 {
        let mut random = 1u32;
        move || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(random >> 8) / f64::from(1 << 24)
        }
    }

    /// Measures shells of 400 random edges. It takes points that see a random place of the light past the
    /// edge, where the edge is a silhouette edge from that place. Returns how far the worst point lies
    /// outside of its shell, the number of shells that are in one half, and the number of points. Without
    /// `cut`, edges are silhouette edges from everywhere.
    fn worst_outside(cut: bool) -> (f64, usize, usize) {
        let mut unit = random();
        let indices = indices();
        let range = SHELLS.start as usize..SHELLS.end as usize;
        let (mut worst, mut slivers, mut judged) = (f64::NEG_INFINITY, 0, 0);
        for case in 0..400 {
            let mut point = || DVec3::new(unit() * 4.0 - 2.0, unit() * 4.0 - 2.0, -0.5 - unit() * 3.0);
            let ends = [point(), point()];
            let is_sphere = case % 2 == 0;
            // Planes through the edge and a place on the light.
            let mut plane = || {
                let through = DVec3::new(unit() - 0.5, 0.6 * unit() - 0.3, 0.0);
                let normal = (ends[1] - ends[0]).cross(through - ends[0]).normalize();
                normal.extend(-normal.dot(ends[0]))
            };
            let planes = [plane(), plane()];
            let at_center = planes.map(|plane| plane.w > 0.0);
            let sight = match (cut, case % 3) {
                (false, _) => Sight::default(),
                (true, 0) => Sight {
                    planes: [Some(planes[0]), None],
                    is_beside: case % 5 < 2,
                },
                // Triangles traverse the edge in opposite directions, so those of unlike sign are on one
                // side.
                (true, _) => Sight {
                    planes: planes.map(Some),
                    is_beside: at_center[0] == at_center[1],
                },
            };
            // Whether a place is on the centre's side of all planes or, for a sight beside the centre,
            // between the planes.
            let sees = |place: DVec3| {
                let sides = sight.planes.iter().flatten();
                let unlike =
                    sides.filter(|plane| (plane.truncate().dot(place) + plane.w > 0.0) != (plane.w > 0.0));
                match (sight.is_beside, unlike.count()) {
                    (false, crossed) => crossed == 0,
                    (true, crossed) => crossed == 1,
                }
            };
            let shell = if is_sphere {
                sphere_shell(ends, 0.4, &sight)
            } else {
                quad_shell(ends, quad(), &sight)
            };
            let vertices = shell.map(|shell| vertices(ends, &shell));
            slivers += usize::from(shell.is_some_and(|shell| shell.only.is_some()));
            for _ in 0..50 {
                let light = if is_sphere {
                    let direction = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5);
                    direction.normalize() * (0.4 * unit())
                } else {
                    DVec3::new(unit() - 0.5, 0.6 * unit() - 0.3, 0.0)
                };
                if !sees(light) {
                    continue;
                }
                judged += 1;
                let vertices = vertices
                    .as_ref()
                    .expect("a shell where something sees the light past the edge");
                let at = ends[0].lerp(ends[1], unit());
                let seen = at + (at - light) * (0.1 + unit() * 3.0);
                // A point inside the hull of both shells is behind every triangle that is not at infinity.
                for triangle in indices[range.clone()].chunks_exact(3) {
                    if triangle.contains(&FAR_START) {
                        continue;
                    }
                    let [a, b, c] = [0, 1, 2].map(|i| vertices[triangle[i] as usize]);
                    let normal = (b - a).cross(c - a).normalize_or_zero();
                    worst = worst.max(normal.dot(seen - a));
                }
            }
        }
        (worst, slivers, judged)
    }

    #[test]
    fn shells_hold_what_sees_the_light_past_the_edge() {
        let (worst, slivers, judged) = worst_outside(false);
        assert!(
            worst < 1e-6 && slivers == 0 && judged == 20_000,
            "{worst} {slivers} {judged}"
        );
    }

    #[test]
    fn slivers_hold_what_sees_their_part_of_the_light_past_the_edge() {
        let (worst, slivers, judged) = worst_outside(true);
        println!("{slivers} of 400 shells are slivers; {judged} points, {worst} outside");
        assert!(
            worst < 1e-6 && slivers > 50 && judged > 3000,
            "{worst} {slivers} {judged}"
        );
    }
}
