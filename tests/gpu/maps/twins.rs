//! Each filter, format and surface of an omnidirectional map gives the picture of its own twin on the CPU, pixel for pixel,
//! and not that of another one: a setting that is ignored fails.

use std::sync::Arc;

use antumbra::insides::map_constants;
use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::render::readback::read_texture;
use antumbra::sets::View;
use antumbra::techniques::maps::{MapFilter, MapFormat, MapResolution, MapSettings, MapSurface, Maps};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use crate::harness::map_twin::{Belief, Twin};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(112, 63);

/// The belief that all tests vary.
const PLAIN: Belief = Belief {
    filter: MapFilter::Bilinear,
    format: MapFormat::Depth,
    surface: MapSurface::Nearest,
    turns: true,
};

/// A floor, seen from the side of a light's shadows.
struct Scene {
    stage: Stage,
    range: f32,
    resolution: u32,
}

impl Scene {
    fn new(range: f32, resolution: u32) -> Self {
        let camera = Camera {
            vertical_fov: 0.7,
            aspect: SIZE.x as f32 / SIZE.y as f32,
            ..Camera::default()
        };
        let view = Transform::from_xyz(4.2, 3.4, 2.6).looking_at(Vec3::new(0.8, 0.5, 0.0), Vec3::Y);
        let mut stage = Stage::empty(SIZE, camera, view);
        stage.world.insert_resource(FaceCulling::None);
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        let mut scene = Self {
            stage,
            range,
            resolution,
        };
        scene.caster(MeshData::plane(6.0), Transform::default());
        scene
    }

    fn receiver(&mut self, mesh: MeshData, at: Transform) -> Entity {
        let parts = (
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            ShadowReceiver,
            at,
        );
        self.stage.world.spawn(parts).id()
    }

    fn caster(&mut self, mesh: MeshData, at: Transform) {
        let entity = self.receiver(mesh, at);
        self.stage.world.entity_mut(entity).insert(ShadowCaster);
    }

    /// Draws one map, and gives the visibility and the taps of each pixel.
    fn draw(&mut self, belief: &Belief) -> (Vec<f32>, Vec<u32>) {
        let stage = &mut self.stage;
        for light in stage.lights.drain(..) {
            stage.world.despawn(light);
        }
        stage.world.resource_mut::<MapSettings>().show_taps = true;
        let light = Light::point(Vec3::ONE, 20.0, self.range);
        let map = OmniMap {
            resolution: MapResolution::Fixed(self.resolution),
            filter: belief.filter,
            format: belief.format,
            surface: belief.surface,
            ..Default::default()
        };
        stage.spawn_light(light, Transform::from_xyz(-2.0, 4.0, 0.3), Some(map));
        let visibility = stage.render().expect("the frame renders").visibility.remove(0);
        let renderer = stage.world.resource::<Renderer>();
        let mask = &renderer.mask_targets().expect("a map was looked up").mask;
        let rows =
            read_texture(renderer.context(), mask, wgpu::TextureAspect::All, "mask").expect("it can be read");
        let red = |texel: &[u8]| half::f16::from_le_bytes([texel[0], texel[1]]).to_f32();
        let taps = rows
            .bytes
            .chunks_exact(8)
            .map(|texel| (red(texel) * 64.0).round() as u32);
        (visibility, taps.collect())
    }

