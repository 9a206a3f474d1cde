//! A frame pays for the objects that changed: matrices, meshes and materials of the others stay, and the picture is that of a
//! world in which everything had always been so.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::MatrixWork;
use antumbra::scene::{Submesh, SurfaceWeights};
use antumbra::sets::Objects;
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3, Vec4};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// One object.
#[derive(Clone)]
struct Thing {
    mesh: Arc<MeshData>,
    material: Arc<Material>,
    place: Transform,
    weights: Option<SurfaceWeights>,
}

/// Everything that the world is made of.
#[derive(Clone)]
struct Scene {
    things: Vec<Thing>,
    eye: Vec3,
}

fn color(color: Vec4) -> Material {
    Material {
        base_color: color,
        ..Material::default()
    }
}

/// Balls in rows over a floor. There are more than 64, so that they take several words of the bitsets.
fn scene() -> Scene {
    let ball = Arc::new(MeshData::icosphere(0.25, 1));
    let matte = Arc::new(color(Vec4::new(0.8, 0.6, 0.5, 1.0)));
    let mut things = vec![Thing {
        mesh: Arc::new(MeshData::plane(8.0)),
        material: matte.clone(),
        place: Transform::IDENTITY,
        weights: None,
    }];
    for i in 0..150 {
        let at = Vec3::new(
            (i % 15) as f32 - 7.0,
            0.6 + (i % 4) as f32 * 0.3,
            (i / 15) as f32 - 5.0,
        );
        things.push(Thing {
            mesh: ball.clone(),
            material: matte.clone(),
            place: Transform::from_translation(at),
            weights: None,
        });
    }
    let eye = Vec3::new(3.0, 4.0, 9.0);
    Scene { things, eye }
}

fn set<C: Component<Mutability = Mutable>>(world: &mut World, entity: Entity, value: C) {
    *world.get_mut::<C>(entity).expect("it has one") = value;
}

fn view(eye: Vec3) -> Transform {
    Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y)
}

fn spawn(world: &mut World, thing: &Thing) -> Entity {
    let looks = SceneMaterials([thing.material.clone()].into());
    let mut entity = world.spawn((
        SceneMesh(thing.mesh.clone()),
        looks,
        (ShadowCaster, ShadowReceiver),
        thing.place,
    ));
    if let Some(weights) = thing.weights {
        entity.insert(weights);
    }
    entity.id()
}

fn stage(scene: &Scene) -> (Stage, Vec<Entity>) {
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(96, 54), camera, view(scene.eye));
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    for x in [-3.0, 2.0] {
        let place = Transform::from_xyz(x, 4.0, 1.0);
        let light = Light::point(Vec3::ONE, 40.0, 20.0);
        stage.spawn_light(light, place, Some(StencilVolume::default()));
    }
    let entities = scene.things.iter().map(|thing| spawn(&mut stage.world, thing));
    let entities = entities.collect();
    (stage, entities)
}

/// Renders a frame, and compares it with that of a fresh world. Returns the work on matrices, and the radiance.
fn frame(stage: &mut Stage, scene: &Scene) -> (MatrixWork, Vec<f32>) {
    let rendered = stage.render().expect("the frame renders");
    let work = stage.world.resource::<Renderer>().frame().matrices;
    let fresh = self::stage(scene).0.render().expect("the frame renders");
    assert!(rendered.radiance == fresh.radiance, "radiance");
    assert!(rendered.visibility == fresh.visibility, "visibility");
    (work, rendered.radiance)
}

fn work(computed: usize, uploaded: usize, uploads: usize) -> MatrixWork {
    MatrixWork {
        computed,
        uploaded,
        uploads,
    }
}

#[test]
fn matrices_are_computed_and_uploaded_where_something_changed() {
    let mut scene = scene();
    let (mut stage, mut entities) = stage(&scene);
    let all = work(151, 151, 1);
    let (first, before) = frame(&mut stage, &scene);
    assert_eq!(first, all);
    assert_eq!(frame(&mut stage, &scene).0, work(0, 0, 0));

    scene.things[80].place.translation.y += 0.5;
    set(&mut stage.world, entities[80], scene.things[80].place);
    let (moved, after) = frame(&mut stage, &scene);
    assert_eq!(moved, work(1, 1, 1));
    assert!(before != after, "it shows");

    // Neighbours are uploaded together, and so is what lies between them.
    for (pair, expected) in [([70, 72], work(2, 3, 1)), ([5, 145], work(2, 2, 2))] {
        for index in pair {
            let entity = stage.world.resource::<Objects>().entities[index];
            let thing = entities
                .iter()
                .position(|known| *known == entity)
                .expect("it is one");
            scene.things[thing].place.translation.x += 0.25;
            set(&mut stage.world, entity, scene.things[thing].place);
        }
        assert_eq!(frame(&mut stage, &scene).0, expected);
    }

    scene.eye.x -= 1.0;
    let camera = stage.camera;
    set(&mut stage.world, camera, view(scene.eye));
    assert_eq!(frame(&mut stage, &scene).0, all);

    for diffuse in [Some(0.3), Some(0.6), None] {
        scene.things[75].weights = diffuse.map(|diffuse| SurfaceWeights {
            diffuse,
            ..SurfaceWeights::default()
        });
        match scene.things[75].weights {
            Some(weights) => stage.world.entity_mut(entities[75]).insert(weights),
            None => stage.world.entity_mut(entities[75]).remove::<SurfaceWeights>(),
        };
        assert_eq!(frame(&mut stage, &scene).0, work(1, 1, 1), "{diffuse:?}");
    }

    stage.world.despawn(entities.remove(90));
    scene.things.remove(90);
    assert_eq!(frame(&mut stage, &scene).0, work(150, 150, 1));

    // What moves while nothing can be drawn is there when it can.
    let size = std::mem::take(&mut stage.world.resource_mut::<ViewportSize>().0);
    scene.things[30].place.translation.y += 0.5;
    set(&mut stage.world, entities[30], scene.things[30].place);
    stage.render().expect("there is nothing to draw");
    stage.world.resource_mut::<ViewportSize>().0 = size;
    frame(&mut stage, &scene);
}

