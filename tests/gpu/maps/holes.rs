//! Alpha-tested casters cast the holes of their texture, from both sides.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::TextureWrap;
use antumbra::scene::{Texture, TextureSlot};
use antumbra::techniques::maps::MapResolution;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Affine2, EulerRot, Quat, UVec2, Vec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(160, 90);

/// A square of side 2 with the texture spread over it.
fn card() -> MeshData {
    let positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let mut mesh = MeshData::from_triangles("card", positions.to_vec(), vec![0, 2, 1, 0, 3, 2]);
    mesh.uv0 = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    mesh
}

/// Solid in two of four fields, left front and right back.
fn leaves() -> Material {
    let texture = Texture {
        name: "leaves".to_owned(),
        width: 2,
        height: 2,
        rgba8: [255, 0, 0, 255]
            .iter()
            .flat_map(|alpha| [80, 160, 60, *alpha])
            .collect(),
        wrap: [TextureWrap::Clamp; 2],
        linear_magnify: false,
        linear_minify: false,
    };
    Material {
        base_color_texture: Some(TextureSlot {
            texture: Arc::new(texture),
            uv_set: 0,
            uv_transform: Affine2::IDENTITY,
        }),
        alpha_mode: AlphaMode::Mask(0.5),
        double_sided: true,
        ..Material::matte(Vec3::ONE)
    }
}

/// A caster above the ground, of this shape and material.
type Card = (MeshData, Material, Transform);

/// A ground and the cards above it, which are not seen; their shadows are.
fn draw(ground: Material, cards: Vec<Card>, shadow: impl Bundle, kind: LightKind) -> Rendered {
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let view = Transform::from_xyz(0.0, 0.9, 3.5).looking_at(Vec3::new(0.0, 0.0, 0.5), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let of = |material| SceneMaterials([Arc::new(material)].into());
    stage.world.spawn((
        SceneMesh(Arc::new(MeshData::plane(5.0))),
        of(ground),
        (ShadowCaster, ShadowReceiver),
        Transform::default(),
    ));
    for (mesh, material, place) in cards {
        let mesh = SceneMesh(Arc::new(mesh));
        stage.world.spawn((mesh, of(material), ShadowCaster, place));
    }
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 20.0, 20.0)
    };
    let at = Transform::from_xyz(0.3, 4.0, 0.2).looking_at(Vec3::ZERO, Vec3::Z);
    stage.spawn_light(light, at, Some(shadow));
    stage.render().expect("the frame renders")
}

/// The visibility of the ground below the leaves, or below squares of their shape.
fn render(card_is_masked: bool, upside_down: bool, shadow: impl Bundle, kind: LightKind) -> Vec<f32> {
    let turn = if upside_down {
        Quat::from_rotation_z(std::f32::consts::PI)
    } else {
        Quat::IDENTITY
    };
    let place = Transform::from_xyz(0.0, 1.5, 0.0).with_rotation(turn);
    let cards = if card_is_masked {
        vec![(card(), leaves(), place)]
    } else {
        let square = |(x, z)| {
            let place = place * Transform::from_xyz(x, 0.0, z);
            (MeshData::plane(0.5), Material::matte(Vec3::ONE), place)
        };
        [(-0.5, -0.5), (0.5, 0.5)].map(square).into()
    };
    let ground = Material::matte(Vec3::ONE);
    draw(ground, cards, shadow, kind).visibility.remove(0)
}

fn differing(a: &[f32], b: &[f32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 0.5).count()
}

#[test]
fn leaves_cast_their_texture_from_both_sides() {
    let resolution = MapResolution::Fixed(1024);
    let spot = ShadowMap {
        resolution,
        ..Default::default()
    };
    let omni = OmniMap {
        resolution,
        ..Default::default()
    };
    let cone = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    for upside_down in [false, true] {
        let pairs = [
            [true, false].map(|masked| render(masked, upside_down, spot, cone)),
            [true, false].map(|masked| render(masked, upside_down, spot, LightKind::Directional)),
            [true, false].map(|masked| render(masked, upside_down, omni, LightKind::Point)),
        ];
        for [leaves, cut] in pairs {
            let dark = cut.iter().filter(|v| **v < 0.5).count();
            assert!(dark > 300, "{dark}");
            assert!(differing(&leaves, &cut) <= 12, "{}", differing(&leaves, &cut));
            let lit = vec![1.0; leaves.len()];
            assert!(differing(&leaves, &lit) > 300, "the comparison can fail");
        }
    }
}

/// Interpolated colours round, and alphas that are the cutoff must not fall below it.
#[test]
fn a_mask_whose_alpha_is_its_cutoff_has_no_holes() {
    let spot = ShadowMap {
        resolution: MapResolution::Fixed(256),
        ..Default::default()
    };
    let cone = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    let drawn = |alpha: f32, alpha_mode: AlphaMode| {
        let material = Material {
            base_color: Vec3::ONE.extend(alpha),
            alpha_mode,
            ..Material::matte(Vec3::ONE)
        };
        let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, 0.2);
        let place = Transform::from_xyz(0.1, 1.5, 0.0).with_rotation(turn);
        draw(material.clone(), vec![(card(), material, place)], spot, cone)
    };
    let solid = drawn(1.0, AlphaMode::Opaque);
    assert!(solid.visibility[0].iter().filter(|v| **v < 0.5).count() > 300);
    for (alpha, cutoff) in [(1.0, 1.0), (0.5, 0.5), (0.3, 0.3)] {
        let masked = drawn(alpha, AlphaMode::Mask(cutoff));
        let pairs = solid.radiance.iter().zip(&masked.radiance);
        let holes = pairs.filter(|(a, b)| (*a - *b).abs() > 0.01).count();
        assert_eq!(
            (holes, differing(&solid.visibility[0], &masked.visibility[0])),
            (0, 0),
            "{cutoff}"
        );
    }
}
