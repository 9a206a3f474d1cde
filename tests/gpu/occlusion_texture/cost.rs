//! Costs of occlusion textures. Counts are asserted; times are printed by tests for people.

use antumbra::prelude::*;
use antumbra::techniques::{
    OcclusionTexture, OcclusionTextures, SliceCombination, SliceFilter, TextureMemory,
};
use bevy_ecs::prelude::Entity;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::scenes::{Scene, boxes, lamp, plate, rendered, rmse, square, staged, truth};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

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
    [0, 1, 2].map(|pass| median(times.iter().map(|times| times[pass]).collect()))
}

/// Median of some numbers.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn print(name: &str, times: [f64; 3]) {
    println!("{name:<40} {:>9.2} {:>9.2} {:>9.2}", times[0], times[1], times[2]);
}

/// A lookup takes as many samples, and the casters as many draws and bytes, for a light of 0.1 m as for one of 5 m.
#[test]
fn costs_do_not_grow_with_the_light() {
    let context = strict_context();
    let counts = [0.1, 1.0, 5.0].map(|side| {
        let mut stage = staged(&context, &boxes());
        let (light, place) = lamp(square(side), Vec3::new(0.3, 3.0, 0.2));
        stage.spawn_light(light, place, Some(OcclusionTexture::default()));
        rendered(&mut stage);
        let renderer = stage.world.resource::<Renderer>();
        let draws = renderer.shadow_batch_count(&renderer.frame().lights[0]);
        let slices = &stage.world.resource::<OcclusionTextures>().lights[0];
        let bytes = slices.bytes_per_square() * u64::from(slices.resolution).pow(2);
        let counts = (slices.taps(), slices.faces.len(), draws, bytes);
        println!("{side} m: {counts:?}, {} levels", slices.levels());
        (counts, slices.levels())
    });
    assert_eq!(counts[0].0, counts[1].0);
    assert_eq!(counts[1].0, counts[2].0);
    assert_eq!(counts[0].0.0, 1);
    // Two groups of unions, with dense levels of 4 bytes, and of coverage and depths, with levels of 8; and a third of a level of 8
    // for the sparse levels of each, rounded up.
    assert_eq!(counts[0].0.3, 2 * ((4 * 4 + 3) + 2 * (4 * 8 + 3)) * 256 * 256);
    // Small lights even leave out levels of the filter.
    assert!(counts[0].1 < counts[1].1 && counts[2].1 <= 9, "{counts:?}");
}

/// Half a million triangles: seven balls over a ground.
#[test]
#[ignore = "a table for people"]
fn half_a_million_triangles_by_hand() {
    let context = strict_context();
    let mut scene = plate();
    scene.parts.truncate(1);
    let ball = MeshData::icosphere(0.3, 6);
    let triangles = 7 * ball.indices.len() / 3;
    for index in 0..7 {
        let turn = Quat::from_rotation_y(0.9 * index as f32);
        let at = turn * Vec3::new(0.7, 0.6 + 0.15 * index as f32, 0.0);
        scene.parts.push((ball.clone(), Transform::from_translation(at)));
    }
    let settings = OcclusionTexture::default();
    let times = cost(&context, &scene, square(1.0), settings);
    let mut stage = staged(&context, &scene);
    let (light, place) = lamp(square(1.0), Vec3::new(0.3, 3.0, 0.2));
    stage.spawn_light(light, place, Some(settings));
    let got = rendered(&mut stage);
    let truth = truth(&mut stage, 64);
    let (error, lit) = (rmse(&truth, &got), rmse(&truth, &vec![1.0; got.len()]));
    print(&format!("{triangles} triangles"), times);
    println!("error {error:.3}, without a shadow {lit:.3}");
    assert!(
        triangles > 500_000 && error < 0.4 * lit,
        "{triangles}, {error}, {lit}"
    );
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
        for combine in [SliceCombination::Product, SliceCombination::Overlap] {
            let settings = OcclusionTexture {
                slices,
                combine,
                ..settings
            };
            let name = format!("{slices} slices, {combine:?}");
            print(&name, cost(&context, &boxes(), square(1.0), settings));
        }
    }
    for resolution in [128, 256, 512, 1024] {
        let mut filters = Vec::new();
        for filter in [
            SliceFilter::NBuffers,
            SliceFilter::Mipmaps,
            SliceFilter::SummedAreas,
        ] {
            let settings = OcclusionTexture {
                slices: 4,
                resolution,
                filter,
                // One set of pictures, so that 1024² texels fit into the memory of textures.
                combine: SliceCombination::Product,
                ..settings
            };
            let name = format!("4 slices, {resolution}², product, {filter:?}");
            let times = cost(&context, &boxes(), square(1.0), settings);
            print(&name, times);
            filters.push(times[1]);
        }
        println!(
            "  the filter of summed areas takes {:.2} times that of N-buffers",
            filters[2] / filters[0]
        );
    }
    for subdivisions in [2, 4, 6] {
        let mut scene = boxes();
        let ball = MeshData::icosphere(0.4, subdivisions);
        let name = format!("{} triangles more", ball.indices.len() / 3);
        scene.parts.push((ball, Transform::from_xyz(0.0, 1.0, 0.0)));
        print(&name, cost(&context, &scene, square(1.0), settings));
    }
}

