//! What is exchanged, removed or despawned while frames run: the next frame is that of a scene made so from the start.

use super::*;

/// The entity with a mesh of this name.
fn object_named(stage: &mut Stage, name: &str) -> Entity {
    let mut query = stage.world.query::<(Entity, &SceneMesh)>();
    let mut objects = query.iter(&stage.world);
    let found = objects.find(|(_, mesh)| mesh.0.name == name);
    found.map(|(entity, _)| entity).expect("there is such an object")
}

fn the_box(stage: &mut Stage) -> Entity {
    object_named(stage, "cuboid")
}

/// Changes the box of a running scene, and of a scene before its first frame; both must look the same.
#[track_caller]
fn assert_same_as_from_the_start(context: &RenderContext, what: &str, change: impl Fn(&mut Stage, Entity)) {
    let mut running = box_on_plane(context);
    let before = render(&mut running);
    render(&mut running);
    let entity = the_box(&mut running);
    change(&mut running, entity);
    let after = render(&mut running);
    let again = render(&mut running);

    let mut fresh = box_on_plane(context);
    let entity = the_box(&mut fresh);
    change(&mut fresh, entity);
    let expected = render(&mut fresh);
    assert!(!same(&before, &expected), "{what} shows");
    assert!(same(&expected, &after), "{what}: the frame is that of before");
    assert!(same(&after, &again), "{what}: the frame after is another");
}

#[test]
fn exchanged_meshes_and_materials_show() {
    let context = strict_context();
    let check = |what: &str, change: &dyn Fn(&mut Stage, Entity)| {
        assert_same_as_from_the_start(&context, what, change);
    };
    check("a new mesh", &|stage, entity| {
        let sphere = SceneMesh(Arc::new(MeshData::icosphere(0.7, 2)));
        stage.world.entity_mut(entity).insert(sphere);
    });
    check("a mesh written through", &|stage, entity| {
        let mut mesh = stage.world.get_mut::<SceneMesh>(entity).expect("it has a mesh");
        mesh.0 = Arc::new(MeshData::cuboid(Vec3::new(0.3, 0.6, 0.3)));
    });
    check("a new material", &|stage, entity| {
        let red = Arc::new(Material::matte(Vec3::X));
        stage
            .world
            .entity_mut(entity)
            .insert(SceneMaterials([red].into()));
    });
    check("a blended material", &|stage, entity| {
        let mut glass = Material::matte(Vec3::X);
        glass.alpha_mode = AlphaMode::Blend;
        glass.base_color.w = 0.5;
        stage
            .world
            .entity_mut(entity)
            .insert(SceneMaterials([Arc::new(glass)].into()));
    });
}

#[test]
fn removed_components_show() {
    let context = strict_context();
    let check = |what: &str, change: &dyn Fn(&mut Stage, Entity)| {
        assert_same_as_from_the_start(&context, what, change);
    };
    check("no materials", &|stage, entity| {
        stage.world.entity_mut(entity).remove::<SceneMaterials>();
    });
    check("no mesh", &|stage, entity| {
        stage.world.entity_mut(entity).remove::<SceneMesh>();
    });
    check("no caster", &|stage, entity| {
        stage.world.entity_mut(entity).remove::<ShadowCaster>();
    });
    check("no receiver", &|stage, _| {
        let plane = object_named(stage, "plane");
        stage.world.entity_mut(plane).remove::<ShadowReceiver>();
    });
    check("no object", &|stage, entity| {
        stage.world.despawn(entity);
    });
    check("no technique", &|stage, _| {
        stage.world.entity_mut(stage.lights[0]).remove::<StencilVolume>();
    });
    check("other layers", &|stage, entity| {
        stage.world.entity_mut(entity).insert(SelectionLayers(0));
    });
}

#[test]
fn lights_come_and_go() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let one = render(&mut stage);
    // Before and behind the first in any order of entities.
    for round in 0..4 {
        let (light, at) = light();
        let more = stage.world.spawn_empty().id();
        let at = at.with_translation(Vec3::new(-3.0 + round as f32, 4.0, -2.0));
        stage
            .world
            .entity_mut(more)
            .insert((light, at, StencilVolume::default()));
        assert!(
            render(&mut stage).radiance != one.radiance,
            "round {round}: a second light shines"
        );
        stage.world.despawn(more);
        assert!(same(&one, &render(&mut stage)), "round {round}: and is gone");
    }
}

#[test]
fn a_renderer_is_taken_away_and_another_comes() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let usual = render(&mut stage);
    stage.world.remove_resource::<Renderer>();
    stage.schedule.run(&mut stage.world); // sets and silhouettes go on without
    let entity = the_box(&mut stage);
    stage
        .world
        .entity_mut(entity)
        .insert(Transform::from_xyz(0.5, 0.75, 0.0));
    stage.schedule.run(&mut stage.world);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    assert!(!same(&usual, &render(&mut stage)), "the move was seen");
    stage
        .world
        .entity_mut(entity)
        .insert(Transform::from_xyz(0.0, 0.75, 0.0));
    assert!(same(&usual, &render(&mut stage)));
    // One in the place of another, without a frame between.
    stage
        .add_renderer(context, RenderSettings::default())
        .expect("shaders compose");
    assert!(same(&usual, &render(&mut stage)));
}
