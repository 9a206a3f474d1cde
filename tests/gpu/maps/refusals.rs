//! Settings that no map can be drawn with are refused by name and leave the light unshadowed; odd ones that can be drawn
//! with are drawn with. Never a wgpu error, never a lost frame.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::techniques::TextureMemory;
use antumbra::techniques::maps::{MapBias, MapError, MapFilter, MapReport, MapResolution, MapSettings, Maps};
use antumbra::techniques::shadow_map::Cascades;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};

const SIZE: UVec2 = UVec2::new(64, 36);

fn stage(context: &RenderContext, with_casters: bool) -> Stage {
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let view = Transform::from_xyz(2.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    for (mesh, y, casts) in [
        (MeshData::plane(5.0), 0.0, false),
        (MeshData::cuboid(Vec3::splat(0.5)), 0.7, with_casters),
    ] {
        let mut entity = stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            ShadowReceiver,
            Transform::from_xyz(0.0, y, 0.0),
        ));
        if casts {
            entity.insert(ShadowCaster);
        }
    }
    stage
}

fn light(kind: LightKind, range: f32) -> Light {
    Light {
        kind,
        ..Light::point(Vec3::ONE, 20.0, range)
    }
}

const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.4,
    outer_angle: 0.7,
};

/// Renders one light; how many pixels are dark, and what was reported.
fn render(stage: &mut Stage, light: Light, shadow: impl Bundle) -> (usize, Vec<MapReport>) {
    let place = Transform::from_xyz(0.7, 4.0, 0.5).looking_at(Vec3::ZERO, Vec3::Z);
    let entity = stage.spawn_light(light, place, Some(shadow));
    let rendered = stage.render().expect("the frame renders");
    let reports = stage.world.resource::<Maps>().reports.clone();
    let newly = |stage: &mut Stage| stage.world.resource_mut::<Reports>().drain_new().count();
    assert!(newly(stage) >= reports.len(), "it is said");
    stage.schedule.run(&mut stage.world);
    assert_eq!(newly(stage), 0, "it is said once");
    stage.lights.clear();
    stage.world.despawn(entity);
    assert!(rendered.radiance.iter().all(|v| v.is_finite()));
    (
        rendered.visibility[0].iter().filter(|v| **v < 0.5).count(),
        reports,
    )
}

/// What was reported of the light that was there last.
fn said(stage: &Stage) -> Vec<String> {
    let reports = stage.world.resource::<Reports>().iter();
    reports.map(|report| report.message.clone()).collect()
}

