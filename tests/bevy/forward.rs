//! Opaque meshes that stay forward show our shadows, and where a light is seen wholly they look as Bevy draws them, to
//! the bit.

use antumbra::bevy_adapter::prelude::*;
use antumbra::reports::Reports;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::material::OpaqueRendererMethod;
use bevy::pbr::{DistanceFog, ExtendedMaterial, FogFalloff};
use bevy::prelude::*;

use crate::harness::{self, Game, Picture};
use crate::stripes::{self, ForwardStripes};

const EYE: Vec3 = Vec3::new(0.0, 3.0, 6.0);

/// One light of each kind, and one that is left to Bevy.
fn add_lights(world: &mut World) {
    let at = |x: f32| Transform::from_xyz(x, 4.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y);
    let point = PointLight {
        intensity: 300_000.0,
        ..default()
    };
    let ball = PointLight {
        radius: 0.3,
        intensity: 200_000.0,
        ..default()
    };
    let spot = SpotLight {
        intensity: 600_000.0,
        outer_angle: 0.7,
        ..default()
    };
    let sun = DirectionalLight {
        illuminance: 1000.0,
        ..default()
    };
    let panel = RectLight {
        intensity: 200_000.0,
        ..default()
    };
    world.spawn((point, StencilVolume::default(), at(1.0)));
    world.spawn((ball, PenumbraWedge::default(), at(-2.0)));
    world.spawn((spot, ShadowMap::default(), at(2.0)));
    world.spawn((sun, StencilVolume::default(), at(-1.0)));
    world.spawn((panel, PenumbraWedge::default(), at(0.0)));
    world.spawn((point, at(3.0)));
}

fn forward(world: &mut World) -> MeshMaterial3d<StandardMaterial> {
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    MeshMaterial3d(materials.add(StandardMaterial {
        opaque_render_method: OpaqueRendererMethod::Forward,
        perceptual_roughness: 0.4,
        ..default()
    }))
}

fn fog() -> DistanceFog {
    DistanceFog {
        color: Color::srgb(0.2, 0.3, 0.4),
        falloff: FogFalloff::Exponential { density: 0.05 },
        ..default()
    }
}

#[test]
fn without_casters_forward_meshes_are_bevys_to_the_bit() {
    let draw = |mut app: App, marked: bool| {
        stripes::add(&mut app);
        let world = app.world_mut();
        let camera = harness::marked_camera(world, EYE);
        world.entity_mut(camera).insert(fog());
        if !marked {
            world.entity_mut(camera).remove::<AntumbraCamera>();
        }
        let material = forward(world);
        let floor = harness::add_mesh(
            world,
            Plane3d::default().mesh().size(6.0, 6.0),
            Transform::default(),
        );
        world.entity_mut(floor).insert((material, NotShadowCaster));
        let striped = world
            .resource_mut::<Assets<ExtendedMaterial<StandardMaterial, ForwardStripes>>>()
            .add(stripes::forward());
        let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(1.0));
        let place = Transform::from_xyz(0.0, 0.5, 0.0);
        world.spawn((Mesh3d(cube), MeshMaterial3d(striped), place, NotShadowCaster));
        add_lights(world);
        let mut game = Game::start(app);
        (game.run(6).settled(camera), game, camera)
    };
    let (bevys, ..) = draw(harness::headless(), false);
    let (ours, mut game, camera) = draw(harness::antumbra(), true);
    ours.save("forward_lit");
    assert_eq!(ours.difference(&bevys).channels, 0);
    // What is compared is read from masks: with casters it differs.
    let world = game.world();
    let mut casters = world.query_filtered::<Entity, With<NotShadowCaster>>();
    let casters: Vec<Entity> = casters.iter(world).collect();
    for caster in casters {
        world.entity_mut(caster).remove::<NotShadowCaster>();
    }
    let shadowed = game.run(3).settled(camera);
    shadowed.save("forward_shadowed");
    let shadow = shadowed.difference(&bevys).channels;
    assert!(shadow > 100, "{shadow} channels");
    // There is room for the masks of 16 lights.
    let standing = |game: &mut Game| {
        game.world()
            .resource::<Reports>()
            .iter()
            .cloned()
            .collect::<Vec<_>>()
    };
    assert!(standing(&mut game).is_empty(), "{:?}", standing(&mut game));
    for _ in 0..12 {
        harness::add_light(game.world());
    }
    game.run(4);
    let reports = standing(&mut game);
    assert!(
        reports.len() == 1 && reports[0].message.contains("16 lights"),
        "{reports:?}"
    );
}

/// Visibility that two pictures show.
fn visibility(shadowed: &Picture, lit: &Picture) -> Vec<f32> {
    let pairs = shadowed.texels.iter().zip(&lit.texels);
    pairs.map(|(a, b)| f32::from(a[1]) / f32::from(b[1])).collect()
}

