//! Reports about lights that cannot shine, objects without usable bounds, and cells and portals that hide too
//! little.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;

use super::{CellIssue, Cells, FrameLights, Objects};
use crate::geometry::Aabb;
use crate::reports::Reports;
use crate::scene::placement::placed;
use crate::scene::{LightError, SceneMesh, Skin};

/// Raises the reports of the topics `light`, `light_model`, `object` and `cell`.
pub fn report_sets(world: &World, reports: &mut Reports) {
    report_lights(world.resource::<FrameLights>(), reports);
    report_models(world.resource::<FrameLights>(), reports);
    report_objects(world, world.resource::<Objects>(), reports);
    report_cells(world.resource::<Cells>(), reports);
}

fn report_lights(lights: &FrameLights, reports: &mut Reports) {
    let mut round = reports.round("light");
    for skipped in &lights.skipped {
        let (code, advice) = light_advice(&skipped.error);
        let error = skipped.error;
        round.state(
            Some(skipped.entity),
            code,
            format_args!("The light lights nothing: {error}. {advice}"),
        );
    }
}

/// Raises a report for each part of a light's model that has no effect.
fn report_models(lights: &FrameLights, reports: &mut Reports) {
    let mut round = reports.round("light_model");
    for (entity, fault) in &lights.faults {
        let (entity, code) = (Some(*entity), fault.code());
        if fault.leaves_out() {
            let message = format_args!(
                "A part of the light's model has no effect: {fault}. The light shines without it."
            );
            round.state(entity, code, message);
        } else {
            let message = format_args!("{fault}. Move it before the light if they should not.");
            round.state(entity, code, message);
        }
    }
}

/// Returns the report code of a light's error, and advice on how to mend it.
fn light_advice(error: &LightError) -> (u32, &'static str) {
    match error {
        LightError::Range(_) => (1, "Set a range in metres; infinity is allowed."),
        LightError::Intensity(_) => (2, "Set a finite intensity; 0 turns the light off."),
        LightError::Color(_) => (3, "Set a colour of finite components that are not negative."),
        LightError::Angles { .. } => (
            4,
            "Set the outer half-angle first, then an inner one that is not larger.",
        ),
        LightError::Size(_) => (5, "Set a finite size in metres; 0 makes it a point."),
        LightError::Transform => (
            6,
            "Look for NaN, infinity or a scale of 0 in its transform and in those of its parents.",
        ),
    }
}

/// Raises reports about objects that the sets left out. An object that would show nothing anyway is not
/// reported: its mesh has no triangles, its bounds are empty on purpose, or its scale is 0 along all axes,
/// which games use to hide things.
fn report_objects(world: &World, objects: &Objects, reports: &mut Reports) {
    let mut round = reports.round("object");
    if objects.left_out == 0 {
        return;
    }
    for index in objects.present.zeroes() {
        let entity = objects.entities[index];
        let mesh = world.get::<SceneMesh>(entity);
        let transform = world.get::<GlobalTransform>(entity);
        let (code, message) = match (mesh, transform) {
            (Some(mesh), _) if mesh.0.indices.is_empty() => continue,
            (_, Some(transform)) if !transform.affine().is_finite() => (
                1,
                "The object is neither drawn nor casts: its transform holds NaN or infinity. Look for the cause in its \
                 transform and in those of its parents.",
            ),
            (Some(_), Some(transform))
                if placed(transform, world.get::<Skin>(entity).is_some()).is_none() =>
            {
                let matrix = transform.affine().matrix3;
                let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
                if axes.iter().all(|axis| axis.length_squared() == 0.0) {
                    continue;
                }
                (
                    2,
                    "The object is neither drawn nor casts: its transform flattens it to a line or a point. Give it a \
                     scale other than 0 along at least two axes.",
                )
            }
            (Some(_), Some(_)) => (
                3,
                "The object is neither drawn nor casts: its mesh, as posed, has no finite vertex. Repair the mesh, or the \
                 joints and weights that pose it.",
            ),
            _ if has_nan(&objects.bounds[index]) => (
                4,
                "The object is neither drawn nor casts: its bounds hold NaN. Write finite `WorldBounds`.",
            ),
            _ => continue,
        };
        round.raise(Some(entity), code, || message.to_owned());
    }
}

fn has_nan(bounds: &Aabb) -> bool {
    bounds.min.is_nan() || bounds.max.is_nan()
}

fn report_cells(cells: &Cells, reports: &mut Reports) {
    let mut round = reports.round("cell");
    for &(entity, issue) in &cells.issues {
        let (code, advice) = cell_advice(issue);
        round.raise(Some(entity), code, || {
            let text = issue.to_string();
            let mut letters = text.chars();
            let first = letters.next().map(|letter| letter.to_ascii_uppercase());
            format!("{}{}. {advice}", first.unwrap_or_default(), letters.as_str())
        });
    }
}

/// Returns the report code of a cell's or portal's issue, and advice on how to mend it.
fn cell_advice(issue: CellIssue) -> (u32, &'static str) {
    match issue {
        CellIssue::Volume => (
            1,
            "Give the cell a box with volume and a transform without shear, NaN or infinity.",
        ),
        CellIssue::NotFlat => (2, "Move the outline's points into one plane."),
        CellIssue::NotConvex => (3, "Split the portal into convex ones."),
        CellIssue::Outline => (
            4,
            "Give the outline at least three finite points that are not in a line.",
        ),
        CellIssue::Dangling => (5, "Let the portal join two entities with a sound `Cell`."),
    }
}
