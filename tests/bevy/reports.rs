//! Whatever is wrong is logged once, with the name that the game gave the entity, and again when it changes.

use antumbra::bevy_adapter::Mirrors;
use antumbra::bevy_adapter::prelude::*;
use antumbra::render::Renderer;
use antumbra::reports::Reports;
use antumbra::techniques::maps::{MapFilter, MapResolution};
use antumbra::techniques::penumbra_wedge::WedgeOverflow;
use bevy::asset::RenderAssetUsages;
use bevy::camera::{CameraProjection, SubCameraView};
use bevy::light::RectLight;
use bevy::math::Vec3A;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;

use crate::harness::{self, Game};
use crate::setup::{listen, warnings};

const EYE: Vec3 = Vec3::new(0.0, 3.0, 6.0);

/// A game with two cameras, of which each has a mirror; nothing of it wrong. All names begin with `scene`.
fn game(scene: &str) -> (Game, [Entity; 2]) {
    listen();
    let mut game = harness::game();
    let world = game.world();
    let cameras = [EYE, EYE + Vec3::X].map(|eye| harness::unseen_camera(world, eye));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    let floor = harness::add_mesh(world, floor, Transform::default());
    let light = harness::add_light(world);
    for (part, entity) in [cameras[0], cameras[1], floor, light].into_iter().enumerate() {
        world
            .entity_mut(entity)
            .insert(Name::new(format!("{scene} {part}")));
    }
    game.run(3);
    (game, cameras)
}

fn light_at(world: &mut World, name: &str, parts: impl Bundle) -> Entity {
    let at = Transform::from_xyz(1.0, 4.0, 1.0).looking_at(Vec3::ZERO, Vec3::Z);
    world.spawn((Name::new(name.to_owned()), at, parts)).id()
}

/// Lines that name an entity.
fn lines(name: &str) -> Vec<String> {
    warnings(&format!("`{name}`"))
}

/// There are so many lines of an entity, the last says this, and further frames add none.
fn expect(game: &mut Game, name: &str, count: usize, text: &[&str]) {
    game.run(2);
    for frame in 0..3 {
        let lines = lines(name);
        assert_eq!(lines.len(), count, "{name}, {frame} frames later: {lines:#?}");
        let last = lines.last().expect("there is one");
        for text in text {
            assert!(last.contains(text), "{text:?}: {last}");
        }
        game.run(1);
    }
}

fn standing(game: &mut Game) -> usize {
    game.world().resource::<Reports>().iter().count()
}

#[test]
fn a_healthy_game_logs_nothing() {
    let (mut game, _) = game("healthy");
    let spot = SpotLight::default();
    light_at(game.world(), "healthy spot", (spot, ShadowMap::default()));
    let ball = PointLight {
        radius: 0.2,
        ..default()
    };
    light_at(game.world(), "healthy ball", (ball, PenumbraWedge::default()));
    let sun = DirectionalLight::default();
    light_at(game.world(), "healthy sun", (sun, ShadowMap::default()));
    light_at(game.world(), "healthy bevy", PointLight::default());
    let hidden = Transform::from_scale(Vec3::ZERO);
    let hidden = harness::add_mesh(game.world(), Cuboid::default(), hidden);
    let name = Name::new("healthy hidden");
    game.world().entity_mut(hidden).insert(name);
    game.run(8);
    assert_eq!(warnings("healthy"), Vec::<String>::new());
    assert_eq!(standing(&mut game), 0);
}

#[test]
fn a_light_that_cannot_shine_is_logged_with_its_name() {
    let (mut game, _) = game("shine");
    let dark = PointLight {
        range: 0.0,
        ..default()
    };
    let lamp = light_at(game.world(), "lamp", (dark, StencilVolume::default()));
    expect(&mut game, "lamp", 1, &["light:", "range is 0 m", "Set a range"]);
    assert_eq!(standing(&mut game), 1, "two cameras, one report");
    let report = game.world().resource::<Reports>().of_entity(lamp).next();
    assert_eq!(report.expect("of the game's entity").topic, "light");
    game.world().get_mut::<PointLight>(lamp).unwrap().intensity = -1.0;
    expect(&mut game, "lamp", 2, &["intensity is -1"]);
    game.world().entity_mut(lamp).insert(PointLight::default());
    expect(&mut game, "lamp", 2, &["intensity is -1"]);
    assert_eq!(standing(&mut game), 0, "repaired");
}

