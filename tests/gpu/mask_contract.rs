//! The light pass multiplies by what a technique leaves in the mask, and by nothing else; lights with masks, with
//! stencils and without shadows mix in a frame.

use std::sync::Arc;

use crate::harness::strict_context;
use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;
use antumbra::prelude::*;
use antumbra::render::RenderError;
use antumbra::render::{Gpu, Leaves, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput};
use antumbra::techniques::{Needs, Technique};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

/// The mask that the technique of a third party leaves everywhere.
const MASK: [f64; 4] = [0.25, 0.5, 0.75, 0.125];

/// Leaves the same mask of every light.
#[derive(Component, Clone, Default, PartialEq)]
struct Flat;

impl Technique for Flat {
    const NAME: &'static str = "flat";
    const NEEDS: Needs = Needs::NOTHING;

    type Recorder = FlatTechnique;

    fn recorder(_: &Gpu) -> Result<FlatTechnique, RenderError> {
        Ok(FlatTechnique::default())
    }
}

/// Clears the mask to one value.
#[derive(Default)]
struct FlatTechnique {
    lights: Vec<usize>,
}

impl Resolve for FlatTechnique {
    fn resolve(&self, _: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let [r, g, b, a] = MASK;
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("flat"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
    }
}

impl Recorder for FlatTechnique {
    fn prepare(&mut self, world: &World, _: &PrepareInput) -> Result<(), RenderError> {
        let lights = &world.resource::<FrameLights>().lights;
        let claimed = |&index: &usize| lights[index].is_shadowed_by::<Flat>();
        self.lights = (0..lights.len()).filter(claimed).collect();
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.lights.contains(&light).then_some(Leaves::Mask(self))
    }

    fn debug(&self, _: usize, _: &mut wgpu::RenderPass, _: &RecordInput) {}

    fn batch_count(&self, _: usize) -> usize {
        1
    }
}

/// How the light of a stage is shadowed.
#[derive(Clone, Copy, PartialEq)]
enum Shadow {
    Dark,
    None,
    Flat,
    Stencil,
}

fn render(first: Shadow, second: Shadow, plane_receives: bool) -> Rendered {
    let view = Transform::from_xyz(3.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: 2.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(64, 32), camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    (&mut stage.world, &mut stage.schedule).add_technique::<Flat>();
    let material = Arc::new(Material::matte(Vec3::ONE));
    let materials = || SceneMaterials([material.clone()].into());
    let plane = SceneMesh(Arc::new(MeshData::plane(5.0)));
    let mut plane = stage.world.spawn((plane, materials(), Transform::default()));
    if plane_receives {
        plane.insert(ShadowReceiver);
    }
    stage.world.spawn((
        SceneMesh(Arc::new(MeshData::icosphere(0.5, 2))),
        materials(),
        (ShadowCaster, ShadowReceiver),
        Transform::from_xyz(0.0, 1.0, 0.0),
    ));
    for (x, shadow) in [(-2.0, first), (2.0, second)] {
        let intensity = if shadow == Shadow::Dark { 0.0 } else { 20.0 };
        let light = Light::point(Vec3::ONE, intensity, 20.0);
        let place = Transform::from_xyz(x, 3.0, 1.0);
        let entity = stage.spawn_light(
            light,
            place,
            (shadow == Shadow::Stencil).then_some(StencilVolume::default()),
        );
        if shadow == Shadow::Flat {
            stage.world.entity_mut(entity).insert(Flat);
        }
    }
    stage.render().expect("the frame renders")
}

/// Largest difference of radiance between a picture and `base + Σ (part − base) · weight`, in units of the radiance
/// target's rounding at 4.
fn difference(picture: &Rendered, base: &Rendered, parts: &[(&Rendered, [f64; 4])]) -> f32 {
    let mut largest: f32 = 0.0;
    for (i, &actual) in picture.radiance.iter().enumerate().filter(|(i, _)| i % 4 != 3) {
        let ambient = base.radiance[i];
        let added: f32 = parts
            .iter()
            .map(|(part, weight)| (part.radiance[i] - ambient) * weight[i % 4] as f32)
            .sum();
        largest = largest.max((actual - ambient - added).abs());
    }
    largest * 512.0
}

const ALL: [f64; 4] = [1.0; 4];

#[test]
fn light_is_multiplied_by_the_mask_and_mixes_with_others() {
    use Shadow::*;
    let dark = render(Dark, Dark, true);
    let first = render(None, Dark, true);
    let masked = render(Flat, Dark, true);
    assert!(difference(&masked, &dark, &[(&first, MASK)]) < 2.0);
    assert!(
        difference(&masked, &dark, &[(&first, ALL)]) > 50.0,
        "the comparison can fail"
    );
    for second in [None, Stencil, Flat] {
        let alone = render(Dark, second, true);
        let both = render(Flat, second, true);
        assert!(difference(&both, &dark, &[(&masked, ALL), (&alone, ALL)]) < 4.0);
    }
}

#[test]
fn visibility_outputs_show_the_masks_alpha_on_receivers_alone() {
    let rendered = render(Shadow::Flat, Shadow::None, true);
    let masked = rendered.visibility[0]
        .iter()
        .filter(|&&v| v == MASK[3] as f32)
        .count();
    let lit = rendered.visibility[0].iter().filter(|&&v| v == 1.0).count();
    assert!(masked > 500, "{masked}");
    assert_eq!(masked + lit, 64 * 32);
    assert!(rendered.visibility[1].iter().all(|&v| v == 1.0));
    let fewer = render(Shadow::Flat, Shadow::None, false);
    let on_sphere = fewer.visibility[0]
        .iter()
        .filter(|&&v| v == MASK[3] as f32)
        .count();
    assert!(on_sphere > 0 && on_sphere < masked, "{on_sphere}");
    let unshadowed = render(Shadow::None, Shadow::None, false);
    let equal = (0..64 * 32)
        .filter(|&p| fewer.visibility[0][p] == 1.0)
        .all(|p| fewer.radiance[4 * p..4 * p + 3] == unshadowed.radiance[4 * p..4 * p + 3]);
    assert!(equal, "what is no receiver is lit as without a technique");
}
