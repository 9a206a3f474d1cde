//! Occlusion changes what a frame costs and not what it shows: along a walk of 200 views through each scene the pictures
//! with it and without it are equal bit for bit, with at most 40 % of the batches that frustum and light volumes alone
//! leave.

mod harness;

use antumbra::prelude::*;
use glam::UVec2;
use harness::support::stats::Batches;
use harness::support::table::{Row, Walked, rows};
use harness::{models_folder, strict_context};

const FRAMES: usize = 200;
const SIZE: UVec2 = UVec2::new(64, 36);

/// Batches of one row over a walk, and the pictures.
fn walk(walked: &mut Walked, row: &Row) -> (Vec<Batches>, Vec<Vec<u8>>) {
    walked.set_row(row);
    (0..walked.views.len())
        .map(|frame| {
            let (batches, _) = walked.draw(frame).expect("the frame draws");
            (batches, walked.stage.radiance_bytes().expect("the picture is read"))
        })
        .unzip()
}

fn total(batches: &[Batches]) -> usize {
    batches.iter().map(Batches::total).sum()
}

fn compare(test: &str, file: &str) {
    let Some(folder) = models_folder(test) else {
        return;
    };
    let context = strict_context(RequestedFeatures::default());
    let mut walked = Walked::new(&folder.join(file), &context, SIZE, FRAMES).expect("the scene loads");
    let [frustum, .., last] = rows();
    let begin = std::time::Instant::now();
    let (batches_without, without) = walk(&mut walked, &frustum);
    let time_without = begin.elapsed();
    let begin = std::time::Instant::now();
    let (batches_with, with) = walk(&mut walked, &last);
    let time_with = begin.elapsed();
    let (before, after) = (total(&batches_without), total(&batches_with));
    println!(
        "{file}: {before} batches by frustum alone, {after} with occlusion: {:.1} % fewer; {:.1?} and {:.1?}",
        100.0 * (1.0 - after as f64 / before as f64),
        time_without,
        time_with,
    );
    let differing: Vec<usize> = (0..FRAMES).filter(|&frame| with[frame] != without[frame]).collect();
    assert!(differing.is_empty(), "{file}: frames {differing:?} differ");
    assert!(with.iter().any(|picture| picture != &with[0]), "the walk moves");
    assert!(after * 10 <= before * 4, "{after} of {before} batches are left");
}

#[test]
fn dungeon_pictures_are_equal_with_fewer_batches() {
    compare(
        "dungeon_pictures_are_equal_with_fewer_batches",
        "look/d-scenes/dungeon_A.glb",
    );
}

#[test]
fn interior_pictures_are_equal_with_fewer_batches() {
    compare(
        "interior_pictures_are_equal_with_fewer_batches",
        "copy/d-scenes/interior.glb",
    );
}

#[test]
#[ignore]
fn debug_rows() {
    let folder = models_folder("x").unwrap();
    let context = strict_context(RequestedFeatures::default());
    let file = std::env::var("SCENE").unwrap();
    let frames: Vec<usize> = std::env::var("FRAMES").unwrap().split(',').map(|s| s.parse().unwrap()).collect();
    let mut walked = Walked::new(&folder.join(file), &context, SIZE, FRAMES).expect("the scene loads");
    for frame in frames {
        let mut first: Option<Vec<u8>> = None;
        for row in rows() {
            walked.set_row(&row);
            let (batches, time) = walked.draw(frame).unwrap();
            let bytes = walked.stage.radiance_bytes().unwrap();
            let base = first.get_or_insert_with(|| bytes.clone());
            let pixels: Vec<usize> = base.chunks(8).zip(bytes.chunks(8)).enumerate().filter(|(_, (a, b))| a != b).map(|(i, _)| i).collect();
            println!("{frame} {}: {batches:?} = {} {time:.1?} {} pixels differ", row.name, batches.total(), pixels.len());
            for &p in pixels.iter().take(3) {
                let f = |b: &[u8]| -> Vec<f32> { b[p*8..p*8+8].chunks(2).map(|c| half::f16::from_le_bytes([c[0], c[1]]).to_f32()).collect() };
                println!("   {},{}: {:?} {:?}", p % 64, p / 64, f(base), f(&bytes));
            }
            let world = &walked.stage.world;
            println!("   V {} coverage {:?} drawn {}", world.resource::<antumbra::sets::VisibleSet>().set.count_ones(..), world.resource::<antumbra::sets::CameraOcclusion>().viewpoint.buffers().iter().map(|b| b.coverage()).collect::<Vec<_>>(), world.resource::<antumbra::sets::CameraOcclusion>().viewpoint.drawn.count_ones(..));
            for (i, l) in world.resource::<FrameLights>().lights.iter().enumerate() {
                if !l.is_skipped() {
                    let v = world.resource::<antumbra::sets::LightOcclusion>().viewpoint(i).unwrap();
                    println!("   light {i} {:?} reach {} l {} i {} s {} cov {:?} drawn {}", l.light.kind, l.reach.count_ones(..), l.l.count_ones(..), l.i.count_ones(..), l.s.count_ones(..), v.buffers().iter().map(|b| (b.coverage()*100.0) as i32).collect::<Vec<_>>(), v.drawn.count_ones(..));
                }
            }
        }
    }
}

