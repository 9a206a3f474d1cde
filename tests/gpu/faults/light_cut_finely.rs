//! Area lights that finely tessellated surfaces cut: a flat surface is one polygon, however many cells it has, and curved ones
//! are as coarse as the light allows.

use std::f32::consts::{FRAC_PI_2, TAU};

use antumbra::insides::records::CUT;
use antumbra::prelude::*;
use antumbra::techniques::PenumbraWedges;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec2, Vec3};

use super::light_cut::soft_error;
use super::scenes::{SIZE, lamp, object, stage};
use crate::harness::support::stage::Stage;

/// A square of 6 m that faces down, of so many cells a side.
fn ceiling(cells: u32) -> MeshData {
    sheet(cells, 3.0)
}

fn sheet(cells: u32, half_size: f32) -> MeshData {
    let row = cells + 1;
    let at = |i: u32| {
        let cell = Vec2::new((i % row) as f32, (i / row) as f32) / cells as f32;
        let place = (cell * 2.0 - 1.0) * half_size;
        Vec3::new(place.x, 0.0, place.y)
    };
    let quad = |cell: u32| {
        let a = cell / cells * row + cell % cells;
        [a, a + 1, a + row + 1, a, a + row + 1, a + row]
    };
    MeshData::from_triangles(
        "sheet",
        (0..row * row).map(at).collect(),
        (0..cells * cells).flat_map(quad).collect(),
    )
}

/// An open shade: a tube with a radius of 0.5 m around the axis y, from −0.25 to 0.25 m.
fn shade(sides: u32) -> MeshData {
    let at = |i: u32| {
        let (sin, cos) = ((i / 2) as f32 / sides as f32 * TAU).sin_cos();
        Vec3::new(
            0.5 * cos,
            if i.is_multiple_of(2) { -0.25 } else { 0.25 },
            0.5 * sin,
        )
    };
    let quad = |side: u32| {
        let (a, b) = (2 * side, 2 * ((side + 1) % sides));
        [a, a + 1, b + 1, a, b + 1, b]
    };
    MeshData::from_triangles(
        "shade",
        (0..2 * sides).map(at).collect(),
        (0..sides).flat_map(quad).collect(),
    )
}

/// A ground with a box on it, seen from `eye`, a mesh at `at`, and a lamp under wedges.
fn lit(eye: Vec3, (mesh, at): (MeshData, Vec3), kind: LightKind, lamp_at: Vec3) -> Stage {
    let mut stage = stage(
        eye,
        Vec3::new(0.0, 0.6, 0.0),
        Camera {
            vertical_fov: 1.1,
            near: 0.05,
            ..Camera::default()
        },
    );
    stage.world.insert_resource(ViewportSize(SIZE / 2));
    let block = MeshData::cuboid(Vec3::new(0.3, 0.5, 0.3));
    for (mesh, place) in [
        (MeshData::plane(3.0), Vec3::ZERO),
        (block, Vec3::new(1.2, 0.5, 0.2)),
        (mesh, at),
    ] {
        stage
            .world
            .spawn(object(mesh, Transform::from_translation(place)));
    }
    let light = lamp(&mut stage, kind, lamp_at, 20.0);
    // A rectangle shines down, nearly straight.
    let place =
        Transform::from_translation(lamp_at).looking_at(lamp_at - Vec3::new(-0.05, 1.0, 0.0), Vec3::Z);
    stage
        .world
        .entity_mut(light)
        .insert((PenumbraWedge::default(), place));
    stage
}

const IN_ROOM: Vec3 = Vec3::new(2.2, 1.5, 2.9);
const FROM_AFAR: Vec3 = Vec3::new(0.2, 4.2, 5.5);
const CEILING: Vec3 = Vec3::new(0.0, 2.5, 0.0);

/// Returns the number of polygons and of those left out, of the last frame.
fn cuts(stage: &Stage) -> (usize, u32) {
    let wedges = stage.world.resource::<PenumbraWedges>();
    let polygons = wedges.wedges.iter().filter(|wedge| wedge.flags & CUT != 0);
    (polygons.count(), wedges.lights[0].cuts_left_out)
}

/// Draws a scene, and returns what is wrong with it if it is cut by more than `most` polygons or errs by more than 0.04, of
/// which the samples have 0.01 to 0.02.
fn fault(name: &str, stage: &mut Stage, most: usize) -> Option<String> {
    let (error, mean) = soft_error(stage, 144);
    let (polygons, left_out) = cuts(stage);
    println!("{name}: {polygons} polygons, mean {mean:.3}, {error:?}");
    let is_right = error.rmse < 0.04 && error.rmse_penumbra < 0.04 && error.umbra_lit < 0.004;
    (!is_right || polygons > most || left_out > 0)
        .then(|| format!("{name}: {polygons} polygons, {left_out} left out, {error:?}"))
}

