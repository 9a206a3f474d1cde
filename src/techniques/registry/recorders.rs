//! The recorders and shaders of the techniques.

use std::sync::LazyLock;

use bevy_ecs::prelude::*;

use super::techniques::Techniques;
use crate::render::Renderer;
use crate::render::shaders::FILES;

/// Gives a renderer the recorder of each technique, one for all techniques whose recorders are of one type.
///
/// Set: `PrepareGpu`, before `prepare_techniques`. Only a frame after which there are more techniques does more than
/// compare two numbers.
pub fn add_recorders(mut renderer: ResMut<Renderer>, techniques: Res<Techniques>) {
    for row in techniques.rows.iter().skip(renderer.recorders().row_count()) {
        let made = renderer.add_recorder(row.gpu.kind, |gpu| {
            gpu.shaders.add(row.gpu.shaders)?;
            (row.gpu.make)(gpu)
        });
        if let Err(error) = made {
            renderer.fail(error);
            return; // and again in the next frame
        }
    }
}

/// Path and text of every WGSL file that others import, of the renderer and of the crate's techniques.
pub static COMMON: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| files(true));

/// Path and text of every WGSL file with entry points.
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
