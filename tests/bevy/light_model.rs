//! The light model on Bevy's lights: shapes, weights, the colour of shadows, and who shows them.

use antumbra::bevy_adapter::prelude::*;
use bevy::camera::visibility::RenderLayers;
use bevy::prelude::*;

use crate::harness::{self, Game, Picture};

/// A floor and a box over it under one light, both on layers of their own, seen from above at a slant.
pub struct Lit {
    pub game: Game,
    pub camera: Entity,
    pub light: Entity,
    cube: Entity,
}

pub const LIGHT: Vec3 = Vec3::new(1.0, 3.0, 0.5);

pub fn lit(ambient: bool) -> Lit {
    let mut game = if ambient {
        harness::game()
    } else {
        harness::dark_game()
    };
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.5, 4.5));
    let layers = RenderLayers::from_layers(&[0, 1, 2]);
    world.entity_mut(camera).insert(layers.clone());
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    let floor = harness::add_mesh(world, floor, Transform::default());
    let cube = harness::add_mesh(
        world,
        Cuboid::new(0.8, 0.8, 0.8),
        Transform::from_xyz(0.0, 0.8, 0.0),
    );
    world.entity_mut(floor).insert(RenderLayers::layer(1));
    world.entity_mut(cube).insert(RenderLayers::layer(2));
    let light = PointLight {
        intensity: 300_000.0,
        color: Color::linear_rgb(1.0, 0.5, 0.25),
        ..default()
    };
    let place = Transform::from_translation(LIGHT).looking_at(Vec3::new(0.0, 0.0, 0.2), Vec3::Z);
    let light = world.spawn((light, StencilVolume::default(), place, layers)).id();
    Lit {
        game,
        camera,
        light,
        cube,
    }
}

impl Lit {
    pub fn with(&mut self, parts: impl Bundle) -> Picture {
        self.game.world().entity_mut(self.light).insert(parts);
        self.game.run(4).settled(self.camera)
    }
}

/// Red, green and blue of each pixel.
pub fn texels(picture: &Picture) -> impl Iterator<Item = [f32; 3]> + '_ {
    picture.texels.iter().map(|texel| texel.map(f32::from))
}

#[test]
fn components_at_their_defaults_change_no_channel() {
    let mut lit = lit(true);
    let (camera, light) = (lit.camera, lit.light);
    let without = lit.game.run(5).settled(camera);
    let with = lit.with((
        LightShape::default(),
        LightDistance::default(),
        LightWeights::default(),
        ShadowTint::default(),
        LightSelection::default(),
    ));
    assert_eq!(with.difference(&without).channels, 0);
    lit.game.world().entity_mut(light).insert(LightShape {
        width: 0.2,
        ..default()
    });
    let shaped = lit.game.run(4).settled(camera);
    assert!(shaped.difference(&without).channels > 1000, "a shape is seen");
    lit.game.world().entity_mut(light).remove::<LightShape>();
    let back = lit.game.run(4).settled(camera);
    assert_eq!(
        back.difference(&without).channels,
        0,
        "and is gone with its component"
    );
}

#[test]
fn a_shape_scales_what_bevy_gives_with_a_technique_and_without() {
    let mut lit = lit(false);
    let (camera, light) = (lit.camera, lit.light);
    let shape = LightShape {
        width: 0.25,
        height: 0.4,
        width_edge: 0.3,
        round: 0.5,
        ..default()
    };
    for technique in [true, false] {
        if !technique {
            lit.game.world().entity_mut(light).remove::<StencilVolume>();
            // A light whose model shapes nothing is still ours, and unshadowed.
            lit.game.world().entity_mut(light).insert(LightShape::default());
        }
        lit.game.world().entity_mut(light).remove::<LightShape>();
        lit.game.world().entity_mut(light).insert(LightShape::default());
        let whole = lit.game.run(5).settled(camera);
        let shaped = lit.with(shape);
        let (mut lit_count, mut dark, mut edge) = (0, 0, 0);
        for ([whole, ..], [got, ..]) in texels(&whole).zip(texels(&shaped)) {
            assert!(got <= whole * 1.001 + 1e-6, "{got} of {whole}");
            if whole > 0.01 {
                lit_count += usize::from(got > 0.999 * whole);
                dark += usize::from(got == 0.0);
                edge += usize::from(got > 0.05 * whole && got < 0.95 * whole);
            }
        }
        assert!(
            lit_count > 100 && dark > 100 && edge > 50,
            "technique {technique}: {lit_count} lit, {dark} dark, {edge} on the edge"
        );
    }
}

