//! Smoothies on the CPU: edges and corners leave no gap, alpha grows outwards alone, and what a texel holds gives every
//! receiver what the source's formula gives.

use antumbra::insides::smoothies::{
    Beside, CLEAR, DISC, DISC_ALONE, FARTHEST, LEAST, SECTOR, SmoothieEdge, SmoothieFace, SmoothieVertex,
    Stand, VERTICES, push_smoothies, resolve_from_point, resolve_parallel, smoothie_vertex,
    visibility_from_point, visibility_parallel,
};
use antumbra::silhouettes::Contour;
use antumbra::techniques::maps::{FaceProjection, MapFace};
use glam::{DMat4, DVec3, Vec2, Vec3};

/// Width of the smoothies, as a share of the distance.
const SHARE: f32 = 0.03;

/// Random numbers from a seed.
struct Random(fastrand::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    fn unit(&mut self) -> f32 {
        self.0.f32()
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

/// A face along Z from the origin.
fn face() -> SmoothieFace {
    let face = MapFace {
        origin: DVec3::ZERO,
        axes: [DVec3::X, DVec3::Y, DVec3::Z],
        projection: FaceProjection::Perspective {
            tangent: 0.5,
            near: 0.01,
        },
    };
    SmoothieFace::new(&face, DVec3::ZERO, 1024, &beside())
}

fn beside() -> Beside {
    Beside {
        metres: 0.0,
        share: SHARE,
        drop: 1.0,
    }
}

/// The smoothies of a closed loop of points, each with its own distance. `picture` holds tangents.
fn smoothies(picture: &[Vec2], distances: &[f32]) -> Vec<SmoothieEdge> {
    let positions: Vec<Vec3> = picture
        .iter()
        .zip(distances)
        .map(|(point, distance)| point.extend(1.0) * *distance)
        .collect();
    let count = positions.len() as u32;
    // The caster is on the left as seen from the light, which looks along Z with X to its left.
    let contour = Contour {
        edges: (0..count).map(|i| [(i + 1) % count, i]).collect(),
        ..Contour::default()
    };
    let mut out = Vec::new();
    let stand = Stand {
        positions: &positions,
        world_from_local: &DMat4::IDENTITY,
        anchor: DVec3::ZERO,
        along: None,
        beside: &beside(),
    };
    push_smoothies(&contour, &stand, &mut Vec::new(), &mut out);
    out
}

/// The triangles of smoothies, projected.
fn triangles(edges: &[SmoothieEdge]) -> Vec<[SmoothieVertex; 3]> {
    let face = face();
    edges
        .iter()
        .flat_map(|edge| {
            (0..VERTICES / 3)
                .map(move |t| [0, 1, 2].map(|corner| smoothie_vertex(edge, &face, 3 * t + corner)))
        })
        .collect()
}

fn tangent(vertex: &SmoothieVertex) -> Vec2 {
    let clip = vertex.position_clip;
    Vec2::new(clip.x, clip.y) * (0.5 / clip.w)
}

/// Least alpha of the triangles that cover a point; 1 if none does.
fn alpha(triangles: &[[SmoothieVertex; 3]], at: Vec2) -> f32 {
    let covers = |corners: &[SmoothieVertex; 3]| {
        let [a, b, c] = corners.each_ref().map(tangent);
        let area = (b - a).perp_dot(c - a);
        let weights = [(b, c), (c, a), (a, b)].map(|(from, to)| (to - from).perp_dot(at - from) / area);
        if area == 0.0 || weights.iter().any(|weight| !(*weight >= 0.0)) {
            return None;
        }
        // The hardware interpolates in perspective.
        let shares: [f32; 3] = std::array::from_fn(|i| weights[i] / corners[i].position_clip.w);
        let sum: f32 = shares.iter().sum();
        let of = |value: fn(&SmoothieVertex) -> Vec2| -> Vec2 {
            (0..3).map(|i| value(&corners[i]) * (shares[i] / sum)).sum()
        };
        let width = of(|vertex| Vec2::splat(vertex.width)).x;
        Some(of(|vertex| vertex.offset).length() / width)
    };
    triangles.iter().filter_map(covers).fold(1.0, f32::min)
}

/// Distance of a point from a closed loop, and whether it is inside.
fn distance(picture: &[Vec2], at: Vec2) -> (f32, bool) {
    let mut inside = false;
    let mut least = f32::INFINITY;
    for (i, &a) in picture.iter().enumerate() {
        let b = picture[(i + 1) % picture.len()];
        let t = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        least = least.min(at.distance(a + (b - a) * t));
        if (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    (least, inside)
}

/// A random star, or a triangle with an angle from 1° to 179°, counter-clockwise.
fn random_loop(random: &mut Random, index: usize) -> Vec<Vec2> {
    let turn = Vec2::from_angle(random.between(0.0, std::f32::consts::TAU));
    if index.is_multiple_of(2) {
        let angle = random.between(1.0f32, 179.0).to_radians();
        let [left, right] = [0, 1].map(|_| random.between(0.04, 0.15));
        let tip = Vec2::new(random.between(-0.05, 0.05), random.between(-0.05, 0.05));
        return vec![
            tip,
            tip + turn * left,
            tip + turn.rotate(Vec2::from_angle(angle)) * right,
        ];
    }
    let count = 3 + (random.unit() * 6.0) as usize;
    let steps: Vec<f32> = (0..count).map(|_| random.between(0.3, 1.0)).collect();
    let scale = std::f32::consts::TAU / steps.iter().sum::<f32>();
    let mut angle = 0.0;
    let point = |step: &f32| {
        angle += step * scale;
        turn.rotate(Vec2::from_angle(angle)) * random.between(0.02, 0.15)
    };
    steps.iter().map(point).collect()
}

/// Points beside random loops where alpha is not that of the distance from the loop, for smoothies as `spoil` leaves
/// them. Returns the number of points that were looked at, of those too dark, and of those too light.
fn wrong_points(loops: usize, spoil: impl Fn(&mut Vec<SmoothieEdge>)) -> [usize; 3] {
    let mut random = Random::new(3);
    let [mut looked, mut dark, mut light] = [0; 3];
    for index in 0..loops {
        let picture = random_loop(&mut random, index);
        let distances: Vec<f32> = picture.iter().map(|_| random.between(1.5, 4.0)).collect();
        let mut edges = smoothies(&picture, &distances);
        assert_eq!(edges.len(), picture.len());
        spoil(&mut edges);
        let triangles = triangles(&edges);
        for sample in 0..12 {
            // Half of the points are around corners, where gaps would be.
            let corner = picture[sample % picture.len()];
            let next = picture[(sample + 1) % picture.len()];
            let from = if sample.is_multiple_of(2) {
                corner
            } else {
                corner.lerp(next, random.unit())
            };
            let around = Vec2::from_angle(random.between(0.0, std::f32::consts::TAU));
            let at = from + around * (random.between(0.02, 1.1) * SHARE);
            let (distance, inside) = distance(&picture, at);
            if inside || distance < 0.01 * SHARE {
                continue;
            }
            looked += 1;
            let expected = (distance / SHARE).min(1.0);
            let got = alpha(&triangles, at);
            // Distances are measured at right angles to the rays, which differ by the cosine of some 10° from
            // those in the picture.
            dark += usize::from(got < expected * 0.95 - 0.01);
            light += usize::from(got > expected * 1.05 + 0.01);
        }
    }
    [looked, dark, light]
}

#[test]
fn between_smoothies_of_random_loops_no_point_is_dark_or_light_by_itself() {
    let [looked, dark, light] = wrong_points(10_000, |_| {});
    println!("{looked} points: {dark} too dark, {light} too light");
    assert!(looked > 50_000, "{looked}");
    assert_eq!((dark, light), (0, 0));
}

#[test]
fn without_corners_there_are_gaps() {
    let [looked, _, light] = wrong_points(300, |edges| {
        // An edge that goes straight on needs no corner.
        for edge in edges {
            let (start, end) = (Vec3::from(edge.start), Vec3::from(edge.end));
            edge.next = (end + (end - start)).to_array();
            edge.kind = SECTOR;
        }
    });
    assert!(light > looked / 50, "{light} of {looked}");
}

#[test]
fn alpha_grows_outwards_alone() {
    let mut random = Random::new(11);
    let mut rays = 0;
    for index in 0..500 {
        // A convex corner, its edges, and the way out of it: nothing else is near.
        let picture = random_loop(&mut random, 2 * index);
        let distances = vec![2.0; picture.len()];
        let triangles = triangles(&smoothies(&picture, &distances));
        let tip = picture[0];
        let outwards = (2.0 * tip - picture[1] - picture[2]).normalize();
        let mut last = 0.0;
        for step in 1..=20 {
            let at = tip + outwards * (SHARE * 0.049 * step as f32);
            let (distance, inside) = distance(&picture, at);
            if inside || distance > 0.97 * SHARE {
                break;
            }
            let got = alpha(&triangles, at);
            assert!(got > last, "loop {index}, step {step}: {got} after {last}");
            last = got;
            rays += 1;
        }
    }
    assert!(rays > 5_000, "{rays}");
}

#[test]
fn edges_that_branch_or_point_at_the_light_end_in_discs() {
    let at_light = [
        Vec3::new(0.0, 0.0, 2.0),
        Vec3::new(0.0, 0.0, 3.0),
        Vec3::new(0.1, 0.0, 3.0),
    ];
    let of = |edges: Vec<[u32; 2]>, positions: &[Vec3], world_from_local: DMat4| {
        let contour = Contour {
            double_edges: edges,
            ..Contour::default()
        };
        let stand = Stand {
            positions,
            world_from_local: &world_from_local,
            anchor: DVec3::ZERO,
            along: None,
            beside: &beside(),
        };
        let mut out = Vec::new();
        push_smoothies(&contour, &stand, &mut Vec::new(), &mut out);
        out
    };
    let kinds = |edges: &[SmoothieEdge]| edges.iter().map(|edge| edge.kind).collect::<Vec<_>>();
    let edges = of(vec![[0, 1], [1, 2], [2, 0]], &at_light, DMat4::IDENTITY);
    assert_eq!(kinds(&edges), [DISC_ALONE, SECTOR, DISC]);
    for edge in &edges {
        let face = face();
        let vertices = (0..VERTICES).map(|vertex| smoothie_vertex(edge, &face, vertex));
        assert!(
            vertices
                .into_iter()
                .all(|vertex| vertex.position_clip.is_finite()),
            "{edge:?}"
        );
    }
    let cross: Vec<Vec3> = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (-0.1, 0.0), (-0.1, -0.1)]
        .map(|(x, y)| Vec3::new(x, y, 2.0))
        .to_vec();
    let edges = of(
        vec![[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0], [0, 1]],
        &cross,
        DMat4::IDENTITY,
    );
    assert_eq!(
        kinds(&edges),
        [SECTOR, SECTOR, SECTOR, DISC, SECTOR, DISC],
        "each edge once"
    );
    // A mirror turns the edges round, so that the caster stays on their left.
    let mirrored = of(
        vec![[1, 2], [2, 0], [0, 1]],
        &cross,
        DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
    );
    assert_eq!(mirrored[0].start, [0.0, 0.0, 2.0]);
    assert_eq!(mirrored[0].end, [-0.1, 0.1, 2.0]);
    // Positions that are missing or not finite are left out.
    assert!(of(vec![[0, 7], [7, 0]], &cross, DMat4::IDENTITY).is_empty());
}

/// Widths are interpolated along an edge; its ends may be far from the light where its middle is not.
#[test]
fn edges_that_pass_by_the_light_are_no_wider_in_between() {
    let positions = [
        Vec3::new(-3.3, 0.07, 3.2),
        Vec3::new(2.7, 0.07, -2.8),
        Vec3::new(2.0, -1.0, 3.0),
    ];
    let contour = Contour {
        edges: vec![[0, 1], [1, 2], [2, 0]],
        ..Contour::default()
    };
    let width = beside();
    let stand = |along| Stand {
        positions: &positions,
        world_from_local: &DMat4::IDENTITY,
        anchor: DVec3::ZERO,
        along,
        beside: &width,
    };
    let mut edges = Vec::new();
    push_smoothies(&contour, &stand(None), &mut Vec::new(), &mut edges);
    assert!(edges.len() > 3, "an edge is divided");
    let mut last = Vec3::from(edges[edges.len() - 1].end);
    for edge in &edges {
        let (start, end) = (Vec3::from(edge.start), Vec3::from(edge.end));
        assert_eq!(start, last, "the loop is closed");
        last = end;
        for step in 0..=100 {
            let t = step as f32 * 0.01;
            let width = edge.width_start * (1.0 - t) + edge.width_end * t;
            let share = width / start.lerp(end, t).length();
            assert!(
                (0.99..1.45).contains(&(share / SHARE)),
                "{edge:?} at {t}: {share}"
            );
        }
    }
    // The width of a directional light does not depend on distances.
    edges.clear();
    push_smoothies(&contour, &stand(Some(Vec3::NEG_Z)), &mut Vec::new(), &mut edges);
    assert_eq!(edges.len(), 3);
}

/// However long the light's range is: what is stored stays in the range of half floats.
#[test]
fn blockers_close_to_the_light_darken_close_receivers() {
    let [scale, ..] = face().limits;
    for along in [0.0101, 0.02, 0.3, 8.0] {
        let (caster, receiver, alpha) = (3000.0_f32, along * 1.5, 0.1);
        let stored = resolve_from_point(alpha, along, caster.recip(), scale);
        assert!(stored.y > -FARTHEST, "{along}: {stored}");
        let got = visibility_from_point(stored, receiver.recip(), caster.recip(), scale);
        let expected = alpha / (1.0 - along / receiver);
        assert!((got - expected).abs() < 2e-3, "{along}: {got}, {expected}");
    }
}

#[test]
fn one_smoothie_is_exact_for_every_receiver() {
    let mut random = Random::new(5);
    for _ in 0..20_000 {
        let (alpha, along) = (random.between(0.002, 0.999), random.between(0.1, 5.0));
        let caster = if random.unit() < 0.2 {
            f32::INFINITY
        } else {
            along + random.between(0.01, 20.0)
        };
        let stored = resolve_from_point(alpha, along, caster.recip(), 16.0);
        let receiver = (along + random.between(-0.5, 20.0)).clamp(0.01, caster);
        let expected = if receiver > along {
            (alpha / (1.0 - along / receiver)).min(1.0)
        } else {
            1.0
        };
        let got = visibility_from_point(stored, receiver.recip(), caster.recip(), 16.0);
        assert!(
            (got - expected).abs() < 2e-3,
            "{alpha} {along} {caster} {receiver}: {got}, {expected}"
        );

        let (caster, drop) = (along + random.between(0.01, 30.0), random.between(0.5, 20.0));
        let stored = resolve_parallel(alpha, along, caster, drop);
        let receiver = (along + random.between(-0.5, 30.0)).min(caster);
        let share = ((receiver - along) / drop).min(1.0);
        let expected = if share > 0.0 {
            (alpha / share).min(1.0)
        } else {
            1.0
        };
        let got = visibility_parallel(stored, receiver, caster, drop);
        assert!(
            (got - expected).abs() < 2e-3,
            "{alpha} {along} {caster} {drop} {receiver}: {got}, {expected}"
        );
    }
    assert_eq!(
        resolve_from_point(0.5, 2.0, 1.0, 16.0),
        CLEAR,
        "behind the caster"
    );
    assert_eq!(visibility_from_point(CLEAR, 0.1, 0.0, 16.0), 1.0);
    let darkest = visibility_from_point(resolve_from_point(0.0, 1.0, 0.0, 16.0), 0.0, 0.0, 16.0);
    assert!((darkest / LEAST - 1.0).abs() < 1e-3, "{darkest}");
}

/// At the caster behind, where shadows fall; a receiver that casts nothing may be darker, never lighter.
#[test]
fn many_smoothies_leave_the_least_visibility() {
    let mut random = Random::new(9);
    let mut darker = 0;
    for _ in 0..5_000 {
        let caster = random.between(3.0, 9.0);
        let many: Vec<(f32, f32)> = (0..6)
            .map(|_| (random.between(0.01, 0.99), random.between(0.2, 2.9)))
            .collect();
        let stored = many
            .iter()
            .map(|&(alpha, along)| resolve_from_point(alpha, along, caster.recip(), 16.0))
            .fold(CLEAR, Vec2::min);
        for receiver in [caster, random.between(0.3, caster)] {
            let of_one = |&(alpha, along): &(f32, f32)| {
                if receiver > along {
                    (alpha / (1.0 - along / receiver)).min(1.0)
                } else {
                    1.0
                }
            };
            let expected = many.iter().map(of_one).fold(1.0, f32::min);
            let got = visibility_from_point(stored, receiver.recip(), caster.recip(), 16.0);
            assert!(
                got <= expected + 2e-3,
                "{many:?} at {receiver} of {caster}: {got}, {expected}"
            );
            if receiver == caster {
                assert!(
                    (got - expected).abs() < 2e-3,
                    "{many:?} at {caster}: {got}, {expected}"
                );
            } else {
                darker += usize::from(got < expected - 0.05);
            }
        }
    }
    println!("{darker} of 5000 receivers in front of the caster are too dark");
}

/// A square plate with a corner in each direction, seen from above its middle; one of its edges belongs to a surface on which
/// the light lies.
#[test]
fn edges_of_a_surface_on_which_the_light_lies_have_neither_smoothie_nor_corner() {
    let positions = [
        Vec3::new(-1.0, -1.0, 2.0),
        Vec3::new(1.0, -1.0, 2.0),
        Vec3::new(1.0, 1.0, 2.0),
        Vec3::new(-1.0, 1.0, 2.0),
    ];
    let of = |flush_edges: Vec<[u32; 2]>| {
        let contour = Contour {
            edges: vec![[0, 3], [3, 2], [2, 1], [1, 0]],
            flush_edges,
            ..Contour::default()
        };
        let stand = Stand {
            positions: &positions,
            world_from_local: &DMat4::IDENTITY,
            anchor: DVec3::ZERO,
            along: None,
            beside: &beside(),
        };
        let mut out = Vec::new();
        push_smoothies(&contour, &stand, &mut Vec::new(), &mut out);
        out
    };
    let corner_area = |edge: &SmoothieEdge| {
        let face = face();
        (2..VERTICES / 3)
            .map(|t| {
                let [a, b, c] = [0, 1, 2].map(|corner| {
                    let clip = smoothie_vertex(edge, &face, 3 * t + corner).position_clip;
                    assert!(clip.is_finite());
                    Vec2::new(clip.x, clip.y) / clip.w
                });
                (b - a).perp_dot(c - a).abs()
            })
            .sum::<f32>()
    };
    let whole = of(Vec::new());
    assert_eq!(whole.len(), 4);
    assert!(whole.iter().all(|edge| corner_area(edge) > 1e-4));
    let without = of(vec![[2, 3]]);
    assert_eq!(without.len(), 3);
    let at = |edge: &SmoothieEdge| Vec3::from(edge.end);
    for edge in &without {
        let is_before_flush = at(edge) == positions[3];
        assert_eq!(corner_area(edge) > 1e-4, !is_before_flush, "{edge:?}");
    }
    assert!(without.iter().any(|edge| at(edge) == positions[3]));
}