/// A renderer that was taken out of the world for a frame has missed what moved and what was exchanged.
#[test]
fn a_renderer_that_was_away_catches_up() {
    let mut scene = scene();
    let (mut stage, entities) = stage(&scene);
    frame(&mut stage, &scene);
    let away = stage.world.remove_resource::<Renderer>().expect("it is there");
    scene.things[80].place.translation.y += 0.5;
    set(&mut stage.world, entities[80], scene.things[80].place);
    scene.things[81].material = Arc::new(color(Vec4::new(0.1, 0.9, 0.1, 1.0)));
    set(
        &mut stage.world,
        entities[81],
        SceneMaterials([scene.things[81].material.clone()].into()),
    );
    stage.schedule.run(&mut stage.world);
    stage.world.clear_trackers();
    stage.world.insert_resource(away);
    frame(&mut stage, &scene);
}

/// Colours, alpha modes, sides and meshes are exchanged, alone and together with a move.
#[test]
fn exchanged_looks_show_and_take_no_matrices() {
    let mut scene = scene();
    let (mut stage, entities) = stage(&scene);
    let (_, mut last) = frame(&mut stage, &scene);
    let green = Vec4::new(0.1, 0.9, 0.1, 1.0);
    let with = |change: &dyn Fn(&mut Material)| {
        let mut material = color(green);
        change(&mut material);
        Arc::new(material)
    };
    let tall = Arc::new(MeshData::cuboid(Vec3::new(0.2, 0.9, 0.2)));
    let looks = [
        (with(&|_| {}), None),
        (with(&|material| material.emissive = Vec3::X), None),
        (with(&|material| material.alpha_mode = AlphaMode::Blend), None),
        (with(&|material| material.base_color.w = 0.4), None),
        (
            with(&|material| {
                material.alpha_mode = AlphaMode::Blend;
                material.base_color.w = 0.4;
            }),
            None,
        ),
        (with(&|material| material.unlit = true), None),
        (with(&|material| material.clearcoat = 1.0), None),
        (scene.things[0].material.clone(), Some(tall)),
        (
            with(&|material| material.double_sided = true),
            Some(scene.things[1].mesh.clone()),
        ),
    ];
    let mut differing = 0;
    for (step, (material, mesh)) in looks.into_iter().enumerate() {
        for i in [80, 81] {
            scene.things[i].material = material.clone();
            let looks = SceneMaterials([material.clone()].into());
            set(&mut stage.world, entities[i], looks);
            if let Some(mesh) = &mesh {
                scene.things[i].mesh = mesh.clone();
                set(&mut stage.world, entities[i], SceneMesh(mesh.clone()));
            }
        }
        let moves = step % 2;
        scene.things[80].place.translation.y += 0.1 * moves as f32;
        if moves == 1 {
            set(&mut stage.world, entities[80], scene.things[80].place);
        }
        let (work, picture) = frame(&mut stage, &scene);
        if mesh.is_none() {
            assert_eq!(work.computed, moves, "step {step}");
        }
        differing += usize::from(picture != last);
        last = picture;
    }
    assert!(differing >= 7, "{differing}");
    // The floor has one item; two cannot be put into its place.
    let mut two = (*scene.things[0].mesh).clone();
    let [part] = two.submeshes[..] else {
        panic!("a plane has one submesh");
    };
    let half = part.index_count / 2 / 3 * 3;
    two.submeshes = vec![
        Submesh {
            index_count: half,
            ..part
        },
        Submesh {
            first_index: part.first_index + half,
            index_count: part.index_count - half,
        },
    ];
    let two = Arc::new(two);
    let matte = scene.things[0].material.clone();
    let pair = [matte.clone(), with(&|_| {})];
    set(&mut stage.world, entities[0], SceneMesh(two.clone()));
    set(
        &mut stage.world,
        entities[0],
        SceneMaterials(pair.iter().cloned().collect()),
    );
    let rendered = stage.render().expect("the frame renders");
    let (mut fresh, fresh_entities) = self::stage(&scene);
    set(&mut fresh.world, fresh_entities[0], SceneMesh(two));
    set(
        &mut fresh.world,
        fresh_entities[0],
        SceneMaterials(pair.into_iter().collect()),
    );
    let fresh = fresh.render().expect("the frame renders");
    assert!(rendered.radiance == fresh.radiance && rendered.radiance != last);
}

/// A material that no object has any more is freed, also if only one object was looked at again.
#[test]
fn an_animated_colour_leaves_no_materials_behind() {
    let scene = scene();
    let (mut stage, entities) = stage(&scene);
    stage.render().expect("the frame renders");
    let mut old: Vec<std::sync::Weak<Material>> = Vec::new();
    for step in 0..6 {
        let material = Arc::new(color(Vec4::new(step as f32 * 0.1, 0.5, 0.5, 1.0)));
        old.push(Arc::downgrade(&material));
        set(&mut stage.world, entities[80], SceneMaterials([material].into()));
        stage.render().expect("the frame renders");
    }
    let alive = old.iter().filter(|material| material.strong_count() > 0).count();
    assert_eq!(alive, 1, "the last one");
}
