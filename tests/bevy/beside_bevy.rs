//! A marked camera beside an unmarked one of the same game: what Bevy shows of lights, meshes and materials stays.

use antumbra::bevy_adapter::prelude::*;
use bevy::asset::RenderAssetUsages;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::material::OpaqueRendererMethod;
use bevy::pbr::{ContactShadows, Lightmap};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

use crate::harness::{self, Game, Picture};

const EYE: Vec3 = Vec3::new(0.0, 3.0, 6.0);

/// Spawns two cameras at one place. The second one is marked.
fn pair(world: &mut World) -> [Entity; 2] {
    let place = Transform::from_translation(EYE).looking_at(Vec3::ZERO, Vec3::Y);
    let bevys = harness::camera(world, place);
    world.entity_mut(bevys).insert((DepthPrepass, DeferredPrepass));
    [bevys, harness::marked_camera(world, EYE)]
}

/// Spawns a floor that casts nothing, with tangents and the texture coordinates of a lightmap.
fn floor(world: &mut World, material: StandardMaterial) -> Entity {
    let mut mesh = Plane3d::default().mesh().size(6.0, 6.0).build();
    let vertices = mesh.count_vertices();
    let uvs = mesh
        .attribute(Mesh::ATTRIBUTE_UV_0)
        .expect("they are there")
        .clone();
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
    mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, 1.0]; vertices]);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    world
        .spawn((Mesh3d(mesh), MeshMaterial3d(material), NotShadowCaster))
        .id()
}

/// Makes a picture of one colour.
fn plain(world: &mut World, texel: [u8; 4]) -> Handle<Image> {
    let size = Extent3d::default();
    let (format, usages) = (TextureFormat::Rgba8Unorm, RenderAssetUsages::RENDER_WORLD);
    let image = Image::new(size, TextureDimension::D2, texel.to_vec(), format, usages);
    world.resource_mut::<Assets<Image>>().add(image)
}

fn point() -> PointLight {
    PointLight {
        intensity: 500_000.0,
        radius: 0.1,
        ..default()
    }
}

fn sun() -> DirectionalLight {
    DirectionalLight {
        illuminance: 2000.0,
        ..default()
    }
}

/// A place behind what is seen, from where shadows fall towards the camera.
fn at(x: f32) -> Transform {
    Transform::from_xyz(x, 4.0, -2.0).looking_at(Vec3::ZERO, Vec3::Y)
}

/// Spawns a cube above the floor.
fn cube(world: &mut World) -> Entity {
    harness::add_mesh(
        world,
        Cuboid::from_length(1.5),
        Transform::from_xyz(0.0, 1.2, 0.0),
    )
}

fn glossy() -> StandardMaterial {
    StandardMaterial {
        perceptual_roughness: 0.4,
        ..default()
    }
}

#[test]
fn lights_in_a_lightmap_are_not_added_again() {
    let mut game = harness::game();
    let mut see = |is_mapped: bool| {
        let world = game.clear().world();
        world.insert_resource(GlobalAmbientLight {
            brightness: 500.0,
            affects_lightmapped_meshes: false,
            ..default()
        });
        let cameras = pair(world);
        let floor = floor(
            world,
            StandardMaterial {
                lightmap_exposure: 100.0,
                ..glossy()
            },
        );
        if is_mapped {
            let image = plain(world, [128; 4]);
            world.entity_mut(floor).insert(Lightmap { image, ..default() });
        }
        let baked = PointLight {
            affects_lightmapped_mesh_diffuse: false,
            ..point()
        };
        let baked_sun = DirectionalLight {
            affects_lightmapped_mesh_diffuse: false,
            ..sun()
        };
        world.spawn((baked, StencilVolume::default(), at(1.0)));
        world.spawn((baked_sun, PenumbraWedge::default(), at(-1.0)));
        let live = PointLight {
            intensity: 100_000.0,
            ..point()
        };
        world.spawn((live, OmniMap::default(), at(-2.0)));
        let [bevys, ours] = game.run(6).all_settled(cameras);
        cube(game.world());
        (bevys, ours, game.run(3).settled(cameras[1]))
    };
    let (bevys, ours, shadowed) = see(true);
    ours.save("lightmapped");
    assert_eq!(ours.difference(&bevys).channels, 0);
    let darker = |(a, b): (&[half::f16; 3], &[half::f16; 3])| f32::from(a[1]) < 0.9 * f32::from(b[1]);
    let pairs = shadowed.texels.iter().zip(&ours.texels);
    let dark = pairs.filter(|&pair| darker(pair)).count();
    assert!(dark > 100, "{dark} pixels show a shadow");
    let (_, unmapped, _) = see(false);
    assert!(
        ours.mean() < 0.7 * unmapped.mean(),
        "diffuse light that is left out: {} of {}",
        ours.mean(),
        unmapped.mean()
    );
}

