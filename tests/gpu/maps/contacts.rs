//! No acne, no light through walls, and shadows that meet their casters within a texel: every kind of map, every filter,
//! without a setting for any scene.

use antumbra::prelude::*;
use antumbra::techniques::maps::{MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use bevy_ecs::prelude::*;

use super::scenes::{self, TestScene};
use crate::harness::maps::{Judge, MapError};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const RESOLUTION: MapResolution = MapResolution::Fixed(1024);

pub const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.5,
    outer_angle: 0.8,
};

/// All filters, with a softness that fits the kind of light and scene.
pub fn filters(kind: LightKind, scale: f32) -> [MapFilter; 6] {
    let softness = if kind == LightKind::Directional {
        0.02 * scale
    } else {
        0.008
    };
    let jittered = |adaptive| MapFilter::Jittered { softness, adaptive };
    [
        MapFilter::Bilinear,
        MapFilter::Brute4x4,
        MapFilter::Dithered4,
        jittered(false),
        jittered(true),
        MapFilter::Soft4 { softness },
    ]
}

/// The component of one kind of map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Spot,
    Sun,
    Omni(MapFormat),
}

impl Kind {
    pub const ALL: [Self; 6] = [
        Self::Spot,
        Self::Sun,
        Self::Omni(MapFormat::Depth),
        Self::Omni(MapFormat::R32Float),
        Self::Omni(MapFormat::Rgba8TwoBytes),
        Self::Omni(MapFormat::Rgba8FourBytes),
    ];

    /// All whose maps are not packed into bytes.
    pub const UNPACKED: [Self; 4] = [
        Self::Spot,
        Self::Sun,
        Self::Omni(MapFormat::Depth),
        Self::Omni(MapFormat::R32Float),
    ];

    pub fn light(self) -> LightKind {
        match self {
            Self::Spot => SPOT,
            Self::Sun => LightKind::Directional,
            Self::Omni(_) => LightKind::Point,
        }
    }

    pub fn insert(self, light: &mut EntityWorldMut, filter: MapFilter, surface: MapSurface) {
        let resolution = RESOLUTION;
        if let Self::Omni(format) = self {
            light.insert(OmniMap {
                resolution,
                filter,
                format,
                surface,
                ..Default::default()
            });
        } else {
            light.insert(ShadowMap {
                resolution,
                filter,
                surface,
                ..Default::default()
            });
        }
    }
}

/// How far off an edge a filter may be wrong, in texels: as far as it reaches and, for its shadow may part from the caster
/// by so much, one more; a single tap gets one in all.
fn reach_texels(filter: MapFilter, kind: Kind, judge: &Judge) -> f64 {
    let texel = judge
        .hits
        .hits
        .iter()
        .flatten()
        .map(|hit| {
            let place = judge.texel_metres(hit.position);
            let distance = judge.face_of(hit.position).map_or(1.0, |(_, _, z)| z);
            if kind == Kind::Sun {
                place
            } else {
                place / distance
            }
        })
        .filter(|texel| *texel > 0.0)
        .fold(f64::INFINITY, f64::min);
    match filter {
        MapFilter::Bilinear => 1.0,
        MapFilter::Brute4x4 | MapFilter::Dithered4 => 3.5,
        MapFilter::Jittered { softness, .. } | MapFilter::Soft4 { softness } => {
            f64::from(softness) / texel + 2.0
        }
    }
}

/// Judges a scene under one kind of map with each filter.
fn judge_scene(scene: &TestScene, stage: &mut Stage, kind: Kind, out: &mut Vec<(String, MapError)>) {
    let rays = scene.fill(stage);
    let (light, place) = scene.light(kind.light());
    let entity = stage.spawn_light(light, place, None::<StencilVolume>);
    let mut judge = None;
    // What is unpacked is looked up like depth: the first filters of the other formats stand for all.
    let count = match kind {
        Kind::Spot | Kind::Sun | Kind::Omni(MapFormat::Depth) => 6,
        Kind::Omni(MapFormat::R32Float) => 2,
        Kind::Omni(_) => 1,
    };
    for filter in filters(kind.light(), scene.scale).into_iter().take(count) {
        kind.insert(&mut stage.world.entity_mut(entity), filter, MapSurface::Nearest);
        let rendered = stage.render().expect("the frame renders");
        let judge = judge.get_or_insert_with(|| Judge::new(stage, &rays, 0).expect("something casts"));
        judge.band = reach_texels(filter, kind, judge);
        let name = format!("{} / {kind:?} / {filter:?}", scene.name);
        if std::env::var("ANTUMBRA_DUMP").is_ok_and(|dump| name.contains(&dump)) {
            dump(&name, &rendered.visibility[0], judge.truth.values());
        }
        out.push((name, judge.compare(&rendered.visibility[0])));
    }
}

