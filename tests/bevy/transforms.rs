//! Transforms with a scale of 0, skins on entities of scale 0, and cones whose angles are equal.

use antumbra::bevy_adapter::prelude::*;
use antumbra::reports::Reports;
use bevy::camera::visibility::NoFrustumCulling;
use bevy::light::NotShadowCaster;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::harness::{self, Game, Picture};

/// A floor under a sharp cone, and a camera.
fn room() -> (Game, Entity) {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 5.0));
    let floor = Plane3d::default().mesh().size(12.0, 12.0);
    harness::add_mesh(world, floor, Transform::default());
    let cone = SpotLight {
        intensity: 2_000_000.0,
        inner_angle: 0.5,
        outer_angle: 0.5,
        ..default()
    };
    let place = Transform::from_xyz(1.0, 5.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
    world.spawn((cone, StencilVolume::default(), place));
    (game, camera)
}

/// Pixels that are darker than in another picture.
fn darker(picture: &Picture, than: &Picture) -> usize {
    let pairs = picture.texels.iter().zip(&than.texels);
    pairs
        .filter(|(a, b)| f32::from(a[1]) < 0.5 * f32::from(b[1]))
        .count()
}

fn skinned(world: &mut World, scale: Vec3) -> Entity {
    let mut mesh = Mesh::from(Cuboid::from_length(1.0));
    let vertices = mesh.count_vertices();
    let joints = VertexAttributeValues::Uint16x4(vec![[0; 4]; vertices]);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_WEIGHT,
        vec![[1.0f32, 0.0, 0.0, 0.0]; vertices],
    );
    let joint = world.spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
    let mut binds = world.resource_mut::<Assets<SkinnedMeshInverseBindposes>>();
    let inverse_bindposes = binds.add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY]));
    let skin = SkinnedMesh {
        inverse_bindposes,
        joints: vec![joint],
    };
    let object = harness::add_mesh(world, mesh, Transform::from_scale(scale));
    world.entity_mut(object).insert((skin, NoFrustumCulling));
    object
}

#[test]
fn scales_of_zero_cast_what_bevy_draws() {
    let (mut game, camera) = room();
    let empty = game.run(3).settled(camera);
    let lit = empty
        .texels
        .iter()
        .filter(|texel| texel[1] > half::f16::ZERO)
        .count();
    assert!(lit > 1000, "the sharp cone lights {lit} pixels");

    // A cube that is flattened is a plate, and casts as one.
    let at = |scale: Vec3| Transform::from_xyz(0.0, 1.0, 0.0).with_scale(scale);
    let cube = harness::add_mesh(game.world(), Cuboid::from_length(1.0), at(Vec3::ONE));
    let mut scaled = |scale: Vec3, casts: bool| {
        *game.world().get_mut::<Transform>(cube).unwrap() = at(scale);
        if casts {
            game.world().entity_mut(cube).remove::<NotShadowCaster>();
        } else {
            game.world().entity_mut(cube).insert(NotShadowCaster);
        }
        let picture = game.run(2).settled(camera);
        assert_eq!(game.world().resource::<Reports>().iter().count(), 0, "{scale}");
        picture
    };
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        // Bevy shades what it flattens with normals of its own, so each is compared with itself.
        let mut shadow = |scale| darker(&scaled(scale, true), &scaled(scale, false));
        let (of_flat, of_thin) = (shadow(Vec3::ONE - axis), shadow(Vec3::ONE - axis * 0.999));
        assert!(
            of_flat > 20 && of_flat.abs_diff(of_thin) < 10,
            "{axis}: {of_flat}, {of_thin}"
        );
    }
    let none = scaled(Vec3::ZERO, true);
    assert_eq!(none.difference(&empty).channels, 0);

    // Joints alone place a skinned mesh, so its own scale changes nothing.
    let mut skinned = |scale: Vec3| {
        let object = skinned(game.world(), scale);
        let picture = game.run(3).settled(camera);
        game.world().despawn(object);
        assert_eq!(game.world().resource::<Reports>().iter().count(), 0, "{scale}");
        picture
    };
    let whole = skinned(Vec3::ONE);
    whole.save("skinned");
    assert!(darker(&whole, &empty) > 200);
    for scale in [Vec3::ZERO, Vec3::new(0.0, 1.0, 1.0), Vec3::new(-1.0, 1.0, 1.0)] {
        let picture = skinned(scale);
        picture.save("skinned_scaled");
        assert_eq!(picture.difference(&whole).channels, 0, "{scale}");
    }
}