#[test]
fn weights_and_shadow_colours_hold_in_bevy() {
    let mut lit = lit(false);
    let (camera, light) = (lit.camera, lit.light);
    let shadowed = lit.game.run(5).settled(camera);
    let weights = |ambient, diffuse, specular| LightWeights {
        ambient,
        diffuse,
        specular,
    };
    let diffuse = lit.with(weights(0.0, 1.0, 0.0));
    let specular = lit.with(weights(0.0, 0.0, 1.0));
    for ((whole, diffuse), specular) in texels(&shadowed).zip(texels(&diffuse)).zip(texels(&specular)) {
        for i in 0..3 {
            let sum = diffuse[i] + specular[i];
            assert!(
                (sum - whole[i]).abs() <= 3e-3 * whole[i] + 1e-5,
                "{sum}, not {}",
                whole[i]
            );
        }
    }
    // The same light without a shadow, to tell what the shadow takes away.
    lit.game.world().entity_mut(light).remove::<StencilVolume>();
    let unshadowed = lit.with(weights(0.0, 1.0, 0.0));
    let tint = ShadowTint {
        color: Vec3::new(0.0, 0.1, 0.5),
        darkness: 0.75,
    };
    let tinted = lit.with((StencilVolume::default(), weights(0.0, 1.0, 0.0), tint));
    let (mut dark, mut bright) = (0, 0);
    let color = [1.0, 0.5, 0.25];
    for ((seen, open), tinted) in texels(&diffuse).zip(texels(&unshadowed)).zip(texels(&tinted)) {
        if open[0] < 0.01 {
            continue;
        }
        let visible = f32::from(u8::from(seen[0] > 0.5 * open[0]));
        for i in 0..3 {
            let passing = 1.0 - 0.75 * (1.0 - visible);
            let mixed = tint.color[i] + (color[i] - tint.color[i]) * passing;
            let expected = open[i] / color[i] * mixed;
            assert!(
                (tinted[i] - expected).abs() <= 5e-3 * open[i] / color[i],
                "{}, not {expected}: {open:?}, visible {visible}",
                tinted[i]
            );
        }
        dark += usize::from(visible == 0.0);
        bright += usize::from(visible == 1.0);
    }
    assert!(dark > 50 && bright > 500, "{dark} dark, {bright} bright");
    // Ambient light fills the shadow too.
    let filled = lit.with((ShadowTint::default(), weights(1.0, 0.0, 0.0)));
    let empty = texels(&filled)
        .zip(texels(&unshadowed))
        .filter(|(filled, open)| open[0] > 0.01 && filled[0] <= 0.0);
    assert_eq!(empty.count(), 0, "ambient light has no shadow");
}