#[test]
fn ceilings_of_many_cells_cut_as_one_polygon() {
    let mut faults = Vec::new();
    for cells in [1, 20, 100] {
        for radius in [0.1, 0.3] {
            let kind = LightKind::Sphere { radius };
            let at = CEILING + Vec3::new(0.2, 0.0, 0.15);
            let mut stage = lit(IN_ROOM, (ceiling(cells), CEILING), kind, at);
            faults.extend(fault(&format!("{cells} cells, ball of {radius}"), &mut stage, 1));
        }
    }
    let (width, height) = (0.5, 0.3);
    let kind = LightKind::Rect { width, height };
    let mut stage = lit(IN_ROOM, (ceiling(100), CEILING), kind, CEILING);
    faults.extend(fault("100 cells, half-sunk rectangle", &mut stage, 1));
    // Only the cells that the ball reaches cut it; they have an outline in steps.
    let kind = LightKind::Sphere { radius: 0.3 };
    let mut stage = lit(IN_ROOM, (ceiling(60), CEILING), kind, CEILING - Vec3::Y * 0.1);
    faults.extend(fault("60 cells, a ball a third sunk", &mut stage, 30));
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn the_judge_sees_a_ceiling_that_does_not_cut() {
    let kind = LightKind::Sphere { radius: 0.3 };
    let mut stage = lit(IN_ROOM, (ceiling(20), CEILING), kind, CEILING);
    let (with, mean) = soft_error(&mut stage, 100);
    let meshes = stage
        .world
        .query_filtered::<bevy_ecs::prelude::Entity, bevy_ecs::prelude::With<ShadowCaster>>();
    let last = { meshes }.iter(&stage.world).last();
    stage
        .world
        .entity_mut(last.expect("the ceiling"))
        .remove::<ShadowCaster>();
    let (without, lit_mean) = soft_error(&mut stage, 100);
    assert!(lit_mean > mean + 0.2, "{lit_mean} {mean}: {with:?} {without:?}");
}

#[test]
fn bulbs_and_shades_of_many_triangles_hide_as_rays_do() {
    let mut faults = Vec::new();
    let radius = 0.2;
    for (size, steps) in [(0.2, 3), (0.16, 3), (0.2, 4), (0.16, 4)] {
        let mesh = MeshData::icosphere(size, steps);
        let at = Vec3::Y * 2.0;
        let mut stage = lit(FROM_AFAR, (mesh, at), LightKind::Sphere { radius }, at);
        faults.extend(fault(&format!("bulb of {size}, {steps}"), &mut stage, 256));
    }
    for sides in [32, 64, 128] {
        let kind = LightKind::Sphere { radius: 0.6 };
        let mut stage = lit(FROM_AFAR, (shade(sides), Vec3::Y * 2.2), kind, Vec3::Y * 2.15);
        faults.extend(fault(&format!("shade of {sides}"), &mut stage, 64));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// What is in a plane through the light's centre, but beyond the light's extent, has penumbra edges and is not drawn over
/// the whole picture. Here a sheet with a hole around the lamp shadows the walls above and below it.
#[test]
fn surfaces_at_the_height_of_a_lamp_are_drawn_by_their_edges() {
    let mut mesh = sheet(12, 1.8);
    let is_in_hole = |corners: &[u32]| {
        let middle = corners.iter().map(|i| mesh.positions[*i as usize]).sum::<Vec3>() / 3.0;
        middle.x.abs().max(middle.z.abs()) < 0.6
    };
    let rim = mesh
        .indices
        .chunks_exact(3)
        .filter(|corners| !is_in_hole(corners));
    let indices = rim.flatten().copied().collect();
    mesh = MeshData::from_triangles("rim", mesh.positions.clone(), indices);
    let at = Vec3::Y * 1.2;
    let kind = LightKind::Sphere { radius: 0.3 };
    let mut stage = lit(Vec3::new(2.2, 2.0, 4.0), (mesh, at), kind, at);
    for (place, turn) in [
        (Vec3::new(-2.6, 1.2, 0.0), Quat::from_rotation_z(FRAC_PI_2)),
        (Vec3::new(0.0, 1.2, -2.6), Quat::from_rotation_x(FRAC_PI_2)),
    ] {
        let wall = Transform::from_translation(place).with_rotation(turn);
        stage.world.spawn(object(MeshData::plane(2.6), wall));
    }
    assert_eq!(fault("sheet at the height of the lamp", &mut stage, 0), None);
}
