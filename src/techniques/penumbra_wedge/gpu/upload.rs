//! Uploads the data of a frame's wedges, and requests the pipelines that its lights need.

use super::pipelines::{Key, Part, ResolveKey, describe, describe_resolve};
use super::plans::{LightPlan, counts_towards, light_record, passes};
use super::recorder::PenumbraWedgeNode;
use super::windows::shared;
use crate::render::{Gpu, RenderContext, RenderError};
use crate::sets::ViewData;
use crate::techniques::penumbra_wedge::component::{CoverageMaths, Overlap};
use crate::techniques::penumbra_wedge::wedges::PenumbraWedges;

impl PenumbraWedgeNode {
    /// Uploads the data that changed.
    pub(super) fn upload(&mut self, context: &RenderContext, world: &PenumbraWedges, view: &ViewData) {
        self.light_records.clear();
        self.light_records
            .extend(world.parts.iter().map(|part| light_record(part, view)));
        let mut rebind = self.tables.place(world, &mut self.light_records)
            && self
                .table_buffer
                .write(context, bytemuck::cast_slice(self.tables.entries()));
        self.lights.constants.clear();
        for record in &self.light_records {
            self.lights.constants.push(record);
        }
        rebind |= self.lights.write(context);
        if self.casters_generation != world.casters_generation {
            self.casters_generation = world.casters_generation;
            rebind |= self
                .casters
                .write(context, bytemuck::cast_slice(&world.caster_records));
        }
        if self.generation != world.generation {
            self.generation = world.generation;
            let shared = shared(&self.casters, &self.lights, &self.table_buffer);
            self.wedges
                .write(context, &self.long_lived.wedge_layout, &world.wedges, shared);
            self.caps.write(context, bytemuck::cast_slice(&world.caps));
        }
        if rebind {
            let shared = shared(&self.casters, &self.lights, &self.table_buffer);
            self.wedges.rebind(context, &self.long_lived.wedge_layout, shared);
        }
    }

    /// Requests the pipelines that a light needs.
    pub(super) fn require(&mut self, gpu: &Gpu, plan: &LightPlan, debug: bool) -> Result<(), RenderError> {
        let wedges = &self.long_lived.wedge_layout;
        let mirrored = self.mirrored;
        let looks_up = plan.settings.maths == CoverageMaths::Tables;
        for part in &self.parts[plan.parts.clone()] {
            let mut require_turned = |part_of_wedge, towards, turned: bool| {
                let key = Key {
                    part: part_of_wedge,
                    form: plan.form,
                    is_sphere: part.is_sphere,
                    looks_up,
                    towards,
                    mirrored: mirrored != turned,
                };
                gpu.require(&mut self.pipelines, key, |gpu| describe(gpu, wedges, key))
            };
            for (layers, turned) in (1..=3).flat_map(|layers| [(layers, false), (layers, true)]) {
                require_turned(Part::NearCap(layers), false, turned)?;
                require_turned(Part::FarCap(layers), false, turned)?;
            }
            let mut require = |part_of_wedge, towards| require_turned(part_of_wedge, towards, false);
            for kind in passes(plan.settings.culling, part.has_extent) {
                require(*kind, false)?;
                if counts_towards(*kind) {
                    require(*kind, true)?;
                }
            }
            if debug {
                require(Part::Show, false)?;
            }
        }
        let is_sphere = self.parts[plan.parts.clone()].iter().any(|part| part.is_sphere);
        let is_combined = plan.settings.overlap == Overlap::Paper;
        let mut require = |combines, is_combined| {
            let key = ResolveKey {
                form: plan.form,
                is_sphere,
                combines,
                is_combined,
            };
            let sums = self.textures.layout();
            let describe = |gpu: &Gpu| describe_resolve(gpu, wedges, sums, key);
            gpu.require(&mut self.resolves, key, describe)
        };
        require(false, is_combined)?;
        if is_combined {
            require(true, false)?;
        }
        Ok(())
    }
}