#[test]
fn unusable_settings_are_refused_by_name() {
    let context = strict_context();
    let mut stage = stage(&context, true);
    let map = ShadowMap::default();
    let omni = OmniMap::default();
    let cascades = |change: fn(&mut Cascades)| {
        let mut cascades = Cascades::default();
        change(&mut cascades);
        (light(LightKind::Directional, 1.0), ShadowMap { cascades, ..map })
    };
    let soft = |softness| MapFilter::Soft4 { softness };
    let auto = |least, most| MapResolution::Auto { least, most };
    let bias = |normal_texels, depth_metres| MapBias::Manual {
        normal_texels,
        depth_metres,
        distance_share: 0.0,
    };
    let multiplied = |distance_share| MapBias::Manual {
        normal_texels: 0.0,
        depth_metres: 0.0,
        distance_share,
    };
    let spot = |map| (light(SPOT, 20.0), map);
    let refused = [
        (
            spot(ShadowMap {
                resolution: MapResolution::Fixed(0),
                ..map
            }),
            "resolution is 0",
        ),
        (
            spot(ShadowMap {
                resolution: auto(0, 64),
                ..map
            }),
            "resolution is 0",
        ),
        (
            spot(ShadowMap {
                resolution: auto(128, 64),
                ..map
            }),
            "resolution is 128",
        ),
        (
            spot(ShadowMap {
                near: Some(0.0),
                ..map
            }),
            "near is 0",
        ),
        (
            spot(ShadowMap {
                near: Some(1e-30),
                ..map
            }),
            "at least 1e-9 m",
        ),
        (
            spot(ShadowMap {
                near: Some(-1.0),
                ..map
            }),
            "near is -1",
        ),
        (
            spot(ShadowMap {
                near: Some(f32::NAN),
                ..map
            }),
            "near is NaN",
        ),
        (
            spot(ShadowMap {
                near: Some(20.0),
                ..map
            }),
            "near is 20 m",
        ),
        (
            spot(ShadowMap {
                filter: soft(f32::NAN),
                ..map
            }),
            "softness is NaN",
        ),
        (
            spot(ShadowMap {
                filter: soft(-0.1),
                ..map
            }),
            "softness is -0.1",
        ),
        (
            spot(ShadowMap {
                bias: bias(-1.0, 0.0),
                ..map
            }),
            "bias is -1",
        ),
        (
            spot(ShadowMap {
                bias: multiplied(1.0),
                ..map
            }),
            "bias is 1",
        ),
        (
            spot(ShadowMap {
                bias: bias(0.0, f32::INFINITY),
                ..map
            }),
            "bias is inf",
        ),
        (cascades(|c| c.count = 0), "number of cascades is 0"),
        (cascades(|c| c.count = 5), "number of cascades is 5"),
        (cascades(|c| c.distance = 0.0), "distance of the cascades is 0"),
        (
            cascades(|c| c.log_share = 1.5),
            "log share of the cascades is 1.5",
        ),
        (cascades(|c| c.blend = f32::NAN), "blend of the cascades is NaN"),
        ((light(LightKind::Point, 20.0), map), "does not fit a point light"),
    ];
    for ((light, map), text) in refused {
        let (dark, reports) = render(&mut stage, light, map);
        assert_eq!((dark, reports.len()), (0, 0), "{text}");
        let said = said(&stage);
        assert!(said.len() == 1 && said[0].contains(text), "{text}: {said:?}");
    }
    let (dark, _) = render(&mut stage, light(LightKind::Directional, 1.0), omni);
    assert_eq!(dark, 0);
    let said = said(&stage);
    assert!(
        said.len() == 1 && said[0].contains("does not fit a directional light"),
        "{said:?}"
    );
    // Lights whose own numbers are wrong are skipped as a whole, and said by the sets.
    let wide = LightKind::Spot {
        inner_angle: 0.4,
        outer_angle: 1.6,
    };
    for bad in [
        light(LightKind::Point, 0.0),
        light(LightKind::Point, f32::NAN),
        light(wide, 20.0),
    ] {
        let place = Transform::from_xyz(0.7, 4.0, 0.5).looking_at(Vec3::ZERO, Vec3::Z);
        let entity = stage.spawn_light(bad, place, Some(omni));
        stage.render().expect("the frame renders");
        assert_eq!(stage.world.resource::<FrameLights>().skipped.len(), 1);
        stage.lights.clear();
        stage.world.despawn(entity);
    }
}