/// A light whose pictures are drawn and filtered in every frame.
struct Moving {
    stage: Stage,
    light: Entity,
}

impl Moving {
    /// Puts a light over the boxes, with as much memory as it asks for.
    fn new(context: &RenderContext, kind: LightKind, settings: OcclusionTexture) -> Self {
        let mut stage = staged(context, &boxes());
        stage.world.resource_mut::<TextureMemory>().limit = 1 << 30;
        let (light, place) = lamp(kind, Vec3::new(0.3, 3.0, 0.2));
        let light = stage.spawn_light(light, place, Some(settings));
        Self { stage, light }
    }

    /// Milliseconds in which the filter of the next frame's pictures is built.
    fn building(&mut self) -> f64 {
        let mut place = self
            .stage
            .world
            .get_mut::<Transform>(self.light)
            .expect("a place");
        place.translation.x += 0.001;
        let passes = self.stage.time_passes().expect("the frame renders");
        let slices = &self.stage.world.resource::<OcclusionTextures>().lights[0];
        assert_eq!(slices.resolution, slices.settings.resolution, "no memory");
        let own = passes.iter().filter(|pass| pass.label.ends_with("/slice filter"));
        own.map(|pass| pass.milliseconds).sum()
    }
}

/// Times in which N-buffers and summed areas are built, and their ratio. They take turns, so that other work on the machine
/// slows both.
#[test]
#[ignore = "a table for people"]
fn building_summed_areas_over_n_buffers_by_hand() {
    let context = strict_context();
    println!("8 slices of 1024², milliseconds of the filter alone");
    for combine in [SliceCombination::Product, SliceCombination::Overlap] {
        let [mut buffers, mut sums] = [SliceFilter::NBuffers, SliceFilter::SummedAreas].map(|filter| {
            let settings = OcclusionTexture {
                resolution: 1024,
                filter,
                combine,
                ..Default::default()
            };
            Moving::new(&context, square(1.0), settings)
        });
        // The first frames make textures and pipelines.
        let first = [buffers.building(), sums.building()];
        let times: Vec<[f64; 2]> = (0..7).map(|_| [buffers.building(), sums.building()]).collect();
        let of = |index: usize| median(times.iter().map(|times| times[index]).collect());
        let ratio = median(times.iter().map(|[buffers, sums]| sums / buffers).collect());
        let levels = buffers.stage.world.resource::<OcclusionTextures>().lights[0].levels();
        println!(
            "{combine:?}: {levels} levels of N-buffers {:.1}, summed areas {:.1}, ratio {ratio:.2}; first {first:.1?}",
            of(0),
            of(1)
        );
    }
}
