//! What a light affects, and what it does not.

use antumbra::bevy_adapter::prelude::*;
use antumbra::techniques::Techniques;
use bevy::camera::visibility::RenderLayers;
use bevy::prelude::*;

use crate::harness::{self, Game, Picture};

/// Two floors beside each other, of which the right one is on layer 1, under a light.
struct Floors {
    game: Game,
    camera: Entity,
    light: Entity,
}

fn floors(ours: bool) -> Floors {
    let mut game = if ours {
        harness::game()
    } else {
        Game::start(harness::headless())
    };
    let world = game.world();
    world.insert_resource(GlobalAmbientLight::NONE);
    let camera = harness::camera(
        world,
        Transform::from_xyz(0.0, 6.0, 0.1).looking_at(Vec3::ZERO, Vec3::Y),
    );
    let mut view = world.entity_mut(camera);
    view.insert(RenderLayers::from_layers(&[0, 1]));
    if ours {
        view.insert(AntumbraCamera);
    }
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let floor = meshes.add(Plane3d::default().mesh().size(3.0, 3.0));
    let box_mesh = meshes.add(Cuboid::new(0.3, 0.3, 0.3));
    let matte = harness::matte(world);
    for (x, layer) in [(-1.5, 0), (1.5, 1)] {
        let layer = RenderLayers::layer(layer);
        let place = Transform::from_xyz(x, 0.0, 0.0);
        world.spawn((Mesh3d(floor.clone()), matte.clone(), place, layer.clone()));
        world.spawn((
            Mesh3d(box_mesh.clone()),
            matte.clone(),
            Transform::from_xyz(x, 1.0, 0.0),
            layer,
        ));
    }
    let light = world.spawn((
        PointLight {
            intensity: 500_000.0,
            radius: 0.05,
            ..default()
        },
        Transform::from_xyz(0.0, 4.0, 0.0),
    ));
    let light = light.id();
    Floors { game, camera, light }
}

/// Mean of the left and of the right half.
fn halves(picture: &Picture) -> [f32; 2] {
    let width = picture.size.x as usize;
    let mut sums = [0.0; 2];
    for (at, texel) in picture.texels.iter().enumerate() {
        sums[usize::from(at % width >= width / 2)] += f32::from(texel[1]);
    }
    sums.map(|sum| sum / (picture.texels.len() / 2) as f32)
}

#[test]
fn what_a_light_does_not_affect_it_does_not_light() {
    let mut floors = floors(true);
    let (camera, light) = (floors.camera, floors.light);
    let techniques = Techniques::default();
    let point = antumbra::scene::Light::point(Vec3::ONE, 1.0, 1.0);
    for row in techniques.rows() {
        let (name, settings) = (row.name(), row.defaults());
        if settings.check(&point).is_err() {
            continue;
        }
        let mut entity = floors.game.world().entity_mut(light);
        techniques.take(&mut entity);
        settings.insert(&mut entity);
        entity.remove::<LightSelection>();
        let all = floors.game.run(4).settled(camera);
        let select = |floors: &mut Floors, affects: u32| {
            let selection = LightSelection { affects, ..default() };
            floors.game.world().entity_mut(light).insert(selection);
            floors.game.run(4).settled(camera)
        };
        let left = select(&mut floors, 0b01);
        let right = select(&mut floors, 0b10);
        let both = select(&mut floors, 0b11);
        left.save(&format!("selection_{name}_left"));
        println!(
            "{name}: all {:?}, left {:?}, right {:?}",
            halves(&all),
            halves(&left),
            halves(&right)
        );
        let [all_left, all_right] = halves(&all);
        assert!(all_left > 0.1 && all_right > 0.1);
        // A picture that is fitted to what is lit has other texels.
        let same = |a: f32, b: f32| (a - b).abs() < 0.005 * b;
        let ([lit_left, dark_right], [dark_left, lit_right]) = (halves(&left), halves(&right));
        assert!(same(lit_left, all_left) && same(lit_right, all_right), "{name}");
        assert_eq!([dark_left, dark_right], [0.0; 2], "{name}");
        assert_eq!(both.difference(&all).channels, 0);
    }
}

/// Bevy's lights light what shares a layer with the camera, whatever their own layers are, as long as the camera shares one
/// with them; and so do ours.
#[test]
fn render_layers_of_lights_are_as_bevy_has_them() {
    let mut games = [false, true].map(|ours| {
        let mut floors = floors(ours);
        let world = floors.game.world();
        if ours {
            world.entity_mut(floors.light).insert(StencilVolume::default());
        }
        // Bevy shows no shadow, and neither do we.
        let meshes: Vec<Entity> = world
            .query_filtered::<Entity, With<Mesh3d>>()
            .iter(world)
            .collect();
        for mesh in meshes {
            world.entity_mut(mesh).insert(bevy::light::NotShadowCaster);
        }
        floors
    });
    for (layers, lights) in [(&[0][..], true), (&[1], true), (&[0, 1], true), (&[2], false)] {
        let pictures = games.each_mut().map(|floors| {
            let mut light = floors.game.world().entity_mut(floors.light);
            light.insert(RenderLayers::from_layers(layers));
            let camera = floors.camera;
            halves(&floors.game.run(5).settled(camera))
        });
        println!(
            "a light on {layers:?}: Bevy's {:?}, ours {:?}",
            pictures[0], pictures[1]
        );
        for half in 0..2 {
            let [bevys, ours] = pictures.map(|halves| halves[half]);
            // Bevy's is forward shading here, which differs by some percent.
            assert_eq!(bevys > 0.0, lights);
            assert!((ours - bevys).abs() <= 0.05 * bevys);
        }
    }
}
