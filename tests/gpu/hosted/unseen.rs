//! Objects that the host does not show, and those that the light does not see.

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::sets::FrameLights;
use bevy_ecs::prelude::*;

use super::comparison::{both, differing, visibility_of_shown};
use super::host::Host;
use super::scenes::{SIZE, alone, camera, dark_tiles, light_at, stage};
use crate::harness::{judge, strict_context};

/// The host does not show an object that casts, as when its material is all hole: what lies behind it receives, and shows
/// its shadow.
#[test]
fn what_the_host_does_not_show_still_casts() {
    let context = strict_context();
    let view = alone(&camera());
    let mut stage = stage(&context, camera());
    light_at(&mut stage, LightKind::Point, StencilVolume::default());
    let ball = stage
        .world
        .query_filtered::<(Entity, &SceneMesh), With<ShadowCaster>>()
        .iter(&stage.world)
        .max_by_key(|(_, mesh)| mesh.0.indices.len())
        .map(|(entity, _)| entity)
        .expect("there is a ball");
    // Told so, since its surface would otherwise be taken to hide its near cap.
    stage.world.entity_mut(ball).remove::<SceneMaterials>();
    let mut renderer = stage.world.resource_mut::<Renderer>();
    renderer.set_host(Some(view)).unwrap();
    stage.schedule.run(&mut stage.world);
    let mut host = Host::new(&context, view);
    host.hidden = Some(ball);
    host.draw_depth(&mut stage.world, SIZE);
    let (_, hosted) = host.add_lights(stage.world.resource::<Renderer>());
    let shown = visibility_of_shown(&mut stage, &hosted);
    let scene = RayScene::from_world(&mut stage.world);
    let error = judge(&stage, &scene, 0, &shown);
    println!("{error:?}");
    assert_eq!(error.wrong_inner, 0, "{error:?}");
    assert!(error.inner > 10_000);
}

#[test]
fn what_the_light_does_not_see_stays_dark() {
    let context = strict_context();
    let mut stage = dark_tiles(&context);
    let [own, hosted] = both(&context, &mut stage, alone(&camera()));
    let lights = stage.world.resource::<FrameLights>();
    assert!(
        lights.lights[0].sets.dark.count_ones(..) > 6,
        "tiles are left out"
    );
    let (wrong, judged) = differing(&mut stage, &own, &hosted, 0.0);
    println!("{wrong} of {judged} pixels differ off the edges");
    assert_eq!(wrong, 0);
}