    /// What the twin sees of the frame that was drawn last.
    fn expect(&mut self, belief: &Belief) -> Vec<Option<(f64, u32)>> {
        let rays = RayScene::from_world(&mut self.stage.world);
        let world = &self.stage.world;
        let map = world.resource::<Maps>().of_light(0).expect("it has a map");
        let eye = world
            .resource::<View>()
            .data
            .as_ref()
            .expect("there is a view")
            .eye;
        // The constants are those of the filter and format in which the twin believes.
        let mut believed = map.clone();
        believed.request.filter = belief.filter;
        believed.request.format = belief.format;
        let twin = Twin::new(&rays, map, map_constants(&believed, eye, (1.0, 0.0)), eye);
        let camera = world.get::<Camera>(self.stage.camera).expect("there is a camera");
        let place = world.get(self.stage.camera).expect("it stands somewhere");
        let hits =
            antumbra::reference::primary_hits(&rays, camera, place, SIZE).expect("the camera is usable");
        let pixel = |index: usize| UVec2::new(index as u32 % SIZE.x, index as u32 / SIZE.x);
        let all = hits.hits.iter().enumerate();
        all.map(|(index, hit)| hit.as_ref().map(|hit| twin.visibility(hit, pixel(index), belief)))
            .collect()
    }
}

/// Shares of the pixels in which a picture differs from a twin by more than a tolerance: of those where either is neither
/// dark nor lit, or where they differ; and in the number of taps, of all.
fn apart(picture: &(Vec<f32>, Vec<u32>), twin: &[Option<(f64, u32)>], tolerance: f64) -> [f64; 2] {
    let (mut partial, mut wrong, mut taps, mut all) = (0, 0, 0, 0);
    for ((got, got_taps), twin) in picture.0.iter().zip(&picture.1).zip(twin) {
        let Some((expected, expected_taps)) = twin else {
            continue;
        };
        let got = f64::from(*got);
        let differs = (got - expected).abs() > tolerance;
        let is_partial = |v: f64| (0.01..0.99).contains(&v);
        partial += usize::from(differs || is_partial(got) || is_partial(*expected));
        wrong += usize::from(differs);
        taps += usize::from(got_taps != expected_taps);
        all += 1;
    }
    assert!(partial > 60, "{partial} pixels tell something");
    [wrong as f64 / partial as f64, taps as f64 / all as f64]
}

/// Whether depths are kept in the steps of a float, or in finer ones.
fn is_exact(belief: &Belief) -> bool {
    matches!(belief.format, MapFormat::R32Float | MapFormat::Rgba8FourBytes)
}

/// Draws with each setting. Its own twin must agree, and every other twin must not, in visibility or in taps, but for formats
/// that are equally exact.
fn each_is_itself(scene: &mut Scene, settings: &[Belief]) {
    for (index, belief) in settings.iter().enumerate() {
        let picture = scene.draw(belief);
        for (other_index, other) in settings.iter().enumerate() {
            let [wrong, taps] = apart(&picture, &scene.expect(other), 0.05);
            println!("{belief:?}\n  as {other:?}: {wrong:.4} differ, taps {taps:.4}");
            if index == other_index {
                assert!(wrong <= 0.03 && taps <= 0.02, "{belief:?}: {wrong} {taps}");
            } else if !(is_exact(belief) && is_exact(other)) {
                assert!(
                    wrong >= 0.1 || taps >= 0.1,
                    "{belief:?} passes as {other:?}: {wrong} {taps}"
                );
            }
        }
    }
}

#[test]
fn each_filter_is_its_own_twin() {
    let mut scene = Scene::new(20.0, 48);
    scene.caster(MeshData::plane(0.5), Transform::from_xyz(-0.3, 1.5, 0.1));
    // Its right side faces away from the light, which saves all taps.
    let block = MeshData::cuboid(Vec3::splat(0.3));
    scene.caster(block, Transform::from_xyz(0.3, 1.0, -1.3));
    let softness = 0.08;
    let filters = [
        MapFilter::Bilinear,
        MapFilter::Brute4x4,
        MapFilter::Dithered4,
        MapFilter::Soft4 { softness },
        MapFilter::Jittered {
            softness,
            adaptive: false,
        },
        MapFilter::Jittered {
            softness,
            adaptive: true,
        },
    ];
    let settings = filters.map(|filter| Belief { filter, ..PLAIN });
    each_is_itself(&mut scene, &settings);
    let jittered = settings[4];
    let picture = scene.draw(&jittered);
    let still = Belief {
        turns: false,
        ..jittered
    };
    let twin = scene.expect(&jittered);
    let [own, still] = [&twin, &scene.expect(&still)].map(|twin| apart(&picture, twin, 0.01)[0]);
    assert!(
        own <= 0.03 && still >= 0.1,
        "the disc of each pixel is its own: {own} {still}"
    );
    let faces_away = |pixel: &Option<(f64, u32)>| pixel.is_some_and(|(_, taps)| taps == 0);
    let away: Vec<u32> = twin
        .iter()
        .zip(&picture.1)
        .filter(|(pixel, _)| faces_away(pixel))
        .map(|(_, taps)| *taps)
        .collect();
    let looked_up = away.iter().filter(|taps| **taps > 0).count();
    assert!(
        away.len() > 20 && looked_up * 10 <= away.len(),
        "{looked_up} of {} pixels that face away are looked up",
        away.len()
    );
}