#[test]
fn techniques_that_do_not_fit_are_logged_with_what_to_use() {
    let (mut game, _) = game("fit");
    let world = game.world();
    let sun = light_at(world, "sun", (DirectionalLight::default(), OmniMap::default()));
    light_at(world, "panel", (RectLight::default(), ShadowMap::default()));
    light_at(world, "bulb", (PointLight::default(), ShadowMap::default()));
    let wedge = PenumbraWedge::default();
    let candle = light_at(world, "candle", (PointLight::default(), wedge));
    let stray = light_at(world, "stray", StencilVolume::default());
    let both = (StencilVolume::default(), OmniMap::default());
    let twin = light_at(world, "twin", (PointLight::default(), both));
    let soft = MapFilter::Soft4 { softness: f32::NAN };
    let filter = ShadowMap {
        filter: soft,
        ..default()
    };
    light_at(world, "filter", (SpotLight::default(), filter));
    let said: [(&str, &[&str]); 7] = [
        ("sun", &["OmniMap does not fit", "use ShadowMap"]),
        ("panel", &["ShadowMap does not fit a rectangle", "use OmniMap"]),
        ("bulb", &["ShadowMap does not fit", "use OmniMap"]),
        ("candle", &["no size", "radius", "StencilVolume"]),
        ("stray", &["no light", "PointLight"]),
        ("twin", &["StencilVolume and OmniMap", "Remove"]),
        ("filter", &["softness is NaN"]),
    ];
    for (name, text) in said {
        expect(&mut game, name, 1, text);
    }
    assert_eq!(standing(&mut game), said.len());
    // What is repaired is not wrong any more; what is wrong again, or in another way, is said again.
    let world = game.world();
    world
        .entity_mut(sun)
        .remove::<OmniMap>()
        .insert(PenumbraWedge::default());
    world.get_mut::<PointLight>(candle).unwrap().radius = 0.3;
    world.entity_mut(stray).insert(PointLight::default());
    world.entity_mut(twin).remove::<StencilVolume>();
    expect(&mut game, "sun", 2, &["penumbra_wedge", "hard shadow"]);
    assert_eq!(standing(&mut game), 4, "sun, panel, bulb and filter");
    game.world().entity_mut(stray).remove::<PointLight>();
    expect(&mut game, "stray", 2, &["no light"]);
    game.world().despawn(stray);
    game.run(3);
    assert_eq!(standing(&mut game), 4);
}

#[test]
fn objects_and_meshes_that_cast_nothing_are_logged() {
    let (mut game, _) = game("cast");
    let world = game.world();
    let flat = Transform::from_scale(Vec3::new(1.0, 0.0, 0.0));
    let board = harness::add_mesh(world, Cuboid::default(), flat);
    world.entity_mut(board).insert(Name::new("board"));
    let lines = |count: usize| {
        let points = vec![[0.0f32, 0.5, 0.0]; count];
        let normals = vec![[0.0f32, 0.0, 1.0]; count];
        Mesh::new(PrimitiveTopology::LineStrip, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    };
    let wire = harness::add_mesh(world, lines(4), Transform::default());
    world.entity_mut(wire).insert(Name::new("wire"));
    expect(&mut game, "board", 1, &["object:", "flattens it", "scale"]);
    expect(&mut game, "wire", 1, &["mesh:", "LineStrip", "NotShadowCaster"]);
    let world = game.world();
    *world.get_mut::<Transform>(board).unwrap() = Transform::default();
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::default());
    world.entity_mut(wire).insert(Mesh3d(cube));
    game.run(4);
    assert_eq!(standing(&mut game), 0, "repaired");
    game.world().get_mut::<Transform>(board).unwrap().scale = Vec3::X;
    expect(&mut game, "board", 2, &["flattens it"]);
}

