//! Silhouettes that pass the light's plane, thousands of smoothies over one pixel, widths that cannot be drawn, empty
//! scenes: no error of the device, no value that is not a visibility.

use antumbra::prelude::*;
use antumbra::techniques::{SmoothieWidth, Techniques};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::scenes::{SPOT, empty, ground, lamp, rendered, smoothie, spawn};
use crate::harness::strict_context;

fn assert_shares(values: &[f32], name: &str) {
    let wrong = values
        .iter()
        .filter(|value| !(0.0..=1.0).contains(*value))
        .count();
    assert_eq!(wrong, 0, "{name}");
}

#[test]
fn silhouettes_that_pass_the_light_are_clipped() {
    let context = strict_context();
    for kind in [SPOT, LightKind::Point] {
        let picture = |caster: Option<(MeshData, Transform)>| {
            let mut stage = ground(&context, Vec3::new(2.0, 4.0, 4.0), Vec3::ZERO);
            if let Some((mesh, place)) = caster {
                spawn(&mut stage, mesh, place);
            }
            let (light, place) = lamp(kind, Vec3::new(0.0, 2.0, 0.0));
            stage.spawn_light(light, place, Some(smoothie(SmoothieWidth::Metres(0.1))));
            rendered(&mut stage)
        };
        let all_lit = picture(None);
        assert!(all_lit.iter().all(|value| *value > 0.99), "{kind:?}");
        // A wall beside the light, from the ground to far above it, and slanted beams past it.
        let wall = (
            MeshData::cuboid(Vec3::new(0.01, 4.0, 1.0)),
            Transform::from_xyz(0.6, 2.0, 0.0),
        );
        let beam = Transform::from_xyz(0.3, 2.2, 0.0).with_rotation(Quat::from_rotation_z(0.7));
        let around = (
            MeshData::cuboid(Vec3::splat(0.3)),
            Transform::from_xyz(0.0, 2.0, 0.0),
        );
        let cases = [
            ("wall", wall, 100),
            ("beam", (MeshData::cuboid(Vec3::new(0.03, 3.0, 0.03)), beam), 10),
            // The light is inside: everything is dark.
            ("around", around, 1000),
        ];
        for (name, caster, least) in cases {
            let values = picture(Some(caster));
            assert_shares(&values, name);
            let dark = values.iter().filter(|value| **value < 0.5).count();
            assert!(dark > least, "{kind:?} {name}: {dark} dark");
        }
    }
}

/// One mesh of many slivers, whose smoothies all lie over the same place.
#[test]
fn ten_thousand_smoothies_over_one_pixel_keep_the_least() {
    let context = strict_context();
    let picture = |count: u32| {
        let mut stage = ground(&context, Vec3::new(0.0, 4.0, 3.0), Vec3::ZERO);
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for index in 0..count {
            // Slivers fan out from one point; each is an open triangle with three smoothies.
            let angle = index as f32 / count as f32 * std::f32::consts::FRAC_PI_2;
            let along = |angle: f32| Vec3::new(angle.cos(), 0.0, angle.sin()) * 0.5;
            positions.extend([Vec3::ZERO, along(angle), along(angle + 0.3 / count as f32)]);
            indices.extend([3 * index, 3 * index + 2, 3 * index + 1]);
        }
        let fan = MeshData::from_triangles("fan", positions, indices);
        spawn(&mut stage, fan, Transform::from_xyz(0.0, 1.2, 0.0));
        let (light, place) = lamp(SPOT, Vec3::new(0.1, 4.5, 0.1));
        stage.spawn_light(light, place, Some(smoothie(SmoothieWidth::Metres(0.4))));
        rendered(&mut stage)
    };
    let (few, many) = (picture(60), picture(3400));
    assert_shares(&many, "many");
    let least = |values: &[f32]| values.iter().copied().fold(1.0, f32::min);
    println!(
        "least visibility {} of few, {} of many",
        least(&few),
        least(&many)
    );
    let differs = few
        .iter()
        .zip(&many)
        .filter(|(a, b)| (*a - *b).abs() > 0.1)
        .count();
    let soft = many.iter().filter(|value| (0.05..0.95).contains(*value)).count();
    assert!(
        soft > 60 && differs < many.len() / 50,
        "{soft} soft, {differs} differ"
    );
}

#[test]
fn scenes_without_casters_or_receivers_are_lit() {
    let context = strict_context();
    for kind in [SPOT, LightKind::Directional, LightKind::Point] {
        let view = Transform::from_xyz(0.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
        let mut nothing = empty(&context, view);
        let (light, place) = lamp(kind, Vec3::new(0.0, 4.0, 0.0));
        nothing.spawn_light(light, place, Some(Smoothie::default()));
        assert!(
            rendered(&mut nothing).iter().all(|value| *value == 1.0),
            "{kind:?}"
        );

        let mut lonely = ground(&context, Vec3::new(0.0, 2.0, 3.0), Vec3::ZERO);
        let (light, place) = lamp(kind, Vec3::new(0.0, 4.0, 0.0));
        lonely.spawn_light(light, place, Some(Smoothie::default()));
        assert!(
            rendered(&mut lonely).iter().all(|value| *value > 0.99),
            "{kind:?}"
        );
        // Casters that no surface receives from.
        let receivers: Vec<_> = lonely
            .world
            .query_filtered::<bevy_ecs::prelude::Entity, bevy_ecs::prelude::With<ShadowReceiver>>()
            .iter(&lonely.world)
            .collect();
        for receiver in receivers {
            lonely.world.entity_mut(receiver).remove::<ShadowReceiver>();
        }
        assert_shares(&rendered(&mut lonely), "no receivers");
    }
}

#[test]
fn settings_that_cannot_be_drawn_are_refused() {
    let techniques = Techniques::default();
    let row = techniques
        .rows()
        .iter()
        .find(|row| row.name() == "smoothie")
        .expect("it is listed");
    assert_eq!(row.name(), "smoothie");
    let light = |kind| Light {
        kind,
        ..Light::point(Vec3::ONE, 1.0, 10.0)
    };
    let sun = light(LightKind::Directional);
    let refused = |settings: Smoothie, light: &Light| {
        let refusal = settings.request_error(light);
        refusal.unwrap_or_default()
    };
    for width in [f32::NAN, f32::INFINITY, -0.1] {
        for of in [SmoothieWidth::Metres(width), SmoothieWidth::Share(width)] {
            let said = refused(smoothie(of), &light(LightKind::Point));
            assert!(said.contains("width"), "{of:?}: {said}");
        }
    }
    assert!(refused(smoothie(SmoothieWidth::Share(0.1)), &sun).contains("metres"));
    let flat = Smoothie {
        spread: 0.0,
        ..Default::default()
    };
    assert!(refused(flat, &sun).contains("spread"));
    // Defaults fit every light.
    let kinds = [
        LightKind::Point,
        SPOT,
        LightKind::Directional,
        LightKind::Sphere { radius: 0.2 },
        LightKind::Rect {
            width: 0.0,
            height: 1.0,
        },
    ];
    for kind in kinds {
        assert_eq!(refused(Smoothie::default(), &light(kind)), "", "{kind:?}");
    }
}

/// The message of a refusal.
trait RequestError {
    fn request_error(&self, light: &Light) -> Option<String>;
}

impl RequestError for Smoothie {
    fn request_error(&self, light: &Light) -> Option<String> {
        use antumbra::techniques::Technique;
        self.check(light).err().map(|refusal| refusal.to_string())
    }
}
