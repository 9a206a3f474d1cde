//! Alpha-tested surfaces, made solid as the ray caster sees them.

use std::sync::Arc;

use antumbra::prelude::*;

use super::stage::Stage;

/// Makes every texel of alpha-tested surfaces solid, as in the ray caster. Returns the number of objects that have
/// such surfaces.
pub fn make_alpha_solid(stage: &mut Stage) -> usize {
    let mut query = stage.world.query::<&mut SceneMaterials>();
    let mut count = 0;
    for mut materials in query.iter_mut(&mut stage.world) {
        let is_masked = |material: &Arc<Material>| matches!(material.alpha_mode, AlphaMode::Mask(_));
        if !materials.0.iter().any(is_masked) {
            continue;
        }
        count += 1;
        for material in materials.0.iter_mut().filter(|material| is_masked(material)) {
            Arc::make_mut(material).alpha_mode = AlphaMode::Mask(0.0);
        }
    }
    count
}
