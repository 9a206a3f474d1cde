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

/// Mean radiance of a lit ball over a floor: under volumes and under a map, with a floor that receives shadows and with one
/// that does not.
fn means(halved: bool) -> [f32; 4] {
    let mut app = harness::antumbra();
    app.insert_resource(GlobalAmbientLight::NONE);
    if halved {
        app.add_technique::<NoLight>();
    }
    let world = app.world_mut();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    let floor = harness::add_mesh(world, floor, Transform::default());
    let ball = Sphere::new(0.6).mesh().ico(3).expect("a ball");
    harness::add_mesh(world, ball, Transform::from_xyz(0.0, 0.8, 0.0));
    let light = harness::add_light(world);
    let mut game = Game::start(app);
    [(false, true), (false, false), (true, false), (true, true)].map(|(mapped, receives)| {
        let world = game.world();
        if receives {
            world.entity_mut(floor).remove::<NotShadowReceiver>();
        } else {
            world.entity_mut(floor).insert(NotShadowReceiver);
        }
        if mapped {
            let mut light = world.entity_mut(light);
            light.remove::<StencilVolume>().insert(OmniMap::default());
        }
        game.run(5).settled(camera).mean()
    })
}

#[test]
fn half_of_each_managed_light_is_added() {
    let (halved, whole) = (means(true), means(false));
    for (halved, whole) in halved.into_iter().zip(whole) {
        assert!((halved / whole - 0.5).abs() < 0.002, "{halved} of {whole}");
    }
    assert!(
        whole[1] > 1.001 * whole[0],
        "a floor that receives no shadow is brighter"
    );
}
