//! Pieces that are inside out or without volume, and poses that are not finite.

use antumbra::silhouettes::{
    Contour, FacingBits, FacingPlanes, classify, classify_scalar, compute_planes, compute_posed_planes,
    extract_contour,
};
use glam::{DVec3, Vec3, Vec4};
use proptest::prelude::*;

use super::checks::{MODES, assert_holds, cast, icosphere, slots};
use super::shapes::Soup;
use super::volume::{is_crossed, volume, winding};

fn turned(mut soup: Soup) -> Soup {
    for corners in soup.indices.as_chunks_mut::<3>().0 {
        corners.swap(1, 2);
    }
    soup
}

/// Triangles between point and light, and how often the volume of either mode winds around the point.
fn crossed_and_windings(soup: &Soup, light: Vec4, point: DVec3) -> Option<(i64, [i64; 2])> {
    let cast = cast(soup, light);
    let crossed: Option<Vec<bool>> = slots(&cast.mesh)
        .map(|(_, corners)| is_crossed(corners.map(|i| soup.positions[i as usize]), light, point))
        .collect();
    let [single, all, _] = cast
        .contours
        .each_ref()
        .map(|contour| winding(&volume(contour, &soup.positions), light, point));
    let count = crossed?.into_iter().filter(|&crossed| crossed).count();
    Some((count as i64, [single?, all?]))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// What is behind the walls is dark, what is before them is lit, however the room is wound.
    #[test]
    fn light_in_a_room_stays_there(
        light in [-0.5..0.5f32, -0.5..0.5f32, -0.5..0.5f32], point in [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64],
        is_turned in any::<bool>(),
    ) {
        let (light, point) = (Vec3::from(light).extend(1.0), DVec3::from(point));
        prop_assume!(!(0.9..1.1).contains(&point.length()));
        let sphere = icosphere(1.0, 2);
        let room = if is_turned { turned(sphere) } else { sphere };
        prop_assert_eq!(room.build().is_closed(), !is_turned);
        let known = crossed_and_windings(&room, light, point);
        prop_assume!(known.is_some());
        let walls = i64::from(point.length() > 1.0);
        prop_assert_eq!(known, Some((walls, [walls; 2])));
    }
}

#[test]
fn only_what_is_wound_outward_is_closed() {
    let far = |mut soup: Soup, scale: f32, offset: f32| {
        for position in &mut soup.positions {
            *position = *position * scale + offset;
        }
        soup
    };
    for (scale, offset) in [(1.0, 0.0), (1e-6, 0.0), (1.0, 1e4), (1e6, -1e7)] {
        let sphere = far(icosphere(1.0, 2), scale, offset);
        assert!(sphere.build().is_closed(), "{scale} {offset}");
        let room = turned(sphere);
        assert_eq!(room.build().closed_triangle_count(), 0, "{scale} {offset}");
        // All edges are regular even so.
        assert_eq!(room.build().regular_count(), 480);
        assert_holds(&room, Vec4::new(0.1, 0.2, -0.1, 1.0));
    }
    // Cards with a front and a back, the corners of one in another order: the terms of the volume differ by rounding.
    let corners = [0.3f32, 0.7, 1.9].map(|x| Vec3::new(x, x * x + 0.1, 1.0 / x));
    for [a, b, c] in [[0, 2, 1], [2, 1, 0], [1, 0, 2]] {
        let mut card = far(icosphere(1.0, 0), 1.0, 0.0);
        card.positions = corners.to_vec();
        card.indices = vec![0, 1, 2, a, b, c];
        let mesh = card.build();
        assert_eq!((mesh.closed_triangle_count(), mesh.triangle_count()), (0, 2));
        assert_holds(&card, Vec4::new(5.0, 1.0, 2.0, 1.0));
    }
}

/// Each piece has a sign of its own.
#[test]
fn room_with_a_ball_in_it() {
    let mut soup = turned(icosphere(2.0, 2));
    let first = soup.positions.len() as u32;
    let ball = icosphere(0.5, 1);
    soup.positions.extend(ball.positions);
    soup.indices.extend(ball.indices.iter().map(|i| first + i));
    assert_eq!(soup.build().closed_triangle_count(), ball.indices.len() / 3);
    let light = Vec4::new(1.21, 0.07, 0.03, 1.0);
    // In the ball's shadow; behind the wall as well; only behind the wall; lit.
    for (point, expected) in [
        ([-1.3, 0.011, 0.017], 1),
        ([-4.0, 0.013, 0.019], 2),
        ([3.1, 2.0, -1.7], 1),
        ([1.0, 0.9, 0.4], 0),
    ] {
        let (_, [single, _]) = crossed_and_windings(&soup, light, DVec3::from(point)).unwrap();
        assert_eq!(single, expected, "{point:?}");
    }
}

/// One corner takes the caster out, and the next pose brings it back.
#[test]
fn pose_that_is_not_finite_casts_nothing() {
    let mut sphere = icosphere(1.0, 2);
    sphere.positions.push(Vec3::NAN); // of no triangle
    let mesh = sphere.build();
    let light = Vec4::new(3.0, 4.0, 5.0, 1.0);
    let (mut planes, mut bits) = (FacingPlanes::default(), FacingBits::default());
    for compute in [compute_planes, compute_posed_planes] {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let mut pose = sphere.positions.clone();
                pose[7][axis] = bad;
                let hit = mesh.corners().iter().filter(|corners| corners.contains(&7));
                compute(&mesh, &pose, &mut planes);
                assert_eq!(planes.non_finite_triangles(), hit.count(), "{bad} {axis}");
                for classify in [classify, classify_scalar] {
                    classify(&mesh, &planes, light, &mut bits);
                    for mode in MODES {
                        let mut contour = Contour::default();
                        extract_contour(&mesh, &bits, mode, &mut contour);
                        assert_eq!(contour, Contour::default());
                    }
                }
            }
        }
        // Huge and tiny poses are finite.
        for scale in [1.0, 1e-42, 1e38] {
            let pose: Vec<Vec3> = sphere.positions.iter().map(|&p| p * scale).collect();
            compute(&mesh, &pose, &mut planes);
            assert_eq!(planes.non_finite_triangles(), 0, "{scale}");
            classify(&mesh, &planes, light, &mut bits);
            let mut contour = Contour::default();
            extract_contour(&mesh, &bits, MODES[0], &mut contour);
            assert!(!contour.caps.is_empty());
        }
    }
}
