//! The reports of imported scenes, for hosts that show all reports of the crate.

use std::path::Path;

use bevy_ecs::prelude::*;

use super::LoadedGltf;
use crate::reports::Reports;

/// Lists, for each spawned scene, the parts of its file that were left out.
#[derive(Resource, Default, Debug)]
struct ImportReports(Vec<ImportReport>);

#[derive(Debug)]
struct ImportReport {
    /// The root of the spawned scene. The lines are withdrawn when it is despawned.
    root: Entity,
    lines: Vec<String>,
}

/// Keeps the report of a file for as long as a scene of it lives.
pub(super) fn keep(world: &mut World, gltf: &LoadedGltf, root: Entity) {
    if gltf.report.is_empty() {
        return;
    }
    let name = gltf.file.file_name().map_or(gltf.file.as_path(), Path::new);
    let line = |skip| format!("{}: {skip}.", name.display());
    let lines = gltf.report.skips.iter().map(line).collect();
    world
        .get_resource_or_init::<ImportReports>()
        .0
        .push(ImportReport { root, lines });
}

/// Raises the reports of the topic `import`: what was left out of the scenes that are spawned.
pub(crate) fn report_imports(world: &World, reports: &mut Reports) {
    let mut round = reports.round("import");
    let Some(imports) = world.get_resource::<ImportReports>() else {
        return;
    };
    for ImportReport { root, lines } in &imports.0 {
        if world.get_entity(*root).is_ok() {
            for (code, line) in lines.iter().enumerate() {
                round.raise(Some(*root), code as u32, || line.clone());
            }
        }
    }
}
