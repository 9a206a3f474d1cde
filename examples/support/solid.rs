//! Alpha-tested surfaces, made solid as the ray caster sees them.

use std::sync::Arc;

use antumbra::prelude::*;

use super::stage::Stage;

/// Returns the number of objects that have alpha-tested surfaces.
pub fn count_alpha_tested(stage: &mut Stage) -> usize {
    let mut query = stage.world.query::<&SceneMaterials>();
    let objects = query.iter(&stage.world);
    objects
        .filter(|materials| materials.0.iter().any(is_alpha_tested))
        .count()
}

/// Makes every texel of alpha-tested surfaces solid, as in the ray caster.
pub fn make_alpha_solid(stage: &mut Stage) {
    let mut query = stage.world.query::<&mut SceneMaterials>();
    for mut materials in query.iter_mut(&mut stage.world) {
        // Materials that stay as they are do not count as changed.
        if materials.0.iter().any(is_alpha_tested) {
            for material in materials
                .0
                .iter_mut()
                .filter(|material| is_alpha_tested(material))
            {
                Arc::make_mut(material).alpha_mode = AlphaMode::Mask(0.0);
            }
        }
    }
}

fn is_alpha_tested(material: &Arc<Material>) -> bool {
    matches!(material.alpha_mode, AlphaMode::Mask(_))
}
