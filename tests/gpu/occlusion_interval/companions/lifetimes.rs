//! Second techniques that come, go, do not fit, or shadow alone.

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::techniques::{IntervalLibrary, MapResolution, TextureMemory};

use super::{add, companions, visibility, with_boxes};
use crate::occlusion_interval::faults::said;
use crate::occlusion_interval::scenes::{maps, settings};

#[test]
fn a_second_technique_comes_and_goes_with_its_light() {
    let mut stage = with_boxes(0.4, 0.02);
    let light = stage.lights[0];
    let alone = visibility(&mut stage);
    assert_eq!(companions(&mut stage), 0);
    let strangers = said(&stage);
    assert!(
        strangers.len() == 1 && strangers[0].starts_with("2 receivers are not in"),
        "{strangers:?}"
    );
    add(&mut stage, StencilVolume::default());
    let with_stencil = visibility(&mut stage);
    assert_eq!(companions(&mut stage), 2);
    assert_eq!(said(&stage), [] as [String; 0]);
    assert!(with_stencil != alone);
    stage
        .world
        .entity_mut(light)
        .remove::<StencilVolume>()
        .insert(ShadowMap::default());
    let with_map = visibility(&mut stage);
    assert!(with_map != alone);
    assert!(with_map != with_stencil);
    // Settings are followed.
    let coarse = ShadowMap {
        resolution: MapResolution::Fixed(64),
        ..Default::default()
    };
    stage.world.entity_mut(light).insert(coarse);
    assert!(visibility(&mut stage) != with_map);
    stage.world.entity_mut(light).insert(ShadowMap::default());
    assert!(visibility(&mut stage) == with_map);
    // A third one has no effect.
    stage.world.entity_mut(light).insert(StencilVolume::default());
    assert_eq!(
        visibility(&mut stage),
        with_stencil,
        "the first of the list is used"
    );
    let reports = said(&stage);
    assert!(
        reports.len() == 1
            && reports[0].contains("3 shadow techniques")
            && reports[0].contains("OcclusionInterval and StencilVolume are used"),
        "{reports:?}"
    );
    stage
        .world
        .entity_mut(light)
        .remove::<(StencilVolume, ShadowMap)>();
    assert!(visibility(&mut stage) == alone);
    assert_eq!((companions(&mut stage), said(&stage)), (0, strangers));
    // Without maps the other technique is the technique of the light.
    add(&mut stage, StencilVolume::default());
    let kept = stage
        .world
        .entity_mut(light)
        .take::<OcclusionInterval>()
        .expect("it has maps");
    let of_volumes = visibility(&mut stage);
    assert_eq!(companions(&mut stage), 0);
    stage.world.entity_mut(light).insert(kept);
    assert!(visibility(&mut stage) == with_stencil);
    assert!(of_volumes != with_stencil);
    assert_eq!(companions(&mut stage), 2);
    stage.world.despawn(light);
    stage.lights.clear();
    stage.render().expect("the frame renders");
    assert_eq!(companions(&mut stage), 0, "they go with the light");
}

#[test]
fn without_usable_maps_the_second_technique_shadows_everything() {
    let mut plain = with_boxes(0.4, 0.0);
    let light = plain.lights[0];
    add(&mut plain, StencilVolume::default());
    visibility(&mut plain); // the maps' technique puts the light on its path
    plain.world.entity_mut(light).remove::<OcclusionInterval>();
    let all = visibility(&mut plain);
    let mut stage = with_boxes(0.4, 0.0);
    add(&mut stage, StencilVolume::default());
    let both = visibility(&mut stage);
    assert!(both != all, "shadows of maps have texels");
    let kept = maps();
    stage.world.resource_mut::<IntervalLibrary>().forget("ladder");
    assert!(visibility(&mut stage) == all, "the maps cannot be read");
    let reports = said(&stage);
    assert!(
        reports.len() == 1 && reports[0].starts_with("The light's other technique alone shadows it"),
        "{reports:?}"
    );
    let of_light = stage
        .world
        .resource::<Reports>()
        .of_entity(stage.lights[0])
        .count();
    assert_eq!(of_light, 1, "the report is about the light of the scene");
    stage
        .world
        .resource_mut::<IntervalLibrary>()
        .insert("ladder", kept);
    assert!(visibility(&mut stage) == both);
    // Memory is known to be short from the second frame on.
    stage.world.resource_mut::<TextureMemory>().limit = 1000;
    visibility(&mut stage);
    assert!(visibility(&mut stage) == all, "there is no memory for the maps");
    assert!(visibility(&mut stage) == all, "and it stays so");
    stage.world.resource_mut::<TextureMemory>().limit = 1 << 30;
    visibility(&mut stage);
    assert!(visibility(&mut stage) == both);
    // A light that maps cannot shadow.
    let broken = OcclusionInterval {
        maps: String::new(),
        ..settings(0.4, 0.0)
    };
    stage.world.entity_mut(stage.lights[0]).insert(broken);
    assert!(visibility(&mut stage) == all, "the maps are not named");
    visibility(&mut stage);
    let mended = settings(0.4, 0.0);
    stage.world.entity_mut(stage.lights[0]).insert(mended);
    assert!(visibility(&mut stage) == both, "they are named again");
}

#[test]
fn a_second_technique_that_does_not_fit_is_reported_about_the_light() {
    let mut stage = with_boxes(0.4, 0.0);
    let alone = visibility(&mut stage);
    add(&mut stage, OmniMap::default());
    assert!(visibility(&mut stage) == alone);
    let light = stage.lights[0];
    let reports: Vec<String> = {
        let reports = stage.world.resource::<Reports>();
        reports
            .of_entity(light)
            .map(|report| report.message.clone())
            .collect()
    };
    let about = |what: &str| reports.iter().filter(|report| report.contains(what)).count();
    assert_eq!(
        (about("OmniMap does not fit"), reports.len()),
        (1, 2),
        "{reports:?}"
    );
    assert_eq!(
        about("are not in the light's maps"),
        1,
        "nothing shadows them: {reports:?}"
    );
}