/// Leaves the visibility beside the truth.
fn dump(name: &str, got: &[f32], truth: &[f32]) {
    let width = scenes::SIZE.x as usize;
    let mut bytes = Vec::new();
    for (got, truth) in got.chunks(width).zip(truth.chunks(width)) {
        bytes.extend(got.iter().map(|v| (v * 255.0) as u8));
        bytes.extend(
            truth
                .iter()
                .map(|v| if v.is_nan() { 90 } else { (v * 255.0) as u8 }),
        );
    }
    let name = name.replace(|c: char| !c.is_alphanumeric(), "_");
    let path = std::env::temp_dir().join(format!("map_{name}.png"));
    image::save_buffer(
        path,
        &bytes,
        2 * width as u32,
        scenes::SIZE.y,
        image::ColorType::L8,
    )
    .expect("the picture is written");
}

#[test]
fn no_acne_no_leak_and_contacts_within_a_texel() {
    let context = strict_context();
    let scenes = scenes::all();
    assert!(scenes.len() >= 20);
    // One world for all, so that every map is also one that took in another scene.
    let (mut stage, _) = scenes[0].stage(&context);
    let mut judged = Vec::new();
    for kind in Kind::ALL {
        let first = judged.len();
        for scene in &scenes {
            judge_scene(scene, &mut stage, kind, &mut judged);
        }
        let mut all = MapError::default();
        judged[first..].iter().for_each(|(_, error)| all.add(*error));
        println!("{kind:?}: {} pictures, {all:?}", judged.len() - first);
        assert!(all.dark > 10_000, "{kind:?}: too little is dark");
    }
    let bad: Vec<_> = judged
        .iter()
        .filter(|(_, error)| error.acne > 0 || error.wrong > 0)
        .map(|(name, error)| format!("{name}: {:.5} {error:?}", error.share()))
        .collect();
    assert!(
        bad.is_empty(),
        "{} of {}:\n{}",
        bad.len(),
        judged.len(),
        bad.join("\n")
    );
}

#[test]
fn the_judge_finds_acne_leaks_and_parted_shadows() {
    let context = strict_context();
    let scenes = scenes::all();
    let scene = &scenes[0]; // its shadow falls beside it
    let (mut stage, rays) = scene.stage(&context);
    let (light, place) = scene.light(SPOT);
    let entity = stage.spawn_light(light, place, None::<StencilVolume>);
    Kind::Spot.insert(
        &mut stage.world.entity_mut(entity),
        MapFilter::Bilinear,
        MapSurface::Nearest,
    );
    let rendered = stage.render().expect("the frame renders");
    let judge = Judge::new(&stage, &rays, 0).expect("something casts");
    let right = judge.compare(&rendered.visibility[0]);
    assert_eq!(right.wrong, 0);
    let all_dark = judge.compare(&vec![0.0; rendered.visibility[0].len()]);
    assert!(all_dark.acne > 1000 && all_dark.leaks == 0, "{all_dark:?}");
    let all_lit = judge.compare(&vec![1.0; rendered.visibility[0].len()]);
    assert!(all_lit.leaks > 50 && all_lit.acne == 0, "{all_lit:?}");
    // A bias of half a metre, or of a tenth of the distance, parts the shadow from a sheet, and the judge sees it.
    let wall = scenes.iter().find(|scene| scene.name == "sheet, light behind");
    let wall = wall.expect("there is one");
    let rays = wall.fill(&mut stage);
    let (light, place) = wall.light(SPOT);
    let mut leaks = [0; 3];
    for (leaks, (depth_metres, distance_share)) in leaks.iter_mut().zip([(0.0, 0.0), (0.5, 0.0), (0.0, 0.1)])
    {
        let bias = MapBias::Manual {
            normal_texels: 0.15,
            depth_metres,
            distance_share,
        };
        let map = ShadowMap {
            resolution: RESOLUTION,
            bias,
            ..Default::default()
        };
        let entity = stage.spawn_light(light.clone(), place, Some(map));
        let rendered = stage.render().expect("the frame renders");
        let judge = Judge::new(&stage, &rays, 0).expect("something casts");
        *leaks = judge.compare(&rendered.visibility[0]).leaks;
        stage.lights.clear();
        stage.world.despawn(entity);
    }
    assert!(leaks[0] == 0 && leaks[1] > 10 && leaks[2] > 10, "{leaks:?}");
}

#[test]
fn the_debug_view_changes_the_picture_and_no_shadow() {
    let context = strict_context();
    let scenes = scenes::all();
    for kind in [Kind::Spot, Kind::Sun, Kind::Omni(MapFormat::Depth)] {
        let (mut stage, _) = scenes[0].stage(&context);
        let (light, place) = scenes[0].light(kind.light());
        let entity = stage.spawn_light(light, place, None::<StencilVolume>);
        kind.insert(
            &mut stage.world.entity_mut(entity),
            MapFilter::Bilinear,
            MapSurface::Nearest,
        );
        let plain = stage.render().expect("the frame renders");
        stage.world.resource_mut::<Renderer>().settings.debug_volumes = true;
        let shown = stage.render().expect("the frame renders");
        assert_ne!(plain.picture, shown.picture, "{kind:?}");
        assert_eq!(plain.visibility, shown.visibility);
    }
}