#[test]
fn materials_keep_what_a_g_buffer_does_not_hold() {
    let mut game = harness::dark_game();
    let normals = plain(game.world(), [190, 128, 230, 255]);
    let coated = StandardMaterial {
        clearcoat: 1.0,
        clearcoat_perceptual_roughness: 0.4,
        ..glossy()
    };
    let materials = [
        (
            "anisotropy",
            StandardMaterial {
                anisotropy_strength: 0.8,
                ..glossy()
            },
        ),
        (
            "tint",
            StandardMaterial {
                specular_tint: Color::linear_rgb(1.0, 0.2, 0.1),
                ..glossy()
            },
        ),
        (
            "rough coat",
            StandardMaterial {
                clearcoat_perceptual_roughness: 0.8,
                ..coated.clone()
            },
        ),
        (
            "smooth coat",
            StandardMaterial {
                normal_map_texture: Some(normals),
                ..coated.clone()
            },
        ),
        ("none", coated),
    ];
    for (feature, material) in materials {
        let world = game.clear().world();
        let cameras = pair(world);
        floor(world, material);
        world.spawn((point(), StencilVolume::default(), at(-1.0)));
        let [bevys, ours] = game.run(6).all_settled(cameras);
        ours.save(&format!("feature_{feature}"));
        let difference = ours.difference(&bevys);
        println!("{feature}: {difference:?}");
        // A material without such a feature goes through the G-buffer, which rounds.
        assert_eq!(difference.channels == 0, feature != "none", "{feature}");
    }
}

#[test]
fn contact_shadows_of_managed_lights_are_bevys() {
    let mut game = harness::dark_game();
    for receives in [true, false] {
        let world = game.clear().world();
        let cameras = pair(world);
        for camera in cameras {
            world.entity_mut(camera).insert(ContactShadows {
                thickness: 0.5,
                length: 1.0,
                ..default()
            });
        }
        let without = harness::marked_camera(world, EYE);
        let deferred = StandardMaterial {
            opaque_render_method: OpaqueRendererMethod::Deferred,
            ..default()
        };
        let floor = floor(world, deferred.clone());
        let matte = world.resource_mut::<Assets<StandardMaterial>>().add(deferred);
        let caster = harness::add_mesh(
            world,
            Cuboid::from_length(1.0),
            Transform::from_xyz(0.0, 0.5, 0.0),
        );
        // Only contact shadows darken the floor.
        world
            .entity_mut(caster)
            .insert((MeshMaterial3d(matte), NotShadowCaster));
        if !receives {
            world.entity_mut(floor).insert(NotShadowReceiver);
            world.entity_mut(caster).insert(NotShadowReceiver);
        }
        let point = PointLight {
            contact_shadows_enabled: true,
            ..point()
        };
        let spot = SpotLight {
            intensity: 600_000.0,
            contact_shadows_enabled: true,
            ..default()
        };
        let sun = DirectionalLight {
            contact_shadows_enabled: true,
            ..sun()
        };
        let high = Transform::from_xyz(0.0, 4.0, -3.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((point, StencilVolume::default(), at(1.0)));
        world.spawn((spot, ShadowMap::default(), high));
        world.spawn((sun, PenumbraWedge::default(), at(-2.0)));
        // The noise of contact shadows is another in each frame.
        game.run(12);
        let [bevys, ours] = cameras.map(|camera| game.radiance(camera));
        let lit = game.radiance(without);
        bevys.save(&format!("contact_bevy_{receives}"));
        ours.save(&format!("contact_ours_{receives}"));
        let (apart, shadow) = (ours.difference(&bevys), lit.difference(&ours));
        println!("contact shadows, received {receives}: from Bevy's {apart:?}, from none {shadow:?}");
        assert!(apart.steps <= 3, "a rounding a light: {apart:?}");
        assert_eq!(shadow.channels > 100, receives, "{shadow:?}");
    }
}

/// Draws a floor under two equal lights, of which one is managed. Returns Bevy's picture, ours, and ours with a cube in the way of
/// the light.
fn of_two_lights(game: &mut Game, method: OpaqueRendererMethod, light: impl Bundle + Clone) -> [Picture; 3] {
    let world = game.clear().world();
    let cameras = pair(world);
    floor(
        world,
        StandardMaterial {
            opaque_render_method: method,
            ..glossy()
        },
    );
    world.spawn((light.clone(), at(1.0)));
    world.spawn((light, at(1.0), StencilVolume::default()));
    let [bevys, ours] = game.run(6).all_settled(cameras);
    cube(game.world());
    [bevys, ours, game.run(3).settled(cameras[1])]
}

#[test]
fn of_two_equal_lights_the_unmanaged_one_shines_on() {
    let mut game = harness::dark_game();
    let panel = RectLight {
        intensity: 200_000.0,
        ..default()
    };
    for method in [OpaqueRendererMethod::Deferred, OpaqueRendererMethod::Forward] {
        for (name, [bevys, ours, shadowed]) in [
            ("suns", of_two_lights(&mut game, method, sun())),
            ("panels", of_two_lights(&mut game, method, panel)),
        ] {
            shadowed.save(&format!("two_{name}_{method:?}"));
            let apart = ours.difference(&bevys);
            println!("{name}, {method:?}: {apart:?}");
            assert!(apart.steps <= 2, "{name}, {method:?}: {apart:?}");
            // One of the floor's two lights is missing in the shadow.
            let pairs = shadowed.texels.iter().zip(&ours.texels);
            let shares = pairs.map(|(a, b)| f32::from(a[1]) / f32::from(b[1]));
            let shares: Vec<f32> = shares.filter(|share| share.is_finite()).collect();
            let half = shares.iter().filter(|&share| (share - 0.5).abs() < 0.01).count();
            println!("{half} of {} pixels in the shadow", shares.len());
            assert!(half > 50, "{name}, {method:?}: {half} pixels in the shadow");
        }
    }
}