#[test]
fn weights_of_objects_hold_in_bevy() {
    let mut lit = lit(false);
    let (camera, cube) = (lit.camera, lit.cube);
    let whole = lit.game.run(5).settled(camera);
    let weights = |ambient, diffuse, specular| SurfaceWeights {
        ambient,
        diffuse,
        specular,
    };
    let of_light = |diffuse, specular| LightWeights {
        ambient: 0.0,
        diffuse,
        specular,
    };
    let diffuse = lit.with(of_light(1.0, 0.0));
    let specular = lit.with(of_light(0.0, 1.0));
    lit.with(LightWeights::default());
    let mut weigh = |weights: Option<SurfaceWeights>| {
        let mut cube = lit.game.world().entity_mut(cube);
        match weights {
            Some(weights) => cube.insert(weights),
            None => cube.remove::<SurfaceWeights>(),
        };
        lit.game.run(4).settled(camera)
    };
    let without_cube = weigh(Some(weights(0.0, 0.0, 0.0)));
    let weighted = weigh(Some(weights(1.0, 0.25, 3.0)));
    let pictures = texels(&diffuse).zip(texels(&specular)).zip(texels(&without_cube));
    let (mut on_cube, mut elsewhere) = (0, 0);
    for (((d, s), none), (whole, got)) in pictures.zip(texels(&whole).zip(texels(&weighted))) {
        for i in 0..3 {
            // A cube that weights all light with 0 is black.
            let is_cube = none[i] == 0.0 && whole[i] > 0.0;
            let expected = if is_cube {
                0.25 * d[i] + 3.0 * s[i]
            } else {
                whole[i]
            };
            let allowed = 4e-3 * (whole[i] + 3.0 * s[i]) + 1e-5;
            assert!(
                (got[i] - expected).abs() <= allowed,
                "{}, not {expected}, cube {is_cube}",
                got[i]
            );
            on_cube += usize::from(is_cube);
            elsewhere += usize::from(!is_cube && whole[i] > 0.01);
        }
    }
    assert!(
        on_cube > 200 && elsewhere > 2000,
        "{on_cube} on the cube, {elsewhere} elsewhere"
    );
    // Weights may go again, and defaults are none.
    assert_eq!(weigh(None).difference(&whole).channels, 0);
    assert_eq!(
        weigh(Some(SurfaceWeights::default())).difference(&whole).channels,
        0
    );
}

#[test]
fn who_shows_the_shadow_is_chosen_for_each_light_and_technique() {
    let mut lit = lit(false);
    let (camera, light) = (lit.camera, lit.light);
    // A model that shapes nothing makes the light ours without a technique.
    let open = {
        lit.game.world().entity_mut(light).remove::<StencilVolume>();
        lit.with(LightShape::default())
    };
    let select = |affects, casts_for, shows_on| LightSelection {
        affects,
        casts_for,
        shows_on,
    };
    let mut check =
        |name: &str, insert: &dyn Fn(&mut EntityWorldMut), remove: &dyn Fn(&mut EntityWorldMut)| {
            let mut entity = lit.game.world().entity_mut(light);
            entity.insert(LightSelection::default());
            insert(&mut entity);
            let shadowed = lit.game.run(5).settled(camera);
            let is_shadowed = name != "none";
            assert_eq!(shadowed.difference(&open).absolute > 0.05, is_shadowed, "{name}");
            // Nobody shows the shadow, and nobody casts: both are as without a technique.
            for (what, selection) in [("shows", select(!0, !0, 0)), ("casts", select(!0, 0, !0))] {
                let picture = lit.with(selection);
                let apart = picture.difference(&open);
                assert!(apart.steps <= 1, "{name}, nobody {what}: {apart:?}");
            }
            // The floor alone shows it, the floor alone is lit.
            let on_floor = lit.with(select(!0, !0, 0b010));
            assert_eq!(
                on_floor.difference(&open).absolute > 0.05,
                is_shadowed,
                "{name}: shown on the floor"
            );
            let on_cube = lit.with(select(!0, 0b010, !0));
            let apart = on_cube.difference(&open);
            assert!(
                apart.absolute < 0.01,
                "{name}: the floor casts on nothing: {apart:?}"
            );
            let floor = lit.with(select(0b010, !0, 0));
            let cube = lit.with(select(0b100, !0, 0));
            for ((open, floor), cube) in texels(&open).zip(texels(&floor)).zip(texels(&cube)) {
                assert!(floor[0] == 0.0 || cube[0] == 0.0, "{name}: both lit");
                let sum = floor[0] + cube[0];
                assert!(
                    (sum - open[0]).abs() <= 2e-3 * open[0],
                    "{name}: {sum} of {}",
                    open[0]
                );
            }
            remove(&mut lit.game.world().entity_mut(light));
        };
    check("none", &|_| {}, &|_| {});
    check(
        "volume",
        &|light| {
            light.insert(StencilVolume::default());
        },
        &|light| {
            light.remove::<StencilVolume>();
        },
    );
    check(
        "wedge",
        &|light| {
            light.insert(PenumbraWedge::default());
        },
        &|light| {
            light.remove::<PenumbraWedge>();
        },
    );
    check(
        "map",
        &|light| {
            light.insert(OmniMap::default());
        },
        &|light| {
            light.remove::<OmniMap>();
        },
    );
}