#[test]
fn rectangles_cast_with_the_size_that_bevy_shades() {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 5.0));
    let floor = Plane3d::default().mesh().size(12.0, 12.0);
    harness::add_mesh(world, floor, Transform::default());
    harness::add_mesh(
        world,
        Cuboid::from_length(0.8),
        Transform::from_xyz(0.0, 0.9, 0.0),
    );
    let panel = |width: f32, height: f32| RectLight {
        width,
        height,
        intensity: 800_000.0,
        ..default()
    };
    let place = Transform::from_xyz(1.0, 4.0, 1.0).looking_at(Vec3::ZERO, Vec3::X);
    let light = world
        .spawn((panel(1.5, 0.5), PenumbraWedge::default(), place))
        .id();
    let sized = game.run(3).settled(camera);
    game.world().entity_mut(light).insert(panel(0.5, 0.25));
    let small = game.run(2).settled(camera);
    // The scale alone changes, of the light or of its parent.
    let scale = Vec3::new(3.0, 2.0, 5.0);
    game.world().get_mut::<Transform>(light).unwrap().scale = scale;
    let scaled = game.run(2).settled(camera);
    scaled.save("rectangle");
    // The lengths of the scaled axes are rounded.
    let difference = scaled.difference(&sized);
    assert!(difference.channels < 20 && difference.steps < 3, "{difference:?}");
    assert!(sized.difference(&small).channels > 500, "the size is not seen");
    game.world().get_mut::<Transform>(light).unwrap().scale = Vec3::ONE;
    assert_eq!(game.run(2).settled(camera).difference(&small).channels, 0);
}

/// Whatever mirrors or shears a panel, it lights what Bevy lights, and shadows it.
#[test]
fn rectangles_shine_to_the_side_that_bevy_lights() {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 5.0));
    let floor = Plane3d::default().mesh().size(12.0, 12.0);
    harness::add_mesh(world, floor, Transform::default());
    let cube = Cuboid::from_length(0.8);
    let cube = harness::add_mesh(world, cube, Transform::from_xyz(0.0, 0.9, 0.0));
    let above = Transform::from_xyz(0.0, 4.0, 0.0);
    let parent = world.spawn((above, Visibility::default())).id();
    let panel = RectLight {
        intensity: 800_000.0,
        ..default()
    };
    let light = world.spawn((panel, ChildOf(parent))).id();
    let none = Transform::IDENTITY;
    let [down, up] = [-1.0, 1.0].map(|side| Quat::from_rotation_x(side * std::f32::consts::FRAC_PI_2));
    let oblique = Transform::from_rotation(Quat::from_rotation_y(0.8));
    let cases = [
        (
            "X is mirrored",
            above,
            none.with_rotation(up).with_scale(Vec3::new(-1.0, 1.0, 1.0)),
        ),
        (
            "Z is mirrored",
            above,
            none.with_rotation(down).with_scale(Vec3::new(1.0, 1.0, -1.0)),
        ),
        (
            "the parent is mirrored",
            above.with_scale(Vec3::new(-1.0, 1.0, 1.0)),
            none.with_rotation(up),
        ),
        (
            "it is sheared",
            above.with_rotation(down).with_scale(Vec3::new(2.0, 1.0, 1.0)),
            oblique,
        ),
        (
            "both",
            above.with_rotation(up).with_scale(Vec3::new(-2.0, 1.0, 1.0)),
            oblique,
        ),
        ("neither", above, none.with_rotation(down)),
    ];
    for (case, of_parent, of_light) in cases {
        let world = game.world();
        world.entity_mut(parent).insert(of_parent);
        world.entity_mut(light).insert(of_light).remove::<PenumbraWedge>();
        let bevys = game.run(3).settled(camera);
        bevys.save(case);
        let lit = bevys
            .texels
            .iter()
            .filter(|texel| texel[1] > half::f16::ZERO)
            .count();
        assert!(lit > 1000, "{case}: Bevy lights {lit} pixels");
        let world = game.world();
        world.entity_mut(cube).insert(NotShadowCaster);
        world.entity_mut(light).insert(PenumbraWedge::default());
        let ours = game.run(3).settled(camera);
        let difference = ours.difference(&bevys);
        assert!(difference.steps < 3, "{case}, nothing casts: {difference:?}");
        game.world().entity_mut(cube).remove::<NotShadowCaster>();
        let shadow = darker(&game.run(3).settled(camera), &ours);
        assert!(shadow > 20, "{case}: a shadow of {shadow} pixels");
    }
}

/// Two panels at one place that shine to opposite sides, as a panel that shines to both sides is made.
#[test]
fn panels_at_one_place_are_told_apart() {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 0.5, 6.0));
    for side in [-1.0, 1.0] {
        let wall = Cuboid::new(0.1, 4.0, 4.0);
        harness::add_mesh(world, wall, Transform::from_xyz(2.0 * side, 0.0, 0.0));
    }
    let panel = RectLight {
        intensity: 400_000.0,
        ..default()
    };
    let place = |towards: Vec3| Transform::default().looking_to(towards, Vec3::Y);
    let lights = [Vec3::X, Vec3::NEG_X].map(|towards| {
        world
            .spawn((panel, PenumbraWedge::default(), place(towards)))
            .id()
    });
    let both = game.run(3).settled(camera);
    // Without techniques, Bevy draws the panels.
    for light in lights {
        game.world().entity_mut(light).remove::<PenumbraWedge>();
    }
    let bevys = game.run(3).settled(camera);
    let difference = both.difference(&bevys);
    assert!(difference.steps < 3, "nothing casts: {difference:?}");
    // One of them is left to Bevy.
    game.world()
        .entity_mut(lights[1])
        .insert(PenumbraWedge::default());
    let one = game.run(3).settled(camera);
    let difference = one.difference(&bevys);
    assert!(difference.steps < 3, "{difference:?}");
    game.world().despawn(lights[0]);
    let left = game.run(3).settled(camera);
    assert!(left.difference(&bevys).channels > 500, "one side is dark");
}