#[test]
fn forward_and_deferred_meshes_show_the_same_shadows() {
    let mut game = harness::dark_game();
    let mut of_technique = |technique: fn(&mut EntityWorldMut)| {
        let world = game.clear().world();
        let camera = harness::marked_camera(world, EYE);
        let material = forward(world);
        let plane = || Plane3d::default().mesh().size(6.0, 6.0);
        let forward = harness::add_mesh(world, plane(), Transform::default());
        world.entity_mut(forward).insert(material);
        let deferred = harness::add_mesh(world, plane(), Transform::default());
        let cube = harness::add_mesh(
            world,
            Cuboid::from_length(1.0),
            Transform::from_xyz(0.0, 0.9, 0.0),
        );
        let light = PointLight {
            intensity: 500_000.0,
            radius: 0.2,
            ..default()
        };
        technique(&mut world.spawn((light, Transform::from_xyz(1.0, 4.0, 1.0))));
        game.run(4);
        let mut seen = |floor: Entity, hidden: Entity| {
            game.world().entity_mut(floor).insert(Visibility::Inherited);
            game.world().entity_mut(hidden).insert(Visibility::Hidden);
            game.world().entity_mut(cube).remove::<NotShadowCaster>();
            let shadowed = game.run(4).settled(camera);
            game.world().entity_mut(cube).insert(NotShadowCaster);
            let lit = game.run(3).settled(camera);
            shadowed.save("forward");
            visibility(&shadowed, &lit)
        };
        let of_deferred = seen(deferred, forward);
        let of_forward = seen(forward, deferred);
        // What receives no shadows is lit, also when that changes.
        game.world().entity_mut(forward).insert(NotShadowReceiver);
        let lit = game.run(3).settled(camera);
        game.world().entity_mut(cube).remove::<NotShadowCaster>();
        let receives_none = game.run(3).settled(camera);
        let on_floor = |i: usize| i / lit.size.x as usize > 44; // below the cube in the picture
        let pairs = lit.texels.iter().zip(&receives_none.texels).enumerate();
        let darker = pairs.filter(|&(i, (a, b))| on_floor(i) && a != b).count();
        assert_eq!(darker, 0);
        (of_deferred, of_forward)
    };
    let techniques: [fn(&mut EntityWorldMut); 2] = [
        |light| {
            light.insert(StencilVolume::default());
        },
        |light| {
            light.insert(PenumbraWedge::default());
        },
    ];
    for technique in techniques {
        let (of_deferred, of_forward) = of_technique(technique);
        let pairs = of_deferred.iter().zip(&of_forward);
        let told = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
        let (mut unlike, mut dark, mut all) = (0, 0, 0);
        for (a, b) in told {
            unlike += usize::from((a - b).abs() > 0.01);
            dark += usize::from(*b < 0.05);
            all += 1;
        }
        assert!(all > 2000 && dark > 50, "{dark} of {all} pixels are dark");
        assert_eq!(unlike, 0, "of {all}");
    }
}

/// What forward and deferred floors show of a light with a model, below a cube that casts.
fn modelled(game: &mut Game, parts: impl Bundle) -> [Picture; 2] {
    let world = game.clear().world();
    let camera = harness::marked_camera(world, EYE);
    let mut matte = StandardMaterial {
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..default()
    };
    let floors = [OpaqueRendererMethod::Forward, OpaqueRendererMethod::Deferred].map(|method| {
        matte.opaque_render_method = method;
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(matte.clone());
        let floor = harness::add_mesh(
            world,
            Plane3d::default().mesh().size(6.0, 6.0),
            Transform::default(),
        );
        world
            .entity_mut(floor)
            .insert((MeshMaterial3d(material), Visibility::Hidden));
        floor
    });
    harness::add_mesh(
        world,
        Cuboid::from_length(1.0),
        Transform::from_xyz(0.0, 0.9, 0.0),
    );
    let spot = SpotLight {
        intensity: 600_000.0,
        color: Color::linear_rgb(1.0, 0.5, 0.25),
        outer_angle: 0.9,
        inner_angle: 0.7,
        ..default()
    };
    let at = Transform::from_xyz(1.0, 4.0, 1.0).looking_at(Vec3::ZERO, Vec3::Z);
    world.spawn((spot, at, StencilVolume::default(), parts));
    floors.map(|floor| {
        game.world().entity_mut(floor).insert(Visibility::Inherited);
        let picture = game.run(4).settled(camera);
        game.world().entity_mut(floor).insert(Visibility::Hidden);
        picture
    })
}

