//! Maps leave the holes that alpha cuts into Bevy's materials out of shadows; volumes and wedges cannot, and the log says
//! so.

use antumbra::bevy_adapter::prelude::*;
use antumbra::reports::Reports;
use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

use crate::harness::{self, Game, Picture};
use crate::setup::warnings;

/// A picture of two columns of texels, of which the left or the right one is a hole.
fn halves(hole_at_right: bool) -> Image {
    let (hole, body) = ([255, 255, 255, 0], [255; 4]);
    let texels = if hole_at_right { [body, hole] } else { [hole, body] };
    let size = Extent3d {
        width: 2,
        height: 1,
        depth_or_array_layers: 1,
    };
    let format = TextureFormat::Rgba8UnormSrgb;
    // With the default sampler: if only the pixels change, Bevy keeps the texture, its view and its sampler.
    Image::new(
        size,
        TextureDimension::D2,
        texels.concat(),
        format,
        RenderAssetUsages::default(),
    )
}

struct Scene {
    game: Game,
    camera: Entity,
    card: Entity,
    light: Entity,
    image: Handle<Image>,
    material: Handle<StandardMaterial>,
}

impl Scene {
    /// A card 2 m wide, 1 m above the floor and out of view, under a light 4 m above the floor.
    fn new(technique: impl Bundle) -> Self {
        let mut game = harness::dark_game();
        let world = game.world();
        let camera = harness::marked_camera(world, Vec3::new(0.0, 0.9, 1.6));
        let floor = Plane3d::default().mesh().size(8.0, 8.0);
        harness::add_mesh(world, floor, Transform::default());
        let image = world.resource_mut::<Assets<Image>>().add(halves(false));
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color_texture: Some(image.clone()),
                alpha_mode: AlphaMode::Mask(0.5),
                cull_mode: None,
                ..default()
            });
        let card = Plane3d::default().mesh().size(1.2, 0.8);
        let card = harness::add_mesh(world, card, Transform::from_xyz(0.0, 1.5, 0.0));
        world
            .entity_mut(card)
            .insert((Name::new("card"), MeshMaterial3d(material.clone())));
        let light = PointLight {
            intensity: 500_000.0,
            ..default()
        };
        let place = Transform::from_xyz(0.0, 4.0, 0.0);
        let light = world.spawn((light, technique, place)).id();
        game.run(3);
        Self {
            game,
            camera,
            card,
            light,
            image,
            material,
        }
    }

    fn picture(&mut self) -> Picture {
        self.game.run(3).settled(self.camera)
    }

    /// Whether the floor at the left and at the right of the middle is lit.
    fn lit(&mut self) -> [bool; 2] {
        let picture = self.picture();
        [-0.5, 0.5].map(|x| {
            let world = self.game.world();
            let place = *world.get::<GlobalTransform>(self.camera).unwrap();
            let camera = world.get::<Camera>(self.camera).unwrap();
            let at = camera.world_to_viewport(&place, Vec3::X * x).unwrap().as_uvec2();
            f32::from(picture.texels[(at.y * picture.size.x + at.x) as usize][1]) > 0.0
        })
    }
}

#[test]
fn maps_show_the_holes_of_bevys_textures() {
    let mut scene = Scene::new(OmniMap::default());
    let holed = scene.picture();
    holed.save("cut_out");
    assert_eq!(scene.lit(), [true, false]);
    // As a card of half the width.
    let (card, image, material) = (scene.card, scene.image.clone(), scene.material.clone());
    let world = scene.game.world();
    let half = Plane3d::default().mesh().size(0.6, 0.8);
    let half = harness::add_mesh(world, half, Transform::from_xyz(0.3, 1.5, 0.0));
    world.entity_mut(card).insert(Visibility::Hidden);
    let of_half = scene.picture();
    of_half.save("cut_out_half");
    let unlike = of_half.texels.iter().zip(&holed.texels).filter(|(a, b)| {
        let (a, b) = (f32::from(a[1]), f32::from(b[1]));
        (a - b).abs() > 0.02 * a.max(b)
    });
    let unlike = unlike.count();
    assert!(
        unlike < 100,
        "{unlike} pixels are not as under a card of half the width"
    );
    let world = scene.game.world();
    world.despawn(half);
    world.entity_mut(card).insert(Visibility::Inherited);
    // The pixels are exchanged, then the texture is flipped.
    let world = scene.game.world();
    world
        .resource_mut::<Assets<Image>>()
        .insert(image.id(), halves(true))
        .unwrap();
    assert_eq!(scene.lit(), [false, true]);
    let change = |scene: &mut Scene, change: fn(&mut StandardMaterial)| {
        let mut materials = scene.game.world().resource_mut::<Assets<StandardMaterial>>();
        change(&mut materials.get_mut(material.id()).unwrap());
        scene.lit()
    };
    let flipped = change(&mut scene, |material| {
        material.uv_transform = StandardMaterial::FLIP_HORIZONTAL;
    });
    assert_eq!(flipped, [true, false]);
    // Blended as it is, what Bevy leaves out of its maps is left out of ours; opaque, nothing is.
    assert_eq!(
        change(&mut scene, |material| material.alpha_mode = AlphaMode::Blend),
        [true, false]
    );
    assert_eq!(
        change(&mut scene, |material| material.alpha_mode = AlphaMode::Opaque),
        [false; 2]
    );
    assert_eq!(
        change(&mut scene, |material| material.alpha_mode = AlphaMode::Mask(0.3)),
        [true, false]
    );
    // Of maps alone nothing is said.
    let reports = scene.game.world().resource::<Reports>();
    assert_eq!(reports.iter().count(), 0);

    // A second light, of triangles: it casts whole, which is logged once.
    let light = scene.light;
    let mut light = scene.game.world().entity_mut(light);
    light.remove::<OmniMap>().insert(StencilVolume::default());
    assert_eq!(scene.lit(), [false; 2]);
    scene.game.run(3);
    let said = warnings("`card`");
    assert_eq!(said.len(), 1, "{said:?}");
    for text in ["material:", "holes", "OmniMap"] {
        assert!(said[0].contains(text), "{text}: {}", said[0]);
    }
}
