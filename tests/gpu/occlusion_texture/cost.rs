//! What occlusion textures cost: printed for people, never asserted.

use antumbra::prelude::*;
use antumbra::techniques::{OcclusionTexture, SliceFilter};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{Scene, boxes, lamp, square, staged};
use crate::harness::strict_context;

/// Median milliseconds of the passes whose label ends with each name, in frames that draw the pictures again.
fn cost(context: &RenderContext, scene: &Scene, kind: LightKind, settings: OcclusionTexture) -> [f64; 3] {
    let mut stage = staged(context, scene);
    let (light, place) = lamp(kind, Vec3::new(0.3, 3.0, 0.2));
    let entity = stage.spawn_light(light, place, Some(settings));
    let mut times = Vec::new();
    for frame in 0..6 {
        let mut place = stage.world.get_mut::<Transform>(entity).expect("a place");
        place.translation.x += 0.001 * frame as f32;
        let passes = stage.time_passes().expect("the frame renders");
        let sum = |name: &str| {
            let own = passes.iter().filter(|pass| pass.label.ends_with(name));
            own.map(|pass| pass.milliseconds).sum::<f64>()
        };
        times.push(["/slices", "/slice filter", "/slice lookup"].map(sum));
    }
    times.remove(0);
    [0, 1, 2].map(|pass| {
        let mut of_pass: Vec<f64> = times.iter().map(|times| times[pass]).collect();
        of_pass.sort_by(f64::total_cmp);
        of_pass[of_pass.len() / 2]
    })
}

fn print(name: &str, times: [f64; 3]) {
    println!("{name:<40} {:>9.2} {:>9.2} {:>9.2}", times[0], times[1], times[2]);
}

#[test]
#[ignore = "a table for people"]
fn costs_by_hand() {
    let context = strict_context();
    let settings = OcclusionTexture::default();
    println!(
        "{:<40} {:>9} {:>9} {:>9}",
        "milliseconds", "draw", "filter", "lookup"
    );
    for side in [0.1, 0.5, 2.0, 5.0] {
        let name = format!("light of {side} m");
        print(&name, cost(&context, &boxes(), square(side), settings));
    }
    for slices in [4, 8, 12, 16] {
        let settings = OcclusionTexture { slices, ..settings };
        print(
            &format!("{slices} slices"),
            cost(&context, &boxes(), square(1.0), settings),
        );
    }
    for resolution in [128, 256, 512, 1024] {
        for filter in [
            SliceFilter::NBuffers,
            SliceFilter::Mipmaps,
            SliceFilter::SummedAreas,
        ] {
            let settings = OcclusionTexture {
                slices: 4,
                resolution,
                filter,
                ..settings
            };
            let name = format!("4 slices, {resolution}², {filter:?}");
            print(&name, cost(&context, &boxes(), square(1.0), settings));
        }
    }
    for subdivisions in [2, 4, 6] {
        let mut scene = boxes();
        let ball = MeshData::icosphere(0.4, subdivisions);
        let name = format!("{} triangles more", ball.indices.len() / 3);
        scene.parts.push((ball, Transform::from_xyz(0.0, 1.0, 0.0)));
        print(&name, cost(&context, &scene, square(1.0), settings));
    }
}