#[test]
#[ignore]
fn debug_pixel() {
    use antumbra::reference::*;
    let folder = models_folder("x").unwrap();
    let context = strict_context(RequestedFeatures::default());
    let file = std::env::var("SCENE").unwrap();
    let frames: Vec<usize> = std::env::var("FRAMES").unwrap().split(',').map(|s| s.parse().unwrap()).collect();
    let mut walked = Walked::new(&folder.join(file), &context, SIZE, FRAMES).expect("the scene loads");
    let scene = RayScene::from_world(&mut walked.stage.world);
    for frame in frames {
        let [a, .., b] = rows();
        walked.set_row(&a);
        walked.draw(frame).unwrap();
        let base = walked.stage.radiance_bytes().unwrap();
        let ra = walked.stage.render().unwrap();
        walked.set_row(&b);
        walked.draw(frame).unwrap();
        let bytes = walked.stage.radiance_bytes().unwrap();
        let pixels: Vec<usize> = base.chunks(8).zip(bytes.chunks(8)).enumerate().filter(|(_, (a, b))| a != b).map(|(i, _)| i).collect();
        let world = &walked.stage.world;
        let camera = world.get::<Camera>(walked.stage.camera).unwrap();
        let hits = primary_hits(&scene, camera, world.get(walked.stage.camera).unwrap(), SIZE).unwrap();
        for p in pixels {
            for (i, &e) in walked.stage.lights.iter().enumerate() {
                let source = LightSource::of_entity(world, e).unwrap();
                let truth = hard_visibility(&scene, &hits, &source);
                let index = walked.stage.light_indices()[i].unwrap();
                let light = &world.resource::<FrameLights>().lights[index];
                println!("frame {frame} pixel {},{} light {i} at {:?} base {} truth {:?} skipped {}", p % 64, p / 64, light.world_from_light.translation(), ra.visibility[i][p], truth.values()[p], light.is_skipped());
            }
            println!("   hit {:?}", hits.hits[p]);
            let r = world.resource::<Renderer>();
            let d = antumbra::render::readback::read_texture(r.context(), &r.targets().unwrap().depth_stencil, wgpu::TextureAspect::DepthOnly, "d").unwrap();
            let v = f32::from_le_bytes(d.bytes[4*p..4*p+4].try_into().unwrap());
            println!("   depth {} -> {}", v, 0.1 / v);
            let around: Vec<f32> = [p - 1, p + 1, p - 64, p + 64].iter().map(|p| 0.1 / f32::from_le_bytes(d.bytes[4*p..4*p+4].try_into().unwrap())).collect();
            println!("   around {around:?}");
            let hit = hits.hits[p].unwrap();
            let objects = world.resource::<antumbra::sets::Objects>();
            for o in 0..objects.len() {
                let b = objects.boxes.get(o);
                if b.distance_sq(hit.position.as_vec3()) < 0.0001 {
                    println!("   object {o} {b:?} in L: {:?} reach {:?}", world.resource::<FrameLights>().lights.iter().map(|l| l.l.contains(o)).collect::<Vec<_>>(),world.resource::<FrameLights>().lights.iter().map(|l| l.reach.contains(o)).collect::<Vec<_>>());
                }
            }
            println!("   order {:?}", walked.stage.light_indices());
        }
    }
}
