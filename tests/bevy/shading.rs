//! With visibility 1 our light is Bevy's: to the bit where no light is managed, to a rounding of the sum where some are.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::CubemapLayout;
use bevy::camera::{Hdr, RenderTarget, ScalingMode, Viewport};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::light::{DirectionalLightTexture, PointLightTexture, SpotLightTexture};
use bevy::pbr::DefaultOpaqueRendererMethod;
use bevy::prelude::*;
use bevy::render::camera::TemporalJitter;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

use antumbra::bevy_adapter::prelude::*;

use crate::harness::{self, Game, Picture};

/// How the scene is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Look {
    #[default]
    Plain,
    Fog,
    /// Off by a part of a pixel, as temporal antialiasing has it.
    Jitter,
    /// Two cameras beside each other in one picture.
    Split,
    /// A near plane that cuts the scene aslant.
    Oblique,
    /// Lights with textures.
    Textures,
    Orthographic,
    /// As temporal antialiasing has it.
    OrthographicJitter,
}

/// Lights and a look of the test scene.
#[derive(Clone, Copy, Default)]
struct Scene {
    ours: bool,
    /// The first lights of each kind are managed.
    managed: bool,
    look: Look,
    /// Off by this factor, a managed light.
    dimmed: Option<f32>,
}

/// Lights that are managed.
const MANAGED: i32 = 5;

fn add_mesh(
    world: &mut World,
    mesh: impl Into<Mesh>,
    material: StandardMaterial,
    transform: Transform,
) -> Entity {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh.into());
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    world
        .spawn((Mesh3d(mesh), MeshMaterial3d(material), transform))
        .id()
}

/// A game of ours and one of Bevy's, in which one scene takes the place of another. They start when a scene first needs them.
#[derive(Default)]
struct Games([Option<Game>; 2]);

impl Games {
    fn picture(&mut self, scene: Scene) -> Picture {
        let game = self.0[usize::from(scene.ours)].get_or_insert_with(|| start(scene.ours));
        let camera = fill(game.clear().world(), scene);
        game.run(4).settled(camera)
    }
}

fn start(ours: bool) -> Game {
    let mut app = if ours {
        harness::antumbra()
    } else {
        harness::headless()
    };
    app.insert_resource(DefaultOpaqueRendererMethod::deferred());
    Game::start(app)
}

