//! Maps against a ray-traced linear light.

use super::scenes::{TEXELS_PER_METRE, lit_ladder, maps, page_place, path, seen, settings, truth, truth_at};
use antumbra::reference::SurfaceHit;
use glam::DVec3;

/// Root of the mean squared error off the band of a texel, and how many pixels that are.
fn rmse(truth: &[Option<(f32, bool)>], drawn: &[f32]) -> (f32, usize) {
    let counted = truth.iter().zip(drawn).filter_map(|(truth, drawn)| {
        let (truth, varies) = (*truth)?;
        (!varies).then_some((truth - drawn).powi(2))
    });
    let (sum, count) = counted.fold((0.0, 0), |(sum, count), error| (sum + error, count + 1));
    ((sum / count.max(1) as f32).sqrt(), count)
}

#[test]
fn shadows_are_those_of_a_linear_light_at_all_times() {
    let mut stage = lit_ladder(maps(), 0.0, 0.0);
    let light = stage.lights[0];
    let (scene, hits) = seen(&mut stage);
    let (mut penumbra, mut worst_late) = (0, 0.0f32);
    for (time, width) in [(0.1, 0.06), (0.35, 0.5), (0.5, 0.03), (0.65, 0.6), (0.95, 0.1)] {
        stage.world.entity_mut(light).insert(settings(time, width));
        let rendered = stage.render().expect("the frame renders");
        let truth = truth(&scene, &hits, &path(), time, width);
        let (error, count) = rmse(&truth, &rendered.visibility[0]);
        let soft = |(truth, varies): &(f32, bool)| !varies && (0.05..0.95).contains(truth);
        penumbra += truth.iter().flatten().filter(|pixel| soft(pixel)).count();
        println!("{time} {width}: {error} over {count}");
        assert!(count > 600, "{count} pixels");
        assert!(error <= 0.02, "{time} {width}: {error}");
        let late = settings(time + if time > 0.5 { -0.1 } else { 0.1 }, width);
        stage.world.entity_mut(light).insert(late);
        let late = stage.render().expect("the frame renders");
        let (late, _) = rmse(&truth, &late.visibility[0]);
        println!("{time} {width}: {late} at another time");
        worst_late = worst_late.max(late);
    }
    assert!(worst_late > 0.1, "the judge notices a wrong time: {worst_late}");
    println!("{penumbra} pixels of penumbra");
    assert!(penumbra > 10, "{penumbra} pixels of penumbra");
}

/// Largest difference of neighbours.
fn steepest(values: &[f32]) -> f32 {
    values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .fold(0.0, f32::max)
}

#[test]
fn shadows_are_as_smooth_as_truth_and_not_blocky() {
    let maps = maps();
    let mut stage = lit_ladder(maps.clone(), 0.5, 0.3);
    stage.schedule.run(&mut stage.world);
    let (scene, hits) = seen(&mut stage);
    // A line over the ground behind the wall, on which its shadow ends. Eight points a texel.
    let ground = |hit: &&SurfaceHit| hit.position.y.abs() < 1e-6 && hit.normal.y > 0.9;
    let mut on_ground = hits.hits.iter().flatten().filter(ground);
    let any = *on_ground.next().expect("the ground is seen");
    let step = 1.0 / (8.0 * f64::from(TEXELS_PER_METRE));
    let (mut worst, mut worst_nearest) = (0.0f32, 0.0f32);
    for (time, width) in [(0.12, 0.16), (0.88, 0.2)] {
        let window = maps.window(time, width);
        let span = window.spans[0];
        let side = if time < 0.5 { 1.0 } else { -1.0 };
        let line: Vec<SurfaceHit> = (0..112)
            .map(|i| {
                let position = DVec3::new(side * (0.2 + step * f64::from(i)), 0.0, -1.3);
                let slot = scene.triangles().iter().position(|triangle| {
                    let [a, b, c] = triangle.corners;
                    let inside = |from: DVec3, to: DVec3| (to - from).cross(position - from).y >= 0.0;
                    triangle.corners.iter().all(|corner| corner.y == 0.0)
                        && (inside(a, b) && inside(b, c) && inside(c, a))
                });
                let triangle = slot.expect("the ground lies there") as u32;
                SurfaceHit {
                    position,
                    triangle,
                    normal: DVec3::Y,
                    ..any
                }
            })
            .collect();
        let truths: Vec<f32> = line
            .iter()
            .map(|hit| truth_at(&scene, hit, &path(), span, 256))
            .collect();
        let places: Vec<_> = line.iter().map(|hit| page_place(&stage, &scene, hit)).collect();
        let blended: Vec<f32> = places
            .iter()
            .map(|(page, texel)| maps.visibility(*page, *texel, &window))
            .collect();
        // What the chapter does: the texel that a point is in.
        let nearest: Vec<f32> = places
            .iter()
            .map(|(page, texel)| maps.visibility(*page, texel.floor() + 0.5, &window))
            .collect();
        let smooth = steepest(&truths).max(1.0 / 256.0);
        println!(
            "{time}: truth {smooth}, blended {}, nearest {}",
            steepest(&blended),
            steepest(&nearest)
        );
        assert!(
            truths.iter().any(|v| (0.1..0.9).contains(v)),
            "the line meets a penumbra: {truths:?}"
        );
        worst = worst.max(steepest(&blended) / smooth);
        worst_nearest = worst_nearest.max(steepest(&nearest) / smooth);
    }
    assert!(worst <= 1.5, "{worst} times truth's");
    assert!(worst_nearest > 1.5, "the measure sees blocks: {worst_nearest}");
}
