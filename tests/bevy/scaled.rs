//! A light function scales what Bevy adds of a managed light, on surfaces that show shadows and on those that do not.

use antumbra::bevy_adapter::prelude::*;
use antumbra::insides::{prepare_objects, prepare_techniques};
use antumbra::prelude::Renderer;
use antumbra::render::{Gpu, NoRecorder, RenderError};
use antumbra::schedule::AntumbraSystems;
use antumbra::techniques::{AddTechnique, Needs, Technique};
use bevy::light::NotShadowReceiver;
use bevy::prelude::*;

use crate::core_harness::half::Half;
use crate::harness::{self, Game};

/// Marks games whose lights are halved: a technique that marks no light, and gives each view the function.
#[derive(Component, Clone, Copy, Default, PartialEq)]
struct NoLight;

impl Technique for NoLight {
    const NAME: &'static str = "no_light";
    const NEEDS: Needs = Needs::NOTHING;

    type Recorder = NoRecorder;

    fn recorder(_: &Gpu) -> Result<NoRecorder, RenderError> {
        Ok(NoRecorder)
    }

    fn add_systems(schedule: &mut Schedule) {
        let add = |mut renderer: ResMut<Renderer>| {
            if !renderer.has_light_functions() {
                let half = Half::new(renderer.gpu());
                renderer
                    .add_light_function(Box::new(half))
                    .expect("shaders compose");
            }
        };
        schedule.add_systems(
            add.run_if(resource_exists::<Renderer>)
                .after(prepare_objects)
                .before(prepare_techniques)
                .in_set(AntumbraSystems::PrepareGpu),
        );
    }
}

#[test]
fn half_of_each_managed_light_is_added() {
    let mean = |halved: bool, mapped: bool, receives: bool| {
        let mut app = harness::antumbra();
        app.insert_resource(GlobalAmbientLight::NONE);
        if halved {
            app.add_technique::<NoLight>();
        }
        let world = app.world_mut();
        let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
        let floor = Plane3d::default().mesh().size(8.0, 8.0);
        let floor = harness::add_mesh(world, floor, Transform::default());
        if !receives {
            world.entity_mut(floor).insert(NotShadowReceiver);
        }
        let ball = Sphere::new(0.6).mesh().ico(3).expect("a ball");
        harness::add_mesh(world, ball, Transform::from_xyz(0.0, 0.8, 0.0));
        let light = harness::add_light(world);
        if mapped {
            world
                .entity_mut(light)
                .remove::<StencilVolume>()
                .insert(OmniMap::default());
        }
        Game::start(app).run(5).settled(camera).mean()
    };
    for mapped in [false, true] {
        for receives in [true, false] {
            let share = mean(true, mapped, receives) / mean(false, mapped, receives);
            assert!(
                (share - 0.5).abs() < 0.002,
                "mapped {mapped}, receives {receives}: {share}"
            );
        }
    }
}