#[test]
fn odd_settings_are_drawn_with() {
    let context = own_context(RequestedFeatures::BASELINE);
    let mut stage = stage(&context, true);
    let fixed = |resolution| MapResolution::Fixed(resolution);
    let wide = |outer_angle| LightKind::Spot {
        inner_angle: 0.2,
        outer_angle,
    };
    let map = ShadowMap {
        resolution: fixed(256),
        ..Default::default()
    };
    let omni = OmniMap {
        resolution: fixed(256),
        ..Default::default()
    };
    let spots = [
        (light(SPOT, 20.0), map),
        (light(SPOT, f32::INFINITY), map),
        (light(wide(1.5), 20.0), map),
        (light(wide(std::f32::consts::FRAC_PI_2), f32::INFINITY), map),
        (
            light(SPOT, 20.0),
            ShadowMap {
                resolution: fixed(300),
                ..map
            },
        ),
        (
            light(SPOT, 20.0),
            ShadowMap {
                near: Some(1.0),
                ..map
            },
        ),
        (
            light(LightKind::Directional, 1.0),
            ShadowMap {
                resolution: fixed(77),
                ..map
            },
        ),
    ];
    for (light, map) in spots {
        let (dark, reports) = render(&mut stage, light.clone(), map);
        assert!(dark > 5 && reports.is_empty(), "{dark} {light:?} {map:?}");
    }
    let points = [
        (light(LightKind::Point, 20.0), omni),
        (light(LightKind::Point, f32::INFINITY), omni),
        (light(LightKind::Sphere { radius: 0.1 }, 20.0), omni),
        (
            light(
                LightKind::Rect {
                    width: 0.3,
                    height: 0.2,
                },
                20.0,
            ),
            omni,
        ),
        (light(SPOT, 20.0), omni),
        (
            light(LightKind::Point, 20.0),
            OmniMap {
                resolution: fixed(99),
                ..omni
            },
        ),
    ];
    for (light, map) in points {
        let (dark, reports) = render(&mut stage, light.clone(), map);
        assert!(dark > 20 && reports.is_empty(), "{dark} {light:?} {map:?}");
    }
    for texels in [1, 2, 3, 5] {
        let resolution = fixed(texels);
        let (_, reports) = render(
            &mut stage,
            light(LightKind::Point, 20.0),
            OmniMap { resolution, ..omni },
        );
        assert!(reports.is_empty());
        render(&mut stage, light(SPOT, 20.0), ShadowMap { resolution, ..map });
        render(
            &mut stage,
            light(LightKind::Directional, 1.0),
            ShadowMap { resolution, ..map },
        );
    }
    // A caster nearer than the near plane casts nothing, and that is what was asked for.
    let (all, _) = render(&mut stage, light(SPOT, 20.0), map);
    let (own, _) = render(
        &mut stage,
        light(SPOT, 20.0),
        ShadowMap {
            near: Some(4.2),
            ..map
        },
    );
    assert!(
        own + 10 < all,
        "{own} of {all}: what faces away is dark all the same"
    );
}

#[test]
fn maps_beyond_the_limit_are_as_large_as_it_allows_and_reported() {
    let context = strict_context();
    let mut stage = stage(&context, true);
    stage.world.resource_mut::<MapSettings>().largest = 128;
    let resolution = MapResolution::Fixed(100_000);
    let omni = OmniMap {
        resolution,
        ..Default::default()
    };
    let (dark, reports) = render(&mut stage, light(LightKind::Point, 20.0), omni);
    assert!(dark > 20);
    assert_eq!(
        reports[0].error,
        MapError::Largest {
            wanted: 100_000,
            limit: 128
        }
    );
    stage.world.resource_mut::<MapSettings>().largest = u32::MAX;
    stage.world.resource_mut::<TextureMemory>().limit = 16 << 20;
    let (dark, reports) = render(&mut stage, light(LightKind::Point, 20.0), omni);
    assert!(dark > 20, "{dark}");
    let limit = context.device.limits().max_texture_dimension_2d;
    assert_eq!(stage.world.resource::<MapSettings>().largest, limit);
    assert_eq!(reports.len(), 1, "beyond the device: {reports:?}");
    let short = stage.world.resource::<TextureMemory>().shortages();
    assert_eq!(short.len(), 1, "beyond the memory");
    assert_eq!((short[0].entity, short[0].asker), (reports[0].entity, "omni_map"));
}

#[test]
fn without_casters_nothing_is_looked_up() {
    let context = strict_context();
    let mut stage = stage(&context, false);
    for cached in [true, false] {
        let map = ShadowMap {
            cached,
            ..Default::default()
        };
        let (dark, reports) = render(&mut stage, light(SPOT, 20.0), map);
        assert_eq!((dark, reports.len()), (0, 0));
        assert!(stage.world.resource::<Maps>().of_light(0).is_none());
    }
}
