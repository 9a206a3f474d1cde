//! The scissor and the depth bounds of a light act on the GPU. Right ones change no picture, so these tests cut them.

use antumbra::prelude::*;
use antumbra::sets::ScissorRect;
use antumbra::techniques::maps::MapResolution;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::IntoScheduleConfigs;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{SIZE, draw, ground, lamp, object, set_technique};
use crate::harness::support::stage::Stage;

/// The parts that are cut off the region of every light.
#[derive(Resource, Clone, Copy)]
struct Cut {
    /// Keeps the left half of the picture.
    scissor: bool,
    /// Keeps what is nearer than 6 m.
    depth: bool,
}

fn cut_regions(mut lights: ResMut<FrameLights>, cut: Res<Cut>) {
    for light in &mut lights.lights {
        if cut.scissor {
            light.region.scissor = Some(ScissorRect {
                x: 0,
                y: 0,
                width: SIZE.x / 2,
                height: SIZE.y,
            });
        }
        if let (true, Some(bounds)) = (cut.depth, &mut light.region.depth_bounds) {
            bounds.depth_min = 0.1 / 6.0;
        }
    }
}

/// A lit box on a ground.
fn scene(technique: &str) -> Stage {
    let mut stage = ground();
    let place = Transform::from_xyz(0.0, 0.6, 0.0);
    stage
        .world
        .spawn(object(MeshData::cuboid(Vec3::splat(0.4)), place));
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.6, 4.0, 0.8), 30.0);
    set_technique(&mut stage, light, technique);
    if let Some(mut map) = stage.world.get_mut::<OmniMap>(light) {
        map.resolution = MapResolution::Fixed(256);
    }
    stage
}

/// The picture with a cut, by texel.
fn cut_picture(technique: &str, cut: Cut, settings: RenderSettings) -> Vec<[f32; 4]> {
    let mut stage = scene(technique);
    stage.world.insert_resource(cut);
    stage.world.resource_mut::<Renderer>().settings = settings;
    stage.schedule.add_systems(
        cut_regions
            .after(AntumbraSystems::CollectSets)
            .before(AntumbraSystems::BuildSilhouettes),
    );
    texels(&mut stage)
}

fn texels(stage: &mut Stage) -> Vec<[f32; 4]> {
    bytemuck::cast_slice(&draw(stage).radiance).to_vec()
}

/// The picture as it is, and without the light.
fn whole_and_unlit(technique: &str) -> [Vec<[f32; 4]>; 2] {
    let mut stage = scene(technique);
    let whole = texels(&mut stage);
    let light = stage.lights.remove(0);
    stage.world.despawn(light);
    [whole, texels(&mut stage)]
}

#[test]
fn lights_end_at_their_scissor() {
    let cut = Cut {
        scissor: true,
        depth: false,
    };
    for technique in ["stencil", "wedges", "map"] {
        let [whole, unlit] = whole_and_unlit(technique);
        let got = cut_picture(technique, cut, RenderSettings::default());
        let mut told = 0;
        for (pixel, got) in got.iter().enumerate() {
            let is_left = (pixel as u32 % SIZE.x) < SIZE.x / 2;
            let expected = if is_left { &whole } else { &unlit };
            assert_eq!(*got, expected[pixel], "{technique}: pixel {pixel}");
            told += usize::from(!is_left && whole[pixel] != unlit[pixel]);
        }
        assert!(told > 1000, "{technique}: {told}");
    }
}

#[test]
fn lights_end_at_their_depth_bounds() {
    let cut = Cut {
        scissor: false,
        depth: true,
    };
    let [whole, unlit] = whole_and_unlit("stencil");
    let got = cut_picture("stencil", cut, RenderSettings::default());
    let [mut near, mut far] = [0, 0];
    for (pixel, got) in got.iter().enumerate().filter(|(i, _)| whole[*i] != unlit[*i]) {
        assert!(*got == whole[pixel] || *got == unlit[pixel], "pixel {pixel}");
        near += usize::from(*got == whole[pixel]);
        far += usize::from(*got == unlit[pixel]);
    }
    assert!(near > 500 && far > 500, "{near} near, {far} far");
}

#[test]
fn scissors_and_depth_bounds_can_be_switched_off() {
    let cut = Cut {
        scissor: true,
        depth: true,
    };
    let settings = RenderSettings {
        scissor: false,
        depth_bounds: false,
        ..RenderSettings::default()
    };
    let [whole, _] = whole_and_unlit("stencil");
    assert!(cut_picture("stencil", cut, settings) == whole);
    assert!(cut_picture("stencil", cut, RenderSettings::default()) != whole);
}