/// A perspective that shears the picture.
#[derive(Clone, Debug)]
struct Sheared(PerspectiveProjection);

impl CameraProjection for Sheared {
    fn get_clip_from_view(&self) -> Mat4 {
        let mut matrix = self.0.get_clip_from_view();
        matrix.x_axis.y = 0.1;
        matrix
    }
    fn get_clip_from_view_for_sub(&self, view: &SubCameraView) -> Mat4 {
        self.0.get_clip_from_view_for_sub(view)
    }
    fn update(&mut self, width: f32, height: f32) {
        self.0.update(width, height);
    }
    fn far(&self) -> f32 {
        self.0.far
    }
    fn get_frustum_corners(&self, near: f32, far: f32) -> [Vec3A; 8] {
        self.0.get_frustum_corners(near, far)
    }
}

#[test]
fn views_that_show_no_shadows_are_logged() {
    let (mut game, cameras) = game("view");
    let sheared = Projection::custom(Sheared(PerspectiveProjection::default()));
    game.world().entity_mut(cameras[0]).insert(sheared);
    let text = ["renderer:", "neither perspective nor", "OrthographicProjection"];
    expect(&mut game, "view 0", 1, &text);
    let whole = Projection::default();
    game.world().entity_mut(cameras[0]).insert(whole);
    game.run(3);
    assert_eq!(standing(&mut game), 0);
    assert_eq!(lines("view 1"), Vec::<String>::new());

    // Of one camera.
    let overflow = |game: &mut Game, pixels: u32| {
        let mirrors = game.render_world().resource::<Mirrors>();
        let mirror = mirrors.get(cameras[1]).unwrap();
        mirror.world.resource::<WedgeOverflow>().set(pixels);
    };
    overflow(&mut game, 12);
    let text = ["penumbra_wedge:", "12 pixels", "VisibilityBuffer::Float"];
    expect(&mut game, "view 1", 1, &text);
    overflow(&mut game, 0);
    game.run(2);
    assert_eq!(standing(&mut game), 0);

    // Of all, and of nobody.
    game.spoil();
    for camera in cameras {
        let mirrors = game.render_world().resource::<Mirrors>();
        let world = &mirrors.get(camera).unwrap().world;
        world.resource::<Renderer>().context().set_lost();
    }
    game.run(8);
    let lost = warnings("the GPU device was lost");
    assert_eq!(lost.len(), 1, "{lost:?}");
    assert_eq!(standing(&mut game), 1);
}

#[test]
fn maps_that_are_short_of_memory_are_logged() {
    let (mut game, _) = game("short");
    let map = ShadowMap {
        resolution: MapResolution::Fixed(256),
        ..default()
    };
    light_at(game.world(), "mapped", (SpotLight::default(), map));
    game.run(2);
    assert_eq!(lines("mapped"), Vec::<String>::new());
    let limit = |game: &mut Game, bytes: u64| {
        game.world().resource_mut::<AntumbraSettings>().texture_memory = bytes;
    };
    limit(&mut game, 0);
    expect(
        &mut game,
        "mapped",
        1,
        &[
            "texture_memory:",
            "shadow_map",
            "not kept",
            "TextureMemory::limit",
        ],
    );
    limit(&mut game, 200_000);
    expect(
        &mut game,
        "mapped",
        2,
        &["memory for textures is short", "became"],
    );
    limit(&mut game, 1 << 28);
    game.run(3);
    assert_eq!(standing(&mut game), 0);
}

#[test]
fn a_camera_that_sees_other_layers_says_nothing_twice() {
    let (mut game, cameras) = game("layers");
    let dark = PointLight {
        range: 0.0,
        ..default()
    };
    light_at(game.world(), "dim", (dark, StencilVolume::default()));
    expect(&mut game, "dim", 1, &["range is 0 m"]);
    for camera in cameras {
        let layers = bevy::camera::visibility::RenderLayers::from_layers(&[0, 3]);
        game.world().entity_mut(camera).insert(layers);
    }
    expect(&mut game, "dim", 1, &["range is 0 m"]);
}
