//! The recorders and shaders of the techniques.

use std::sync::LazyLock;

use bevy_ecs::prelude::*;

use super::techniques::Techniques;
use crate::render::Renderer;
use crate::render::shaders::FILES;

/// Gives the renderer a recorder for each technique. Techniques whose recorders have the same type share one.
///
/// Set: `PrepareGpu`, before `prepare_techniques`. A frame without new techniques only compares two numbers.
pub fn add_recorders(mut renderer: ResMut<Renderer>, techniques: Res<Techniques>) {
    for row in techniques.rows.iter().skip(renderer.recorders().row_count()) {
        let made = renderer.add_recorder(row.gpu.kind, |gpu| {
            gpu.shaders.add(row.gpu.shaders)?;
            (row.gpu.make)(gpu)
        });
        if let Err(error) = made {
            renderer.fail(error);
            return; // the next frame tries again
        }
    }
}

/// Path and text of every WGSL file of the renderer and the crate's techniques that other files import.
pub static COMMON: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| files(true));

/// Path and text of every WGSL file of the renderer and the crate's techniques that has entry points.
pub static PASSES: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| files(false));

fn files(imported: bool) -> Vec<(&'static str, &'static str)> {
    let techniques = Techniques::default();
    let of_techniques = techniques.rows.iter().flat_map(|row| row.gpu.shaders);
    let mut files: Vec<(&str, &str)> = Vec::new();
    for file in FILES.iter().chain(of_techniques) {
        // Several techniques may share a file.
        if file.is_imported() == imported && !files.iter().any(|(path, _)| *path == file.path) {
            files.push((file.path, file.source));
        }
    }
    files
}
