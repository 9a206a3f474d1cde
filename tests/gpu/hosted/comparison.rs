//! Visibility in a frame of our own beside that in a host.

use antumbra::prelude::*;
use antumbra::reference::{RayScene, primary_hits};
use antumbra::render::HostView;
use bevy_transform::prelude::GlobalTransform;

use super::host::Host;
use super::scenes::SIZE;
use crate::harness::support::stage::Stage;

/// Pictures of the first light's visibility: of a frame of our own, and of one in a host.
pub fn both(context: &RenderContext, stage: &mut Stage, view: HostView) -> [Vec<f32>; 2] {
    let set_host = |stage: &mut Stage, view| {
        let mut renderer = stage.world.resource_mut::<Renderer>();
        renderer.set_host(view).expect("shaders compose");
    };
    set_host(stage, None);
    let own = stage.render().expect("the frame renders").visibility.remove(0);
    set_host(stage, Some(view));
    let host = Host::new(context, view);
    stage.schedule.run(&mut stage.world);
    host.draw_depth(&mut stage.world, SIZE);
    let mut renderer = stage.world.resource_mut::<Renderer>();
    assert!(renderer.take_failure().is_none());
    assert!(renderer.radiance().is_none(), "the host has the radiance");
    let (added, values) = host.add_lights(&renderer);
    assert_eq!(added, stage.lights, "each light is added once");
    let outside = values.len() - SIZE.element_product() as usize;
    let hosted = host.crop(&values, SIZE);
    let nothing = values.iter().filter(|value| **value == 0.0).count();
    let inside = hosted.iter().filter(|value| **value == 0.0).count();
    assert_eq!(nothing - inside, outside, "nothing outside of the view is lit");
    [own, hosted]
}

/// Whether each pixel shows something.
fn shows(stage: &mut Stage) -> Vec<bool> {
    let scene = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).unwrap();
    let transform = stage.world.get::<GlobalTransform>(stage.camera).unwrap();
    let hits = primary_hits(&scene, camera, transform, SIZE).unwrap().hits;
    hits.iter().map(Option::is_some).collect()
}

/// The visibility of a hosted picture as the judge has it: where nothing is, a host adds nothing, and visibility is 1.
pub fn visibility_of_shown(stage: &mut Stage, hosted: &[f32]) -> Vec<f32> {
    let pairs = hosted.iter().zip(shows(stage));
    pairs
        .map(|(value, shows)| if shows { *value } else { 1.0 })
        .collect()
}

/// Of pixels that show something, off the edges of shadows, where two rasterizers may differ: how many differ, how many
/// there are.
pub fn differing(stage: &mut Stage, own: &[f32], hosted: &[f32], tolerance: f32) -> (usize, usize) {
    let shows = shows(stage);
    let (width, height) = (SIZE.x as usize, SIZE.y as usize);
    let flat = |picture: &[f32], p: usize| {
        [p, p - 1, p + 1, p - width, p + width]
            .iter()
            .all(|&q| shows[q] && (picture[q] - picture[p]).abs() <= tolerance)
    };
    let inner = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x));
    let judged: Vec<usize> = inner.filter(|&p| flat(own, p)).collect();
    let wrong = judged.iter().filter(|&&p| (own[p] - hosted[p]).abs() > tolerance);
    (wrong.count(), judged.len())
}