#[test]
fn each_surface_is_its_own_twin() {
    let mut scene = Scene::new(20.0, 96);
    // Rays pass through both sheets. Between them are plates that do not cast, before and beyond the middle.
    scene.caster(MeshData::plane(0.4), Transform::from_xyz(0.0, 2.0, 0.0));
    scene.caster(MeshData::plane(0.7), Transform::from_xyz(1.5, 0.5, 0.0));
    scene.receiver(MeshData::plane(0.35), Transform::from_xyz(0.65, 1.6, 0.0));
    scene.receiver(MeshData::plane(0.35), Transform::from_xyz(1.35, 0.9, 0.0));
    let surfaces = [MapSurface::Nearest, MapSurface::Second, MapSurface::Midpoint];
    let settings = surfaces.map(|surface| Belief { surface, ..PLAIN });
    each_is_itself(&mut scene, &settings);
}

/// A floor under a sheet that hangs 0.1 to 0.7 metres above it.
fn tilted_sheet(range: f32, resolution: u32) -> Scene {
    let mut scene = Scene::new(range, resolution);
    let at = Transform::from_xyz(0.2, 0.4, 0.0).with_rotation(Quat::from_rotation_x(0.3));
    scene.caster(MeshData::plane(1.0), at);
    scene
}

/// A ramp that does not cast, under a sheet that hangs 0.08 metres above it. Along the axis of the map's face, a texel of the
/// ramp is deeper than that.
fn ramp(range: f32, resolution: u32) -> Scene {
    let mut scene = Scene::new(range, resolution);
    let turn = Quat::from_rotation_x(0.7);
    let ramp = Transform::from_xyz(0.2, 1.0, 0.0).with_rotation(turn);
    scene.receiver(MeshData::plane(1.2), ramp);
    let above = Transform::from_translation(ramp.translation + turn * Vec3::Y * 0.08);
    scene.caster(MeshData::plane(0.6), above.with_rotation(turn));
    scene
}

#[test]
fn each_format_is_its_own_twin() {
    let of = |formats: &[MapFormat]| -> Vec<Belief> {
        formats.iter().map(|&format| Belief { format, ..PLAIN }).collect()
    };
    // Hardware compares four texels with one depth, other formats each with its own.
    let (depth, float) = (MapFormat::Depth, MapFormat::R32Float);
    each_is_itself(&mut ramp(20.0, 32), &of(&[depth, float]));
    // Steps of two bytes are 0.3 metres here; four bytes have the same steps where the range is larger.
    let (two, four) = (MapFormat::Rgba8TwoBytes, MapFormat::Rgba8FourBytes);
    // A map holds distances up to that of its farthest caster, which is far away.
    let with_far_caster = |range: f32| {
        let mut scene = tilted_sheet(range, 64);
        let far = Transform::from_xyz(0.5 * range, 4.0, 0.3);
        scene.caster(MeshData::cuboid(Vec3::splat(0.1)), far);
        scene
    };
    each_is_itself(&mut with_far_caster(400.0), &of(&[two, four]));
    each_is_itself(&mut with_far_caster(5000.0), &of(&[four, float]));
}
