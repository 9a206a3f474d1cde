//! A technique of somebody else: it knows nothing of Bevy, and the adapter nothing of it.

use antumbra::bevy_adapter::prelude::*;
use antumbra::insides::{prepare_objects, prepare_techniques};
use antumbra::prelude::Renderer;
use antumbra::render::RenderError;
use antumbra::render::{Leaves, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput};
use antumbra::scene::ShadowedLight;
use antumbra::schedule::AntumbraSystems;
use antumbra::sets::FrameLights;
use bevy::prelude::*;

use crate::harness::{self, Game};

/// A light of which so much is seen, everywhere.
#[derive(Component, Clone, Copy, PartialEq)]
#[require(ShadowedLight)]
struct Veiled(f32);

#[derive(Default)]
struct Veil {
    lights: Vec<(usize, f32)>,
}

impl Resolve for Veil {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let seen = self.lights.iter().find(|&&(own, _)| own == light);
        let seen = f64::from(seen.map_or(1.0, |&(_, seen)| seen));
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("veil"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color {
                        r: seen,
                        g: seen,
                        b: seen,
                        a: seen,
                    }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
    }
}

impl Recorder for Veil {
    fn name(&self) -> &'static str {
        "veil"
    }

    fn prepare(&mut self, world: &World, _: &PrepareInput) -> Result<(), RenderError> {
        let lights = &world.resource::<FrameLights>().lights;
        let veil = |light: usize| Some((light, world.get::<Veiled>(lights[light].entity)?.0));
        self.lights = (0..lights.len()).filter_map(veil).collect();
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        let own = self.lights.iter().any(|&(own, _)| own == light);
        own.then_some(Leaves::Mask(self))
    }

    fn debug(&self, _: usize, _: &mut wgpu::RenderPass, _: &RecordInput) {}

    fn batch_count(&self, _: usize) -> usize {
        1
    }
}

/// What the technique does in any world of the core's.
fn set_up(_: &mut World, schedule: &mut Schedule) {
    schedule.add_systems(
        (|mut renderer: ResMut<Renderer>| {
            if !renderer.has_technique("veil") {
                renderer.add_technique(Box::new(Veil::default()));
            }
        })
        .run_if(resource_exists::<Renderer>)
        .after(prepare_objects)
        .before(prepare_techniques)
        .in_set(AntumbraSystems::PrepareGpu),
    );
}

#[test]
fn a_technique_of_somebody_else_joins_the_frame() {
    let mut app = harness::antumbra();
    app.insert_resource(GlobalAmbientLight::NONE);
    app.add_shadow_technique::<Veiled>(set_up);
    let world = app.world_mut();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    let light = harness::add_light(world);
    world.entity_mut(light).remove::<StencilVolume>();
    let mut game = Game::start(app);
    let lit = game.run(5).settled(camera);
    for (seen, technique) in [(0.25, 0), (0.75, 0), (1.0, 1)] {
        let mut entity = game.world().entity_mut(light);
        match technique {
            0 => entity.insert(Veiled(seen)),
            // Ours in its place.
            _ => entity.remove::<Veiled>().insert(StencilVolume::default()),
        };
        let picture = game.run(4).settled(camera);
        let share = picture.mean() / lit.mean();
        println!("{seen} of the light is seen: {share}");
        assert!((share - seen).abs() < 0.01, "{share}");
    }
}
