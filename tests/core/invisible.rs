//! Objects that alpha hides everywhere are not drawn and cast nothing. Objects that show anywhere do both.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{Texture, TextureSlot, TextureWrap};
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::sets::Objects;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Affine2, UVec2, Vec3, Vec4};

/// A material with an alpha factor, and a texture of two texels with these alphas.
fn material(alpha_mode: AlphaMode, alpha: f32, texels: Option<[u8; 2]>) -> Material {
    let slot = texels.map(|alphas| TextureSlot {
        texture: Arc::new(Texture {
            name: "two".to_owned(),
            width: 2,
            height: 1,
            rgba8: alphas.iter().flat_map(|alpha| [200, 200, 200, *alpha]).collect(),
            wrap: [TextureWrap::Clamp; 2],
            linear_magnify: true,
            linear_minify: true,
        }),
        uv_set: 0,
        uv_transform: Affine2::IDENTITY,
    });
    Material {
        base_color: Vec4::new(1.0, 1.0, 1.0, alpha),
        base_color_texture: slot,
        alpha_mode,
        ..Material::default()
    }
}

fn faded(alpha: f32) -> MeshData {
    let mut mesh = MeshData::cuboid(Vec3::splat(0.5));
    mesh.colors = vec![Vec4::new(1.0, 1.0, 1.0, alpha); mesh.positions.len()];
    mesh
}

/// Whether an object casts and whether it is drawn in the next frame.
fn seen(world: &mut World, schedule: &mut Schedule, entity: Entity) -> [bool; 2] {
    schedule.run(world);
    let objects = world.resource::<Objects>();
    let index = objects.entities.iter().position(|&other| other == entity);
    let index = index.expect("an object");
    [objects.casters.contains(index), objects.drawn.contains(index)]
}

#[test]
fn what_is_invisible_everywhere_neither_shows_nor_casts() {
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(UVec2::new(64, 48)));
    world.spawn((Camera::default(), Transform::from_xyz(0.0, 1.0, 8.0)));
    let mut schedule = standalone_schedule();
    let mut spawn = |mesh: MeshData, material: Material| {
        let looks = (
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(material)].into()),
        );
        world
            .spawn((looks, ShadowCaster, ShadowReceiver, Transform::IDENTITY))
            .id()
    };
    let cube = || MeshData::cuboid(Vec3::splat(0.5));
    let mask = AlphaMode::Mask;
    let hidden = [
        spawn(cube(), material(AlphaMode::Blend, 0.0, None)),
        spawn(cube(), material(AlphaMode::Blend, 1.0, Some([0, 0]))),
        spawn(cube(), material(mask(0.9), 0.5, None)),
        spawn(cube(), material(mask(0.5), 1.0, Some([100, 0]))),
        spawn(cube(), material(mask(2.0), 1.0, Some([255, 255]))),
        spawn(faded(0.0), material(AlphaMode::Blend, 1.0, None)),
        spawn(faded(0.2), material(mask(0.5), 1.0, None)),
    ];
    let shown = [
        spawn(cube(), material(AlphaMode::Opaque, 0.0, Some([0, 0]))),
        spawn(cube(), material(AlphaMode::Blend, 0.01, None)),
        spawn(cube(), material(AlphaMode::Blend, 1.0, Some([0, 1]))),
        spawn(cube(), material(mask(0.5), 1.0, Some([0, 128]))),
        spawn(cube(), material(mask(0.0), 0.0, None)),
        spawn(faded(0.6), material(mask(0.5), 1.0, None)),
    ];
    for entity in hidden {
        assert_eq!(seen(&mut world, &mut schedule, entity), [false; 2], "{entity}");
    }
    for entity in shown {
        assert_eq!(seen(&mut world, &mut schedule, entity), [true; 2], "{entity}");
    }
    // A material that fades out, and one that fades in.
    let exchange = |world: &mut World, entity: Entity, material: Material| {
        world
            .entity_mut(entity)
            .insert(SceneMaterials([Arc::new(material)].into()));
    };
    exchange(&mut world, shown[1], material(AlphaMode::Blend, 0.0, None));
    exchange(&mut world, hidden[0], material(AlphaMode::Blend, 0.5, None));
    assert_eq!(seen(&mut world, &mut schedule, shown[1]), [false; 2]);
    assert_eq!(seen(&mut world, &mut schedule, hidden[0]), [true; 2]);
    // A mesh that is not drawn casts: it stands for something that is.
    world.entity_mut(shown[0]).remove::<SceneMaterials>();
    assert_eq!(seen(&mut world, &mut schedule, shown[0]), [true, false]);
}