/// Spawns a scene, and returns its first camera.
fn fill(world: &mut World, scene: Scene) -> Entity {
    let camera = harness::camera(
        world,
        Transform::from_xyz(-2.5, 4.5, 9.0).looking_at(Vec3::ZERO, Vec3::Y),
    );
    let mut view = world.entity_mut(camera);
    view.insert((DepthPrepass, DeferredPrepass));
    if scene.ours {
        view.insert(AntumbraCamera);
    }
    match scene.look {
        Look::Plain | Look::Split | Look::Textures => {}
        Look::Fog => {
            view.insert(DistanceFog {
                color: Color::srgb(0.3, 0.35, 0.4),
                falloff: FogFalloff::Exponential { density: 0.06 },
                ..default()
            });
        }
        Look::Jitter => {
            view.insert(TemporalJitter {
                offset: Vec2::new(0.375, -0.25),
            });
        }
        Look::Orthographic | Look::OrthographicJitter => {
            view.insert(Projection::Orthographic(OrthographicProjection {
                scaling_mode: ScalingMode::FixedVertical { viewport_height: 7.0 },
                ..OrthographicProjection::default_3d()
            }));
            if scene.look == Look::OrthographicJitter {
                view.insert(TemporalJitter {
                    offset: Vec2::new(0.375, -0.25),
                });
            }
        }
        Look::Oblique => {
            let normal = Vec3::new(0.3, 0.1, -1.0).normalize();
            view.insert(Projection::Perspective(PerspectiveProjection {
                near_clip_plane: normal.extend(-normal.dot(Vec3::new(0.0, 0.0, -8.0))),
                ..default()
            }));
        }
    }
    if scene.look == Look::Split {
        let half = UVec2::new(harness::SIZE.x / 2, harness::SIZE.y);
        let viewport = |x: u32| Viewport {
            physical_position: UVec2::new(x, 0),
            physical_size: half,
            ..default()
        };
        view.get_mut::<Camera>().unwrap().viewport = Some(viewport(0));
        let target = view.get::<RenderTarget>().unwrap().clone();
        let mut second = world.spawn((
            (Camera3d::default(), Hdr, Msaa::Off, Tonemapping::None, target),
            Camera {
                order: 1,
                viewport: Some(viewport(half.x)),
                clear_color: ClearColorConfig::None,
                ..default()
            },
            (DepthPrepass, DeferredPrepass),
            Transform::from_xyz(5.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        if scene.ours {
            second.insert(AntumbraCamera);
        }
    }
    let floor = StandardMaterial {
        base_color: Color::srgb(0.6, 0.55, 0.5),
        perceptual_roughness: 0.6,
        ..default()
    };
    add_mesh(
        world,
        Plane3d::default().mesh().size(12.0, 12.0),
        floor,
        Transform::default(),
    );
    let coated = StandardMaterial {
        base_color: Color::srgb(0.2, 0.4, 0.9),
        perceptual_roughness: 0.3,
        metallic: 0.2,
        clearcoat: 0.5,
        ..default()
    };
    let place = Transform::from_xyz(0.0, 0.75, 0.0).with_rotation(Quat::from_rotation_y(0.5));
    add_mesh(world, Cuboid::new(1.5, 1.5, 1.5), coated, place);
    let metal = StandardMaterial {
        base_color: Color::srgb(0.9, 0.8, 0.3),
        perceptual_roughness: 0.2,
        metallic: 1.0,
        emissive: LinearRgba::rgb(0.02, 0.0, 0.0),
        ..default()
    };
    add_mesh(world, Sphere::new(0.7), metal, Transform::from_xyz(2.0, 0.7, 1.0));

    let at = |x: f32, y: f32, z: f32| Transform::from_xyz(x, y, z).looking_at(Vec3::ZERO, Vec3::Y);
    let spot = |intensity: f32, color: Color| SpotLight {
        intensity,
        color,
        ..default()
    };
    let point = |intensity: f32, color: Color| PointLight {
        intensity,
        color,
        radius: 0.1,
        ..default()
    };
    let sun = |illuminance: f32| DirectionalLight {
        illuminance,
        ..default()
    };
    let rect = |intensity: f32, width: f32| RectLight {
        intensity,
        width,
        ..default()
    };
    let managed = [
        world
            .spawn((point(300_000.0, Color::WHITE), at(3.0, 4.0, 2.0)))
            .id(),
        world
            .spawn((point(200_000.0, Color::srgb(1.0, 0.6, 0.3)), at(-3.0, 2.0, 3.0)))
            .id(),
        world
            .spawn((spot(800_000.0, Color::srgb(0.4, 1.0, 0.4)), at(-1.0, 6.0, 2.0)))
            .id(),
        world.spawn((sun(300.0), at(1.0, 2.0, 1.5))).id(),
        world.spawn((rect(200_000.0, 2.0), at(0.0, 3.0, 4.0))).id(),
    ];
    world.spawn((point(400_000.0, Color::srgb(0.3, 0.6, 1.0)), at(0.0, 5.0, -3.0)));
    world.spawn((spot(500_000.0, Color::WHITE), at(4.0, 5.0, -1.0)));
    world.spawn((
        DirectionalLight {
            illuminance: 200.0,
            shadow_maps_enabled: true,
            ..default()
        },
        at(-1.0, 2.0, 0.5),
    ));
    world.spawn((rect(100_000.0, 1.0), at(4.0, 2.0, 3.0)));
    if scene.managed {
        // Bevy looks its spots up in clusters, to which it does not apply the jitter of orthographic views: it misses
        // light where a spot's clusters end.
        let misses = |light| scene.look == Look::OrthographicJitter && light == managed[2];
        for light in managed.into_iter().filter(|&light| !misses(light)) {
            world.entity_mut(light).insert(StencilVolume::default());
        }
    }
    if scene.look == Look::Textures {
        let image = world.resource_mut::<Assets<Image>>().add(stripes());
        world.entity_mut(managed[0]).insert(PointLightTexture {
            image: image.clone(),
            cubemap_layout: CubemapLayout::SequenceVertical,
        });
        world
            .entity_mut(managed[2])
            .insert(SpotLightTexture { image: image.clone() });
        world
            .entity_mut(managed[3])
            .insert(DirectionalLightTexture { image, tiled: true });
    }
    // Nothing casts, so that visibility is 1.
    let meshes: Vec<Entity> = world
        .query_filtered::<Entity, With<Mesh3d>>()
        .iter(world)
        .collect();
    for mesh in meshes {
        world.entity_mut(mesh).insert(bevy::light::NotShadowCaster);
    }
    if let Some(factor) = scene.dimmed {
        world.get_mut::<PointLight>(managed[0]).unwrap().intensity *= factor;
    }
    camera
}

/// Stripes, and darker ones from face to face of a cube.
fn stripes() -> Image {
    let size = Extent3d {
        width: 16,
        height: 96,
        depth_or_array_layers: 1,
    };
    let texel = |at: usize| {
        if (at / 3).is_multiple_of(2) {
            255
        } else {
            (at / 6 % 200) as u8
        }
    };
    let texels = (0..16 * 96).map(texel).collect();
    let usages = RenderAssetUsages::RENDER_WORLD;
    Image::new(size, TextureDimension::D2, texels, TextureFormat::R8Unorm, usages)
}

#[test]
fn without_managed_lights_every_channel_is_bevys() {
    let mut games = Games::default();
    for look in [Look::Plain, Look::Fog, Look::Orthographic] {
        let bevy = games.picture(Scene { look, ..default() });
        let ours = games.picture(Scene {
            look,
            ours: true,
            ..default()
        });
        bevy.save(&format!("shading_{look:?}_bevy"));
        ours.save(&format!("shading_{look:?}_ours"));
        let difference = ours.difference(&bevy);
        println!("{look:?}: no light managed, against Bevy's deferred lighting: {difference:?}");
        assert!(bevy.mean() > 0.01, "nothing is seen");
        assert_eq!(difference.channels, 0);
    }
}

#[test]
fn managed_lights_add_up_to_bevys_light() {
    let mut games = Games::default();
    for look in [
        Look::Plain,
        Look::Fog,
        Look::Jitter,
        Look::Split,
        Look::Oblique,
        Look::Orthographic,
        Look::OrthographicJitter,
    ] {
        let bevy = games.picture(Scene { look, ..default() });
        let scene = Scene {
            look,
            ours: true,
            managed: true,
            ..default()
        };
        let ours = games.picture(scene);
        bevy.save(&format!("shading_{look:?}_bevy"));
        ours.save(&format!("shading_{look:?}_managed"));
        let difference = ours.difference(&bevy);
        println!("{look:?}: {MANAGED} lights of four kinds managed, against Bevy: {difference:?}");
        assert!(difference.steps <= MANAGED, "a rounding a light");
    }
}

/// Bevy has textures of lights as an option of its own, `--features bevy/pbr_light_textures,bevy/pbr_clustered_decals`, for
/// devices that index arrays of bindings non-uniformly. Without, none are shown by either.
#[test]
fn textures_of_managed_lights_are_bevys() {
    let look = Look::Textures;
    let mut games = Games::default();
    let bevy = games.picture(Scene { look, ..default() });
    let has_textures = games.picture(Scene::default()).difference(&bevy).steps > MANAGED;
    let ours = games.picture(Scene {
        look,
        ours: true,
        managed: true,
        ..default()
    });
    ours.save("shading_Textures_managed");
    let difference = ours.difference(&bevy);
    println!("Bevy shows textures of lights: {has_textures}; {MANAGED} lights managed: {difference:?}");
    assert!(difference.steps <= MANAGED, "a rounding a light");
}

#[test]
fn a_managed_light_that_is_off_by_a_hundredth_is_found() {
    let mut games = Games::default();
    let bevy = games.picture(Scene::default());
    let ours = games.picture(Scene {
        ours: true,
        managed: true,
        dimmed: Some(0.99),
        ..default()
    });
    assert!(ours.difference(&bevy).steps > MANAGED);
}