#[test]
fn forward_meshes_show_shape_cookie_and_tint_of_a_light() {
    let texels = vec![Vec3::new(1.0, 0.5, 0.25), Vec3::new(0.25, 1.0, 0.5)];
    let image = CookieImage::from_linear("two", 2, 1, texels).expect("a picture");
    let shape = LightShape {
        width: 0.3,
        height: 0.3,
        width_edge: 0.2,
        height_edge: 0.2,
        round: 0.5,
    };
    let tint = ShadowTint {
        color: Vec3::new(0.1, 0.1, 0.2),
        darkness: 0.7,
    };
    let model = (
        shape,
        Cookie {
            size: 0.5,
            ..Cookie::new(image)
        },
    );
    let mut game = harness::dark_game();
    let [plain, _] = modelled(&mut game, ());
    let check = |name: &str, [forward, deferred]: [Picture; 2]| {
        forward.save(name);
        let brightest = plain
            .texels
            .iter()
            .map(|texel| f32::from(texel[0]))
            .fold(0.0, f32::max);
        // Kept visibility has 256 steps.
        let apart = forward.difference(&deferred);
        assert!(
            apart.absolute < 0.01 * brightest,
            "{name}: {apart:?}, brightest {brightest}"
        );
        let changed = forward.difference(&plain).channels;
        assert!(
            changed > 2000,
            "{name}: {changed} channels are other than without"
        );
        forward
    };
    let shaped = check("forward_shaped", modelled(&mut game, model.clone()));
    let tinted = check("forward_tinted", modelled(&mut game, (model, tint)));
    // In the shadow, within the shape.
    let filled = shaped.texels.iter().zip(&tinted.texels);
    let filled = filled.filter(|(a, b)| f32::from(a[0]) == 0.0 && f32::from(b[0]) > 0.0);
    let count = filled.count();
    assert!(count > 50, "{count} pixels show light in the shadow");
}

#[test]
fn lights_that_light_nothing_leave_the_masks_to_others() {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, EYE);
    let material = forward(world);
    let floor = Plane3d::default().mesh().size(6.0, 6.0);
    let floor = harness::add_mesh(world, floor, Transform::default());
    world.entity_mut(floor).insert(material);
    let cube = Cuboid::from_length(1.0);
    let cube = harness::add_mesh(world, cube, Transform::from_xyz(0.0, 0.9, 0.0));
    let mut add = |affects: u32, at: Vec3| {
        let light = PointLight {
            intensity: 300_000.0,
            ..default()
        };
        let selection = LightSelection { affects, ..default() };
        let place = Transform::from_translation(at);
        world
            .spawn((light, StencilVolume::default(), selection, place))
            .id()
    };
    let idle: Vec<Entity> = (0..20)
        .map(|i| add(0, Vec3::new(0.2 * i as f32 - 2.0, 3.0, 1.0)))
        .collect();
    add(u32::MAX, Vec3::new(1.0, 4.0, 1.0));
    let among_idle = game.run(4).settled(camera);
    let reports = game
        .world()
        .resource::<Reports>()
        .iter()
        .filter(|report| report.message.contains("16 lights"));
    assert_eq!(reports.count(), 0);
    for light in idle {
        game.world().despawn(light);
    }
    let alone = game.run(3).settled(camera);
    assert_eq!(among_idle.difference(&alone).channels, 0);
    game.world().entity_mut(cube).insert(NotShadowCaster);
    let lit = game.run(3).settled(camera);
    let shadow = lit.difference(&alone).channels;
    assert!(shadow > 100, "{shadow} channels");
}

#[test]
fn masks_go_with_the_mirror_of_their_camera() {
    let mut game = harness::game();
    let world = game.world();
    let camera = harness::marked_camera(world, EYE);
    let material = forward(world);
    let cube = harness::add_mesh(world, Cuboid::from_length(1.0), Transform::default());
    world.entity_mut(cube).insert(material);
    harness::add_light(world);
    let groups = |game: &mut Game, frames: usize| {
        let world = game.run(frames).render_world();
        world
            .query::<&antumbra::insides::ForwardGroup>()
            .iter(world)
            .count()
    };
    assert_eq!(groups(&mut game, 4), 1);
    game.world().entity_mut(camera).remove::<AntumbraCamera>();
    assert_eq!(groups(&mut game, 3), 0, "the camera is not marked");
    game.world().entity_mut(camera).insert(AntumbraCamera);
    assert_eq!(groups(&mut game, 4), 1);
    let set_active = |game: &mut Game, is_active: bool| {
        let mut camera = game.world().get_mut::<Camera>(camera).expect("a camera");
        camera.is_active = is_active;
    };
    set_active(&mut game, false);
    assert_eq!(groups(&mut game, 130), 0, "the camera rests");
    set_active(&mut game, true);
    assert_eq!(groups(&mut game, 4), 1);
}
