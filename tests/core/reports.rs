//! Everything that the core refuses, skips or leaves out stands in `Reports`, once, with its entity and what to do.

use std::sync::Arc;

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::reports::{Report, Reports};
use antumbra::scene::WorldBounds;
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::techniques::TextureMemory;
use antumbra::techniques::maps::{MapFilter, MapResolution, MapSettings};
use antumbra::techniques::penumbra_wedge::WedgeOverflow;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, UVec2, Vec3};

/// A world that runs.
struct Scene {
    world: World,
    schedule: Schedule,
}

impl Scene {
    /// A cube on a floor before a camera, nothing of it wrong.
    fn new() -> Self {
        let mut world = World::new();
        init_resources(&mut world);
        world.insert_resource(ViewportSize(UVec2::new(64, 36)));
        let view = Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((Camera::default(), view));
        let mut scene = Self {
            world,
            schedule: standalone_schedule(),
        };
        scene.object(MeshData::cuboid(Vec3::splat(0.5)), Transform::default());
        scene.object(MeshData::plane(5.0), Transform::from_xyz(0.0, -0.5, 0.0));
        scene
    }

    fn object(&mut self, mesh: MeshData, at: Transform) -> Entity {
        let object = (
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            (ShadowCaster, ShadowReceiver),
            at,
        );
        self.world.spawn(object).id()
    }

    fn light(&mut self, light: Light, technique: impl Bundle) -> Entity {
        let at = Transform::from_xyz(1.0, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
        self.world.spawn((light, technique, at)).id()
    }

    /// Runs a frame and gives what is new.
    fn frame(&mut self) -> Vec<Report> {
        self.schedule.run(&mut self.world);
        let mut reports = self.world.resource_mut::<Reports>();
        reports.drain_new().cloned().collect()
    }

    fn standing(&self) -> usize {
        self.world.resource::<Reports>().iter().count()
    }

    /// The fault is reported once, of the entity; `repair` takes it away.
    fn expect(&mut self, topic: &str, entity: Entity, text: &[&str], repair: impl FnOnce(&mut World)) {
        let new = self.frame();
        let [report] = &new[..] else {
            panic!("{text:?}: {new:#?}");
        };
        assert_eq!((report.topic, report.entity), (topic, Some(entity)), "{report:?}");
        for text in text {
            assert!(report.message.contains(text), "{text:?}: {}", report.message);
        }
        assert!(
            report.message.ends_with('.'),
            "whole sentences: {}",
            report.message
        );
        for _ in 0..5 {
            assert!(self.frame().is_empty(), "{text:?} is said once");
        }
        assert_eq!(self.standing(), 1, "and stands");
        repair(&mut self.world);
        assert!(self.frame().is_empty());
        assert_eq!(self.standing(), 0, "{text:?} is repaired");
    }
}

fn point() -> Light {
    Light::point(Vec3::ONE, 20.0, 20.0)
}

fn of(kind: LightKind) -> Light {
    Light { kind, ..point() }
}

const RECT: LightKind = LightKind::Rect {
    width: 1.0,
    height: 0.5,
};

const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.2,
    outer_angle: 0.6,
};

#[test]
fn a_healthy_scene_has_no_reports() {
    let mut scene = Scene::new();
    scene.light(point(), StencilVolume::default());
    scene.light(point(), OmniMap::default());
    scene.light(point(), ());
    scene.light(of(RECT), PenumbraWedge::default());
    scene.light(of(LightKind::Sphere { radius: 0.2 }), PenumbraWedge::default());
    scene.light(of(RECT), OmniMap::default());
    scene.light(of(SPOT), ShadowMap::default());
    scene.light(Light::directional(Vec3::ONE, 3.0), ShadowMap::default());
    scene.light(Light::directional(Vec3::ONE, 3.0), StencilVolume::default());
    // By which games hide things, and place holders.
    let hidden = Transform::from_scale(Vec3::ZERO);
    scene.object(MeshData::cuboid(Vec3::ONE), hidden);
    let nothing = MeshData::from_triangles("nothing", Vec::new(), Vec::new());
    scene.object(nothing, Transform::default());
    scene
        .world
        .spawn((WorldBounds(Aabb::EMPTY), GlobalTransform::IDENTITY, ShadowCaster));
    for _ in 0..3 {
        let new = scene.frame();
        assert!(new.is_empty(), "{new:#?}");
    }
}

#[test]
fn lights_that_cannot_shine() {
    type Spoil = fn(&mut Light, &mut Transform);
    let faults: [(&[&str], Spoil); 7] = [
        (&["range is 0 m", "Set a range"], |l, _| l.range = 0.0),
        (&["range is NaN m"], |l, _| l.range = f32::NAN),
        (&["intensity is -1", "Set a finite intensity"], |l, _| {
            l.intensity = -1.0;
        }),
        (&["colour is", "Set a colour"], |l, _| l.color.y = f32::NAN),
        (
            &[
                "half-angles are 28.65° inside and 5.73° outside (0.5 and 0.1 radians)",
                "Set the outer",
            ],
            |l, _| {
                l.kind = LightKind::Spot {
                    inner_angle: 0.5,
                    outer_angle: 0.1,
                };
            },
        ),
        (&["size is -1 m", "Set a finite size"], |l, _| {
            l.kind = LightKind::Sphere { radius: -1.0 };
        }),
        (&["transform is not finite", "parents"], |_, t| {
            t.translation.x = f32::INFINITY;
        }),
    ];
    let mut scene = Scene::new();
    let light = scene.light(point(), StencilVolume::default());
    assert!(scene.frame().is_empty());
    for (text, spoil) in faults {
        let mut parts = scene.world.entity_mut(light);
        let good = (
            parts.get::<Light>().unwrap().clone(),
            *parts.get::<Transform>().unwrap(),
        );
        let mut bad = good.clone();
        spoil(&mut bad.0, &mut bad.1);
        parts.insert(bad);
        scene.expect("light", light, text, |world| {
            world.entity_mut(light).insert(good);
        });
    }
}

#[test]
fn another_fault_of_the_same_light_is_new() {
    let mut scene = Scene::new();
    let light = scene.light(
        Light {
            range: 0.0,
            ..point()
        },
        (),
    );
    assert_eq!(scene.frame().len(), 1);
    scene.world.get_mut::<Light>(light).unwrap().range = -3.0;
    assert!(scene.frame().is_empty(), "the same fault with another number");
    let message = scene
        .world
        .resource::<Reports>()
        .of_entity(light)
        .next()
        .unwrap()
        .message
        .clone();
    assert!(message.contains("-3 m"), "the message follows: {message}");
    scene.world.get_mut::<Light>(light).unwrap().intensity = f32::NAN;
    let new = scene.frame();
    assert!(new.len() == 1 && new[0].message.contains("intensity"), "{new:?}");
    assert_eq!(scene.standing(), 1);
    scene.world.despawn(light);
    assert!(scene.frame().is_empty());
    assert_eq!(scene.standing(), 0);
}

#[test]
fn objects_that_are_left_out() {
    let mut scene = Scene::new();
    let object = scene.object(MeshData::cuboid(Vec3::ONE), Transform::default());
    let set = |world: &mut World, at: Transform| {
        world.entity_mut(object).insert(at);
    };
    let good = Transform::default();
    set(&mut scene.world, Transform::from_xyz(0.0, f32::NAN, 0.0));
    scene.expect("object", object, &["holds NaN", "parents"], |world| {
        set(world, good)
    });
    // Flattened along one axis, it is a plate that is drawn and casts.
    set(&mut scene.world, Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)));
    assert!(scene.frame().is_empty());
    set(&mut scene.world, Transform::from_scale(Vec3::new(1.0, 0.0, 0.0)));
    scene.expect("object", object, &["flattens", "scale other than 0"], |world| {
        set(world, good);
    });
    let mut broken = MeshData::cuboid(Vec3::ONE);
    broken.positions.fill(Vec3::NAN);
    scene.world.entity_mut(object).insert(SceneMesh(Arc::new(broken)));
    scene.expect("object", object, &["no finite vertex", "Repair"], |world| {
        world
            .entity_mut(object)
            .insert(SceneMesh(Arc::new(MeshData::cuboid(Vec3::ONE))));
    });
    let bounds = Aabb {
        min: Vec3::NAN,
        max: Vec3::ONE,
    };
    let own = (WorldBounds(bounds), GlobalTransform::IDENTITY, ShadowCaster);
    let own = scene.world.spawn(own).id();
    scene.expect("object", own, &["bounds hold NaN", "WorldBounds"], |world| {
        world.despawn(own);
    });
}

#[test]
fn meshes_that_cast_nothing() {
    let spoilt = || {
        let mut mesh = MeshData::cuboid(Vec3::ONE);
        mesh.name = "crate".to_owned();
        mesh.indices.extend([0, 99, 1]);
        mesh
    };
    let mut scene = Scene::new();
    let object = scene.object(spoilt(), Transform::default());
    let text = ["`crate`", "triangle 12 names vertex 99", "the mesh has 24"];
    scene.expect("caster", object, &text, |world| {
        world
            .entity_mut(object)
            .insert(SceneMesh(Arc::new(MeshData::cuboid(Vec3::ONE))));
    });
    let object = scene.object(spoilt(), Transform::default());
    scene.expect("caster", object, &text, |world| {
        world.entity_mut(object).remove::<ShadowCaster>();
    });
    let mut cut = spoilt();
    cut.indices.truncate(35);
    let object = scene.object(cut, Transform::default());
    scene.expect("caster", object, &["35 indices", "three indices"], |world| {
        world.despawn(object);
    });
}

#[test]
fn cells_and_portals_that_hide_less() {
    let mut scene = Scene::new();
    let room = |scene: &mut Scene, x: f32| {
        let cell = Cell {
            half_size: Vec3::splat(4.0),
        };
        let at = Transform::from_xyz(x, 0.0, 0.0);
        scene.world.spawn((cell, at)).id()
    };
    let rooms = [room(&mut scene, 0.0), room(&mut scene, 8.0)];
    let door = Portal::rectangle(rooms, 1.0, 1.0);
    let at = Transform::from_xyz(4.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(1.5));
    let portal = scene.world.spawn((door.clone(), at)).id();
    assert!(scene.frame().is_empty());
    let outline = |points: &[Vec3]| Portal {
        outline: points.into(),
        ..door.clone()
    };
    let dangling = Portal {
        joins: [rooms[0], portal],
        ..door.clone()
    };
    let bent = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    let notched = [
        Vec3::ZERO,
        2.0 * Vec3::X,
        Vec3::new(2.0, 2.0, 0.0),
        2.0 * Vec3::Y,
        Vec3::new(0.9, 1.0, 0.0),
    ];
    let faults = [
        (outline(&bent), "not flat"),
        (outline(&notched), "not convex"),
        (outline(&[Vec3::ZERO, Vec3::X]), "no area"),
        (dangling, "no cell"),
    ];
    for (bad, text) in faults {
        scene.world.entity_mut(portal).insert(bad);
        scene.expect("cell", portal, &["The portal", text], |world| {
            world.entity_mut(portal).insert(door.clone());
        });
    }
    let alone = room(&mut scene, 30.0);
    scene.world.get_mut::<Cell>(alone).unwrap().half_size.y = 0.0;
    scene.expect("cell", alone, &["The cell's box is empty", "volume"], |world| {
        world.despawn(alone);
    });
}

#[test]
fn techniques_that_do_not_fit_their_light() {
    let mut scene = Scene::new();
    let sun = Light::directional(Vec3::ONE, 3.0);
    let despawn = |entity: Entity| {
        move |world: &mut World| {
            world.despawn(entity);
        }
    };
    let light = scene.light(sun, OmniMap::default());
    let text = [
        "no shadow",
        "OmniMap does not fit a directional light",
        "use ShadowMap (`shadow_map`) for a directional light",
    ];
    scene.expect("omni_map", light, &text, despawn(light));
    for (kind, name) in [
        (RECT, "rectangle"),
        (LightKind::Point, "point"),
        (LightKind::Sphere { radius: 0.2 }, "sphere"),
    ] {
        let light = scene.light(of(kind), ShadowMap::default());
        let name = format!("ShadowMap does not fit a {name} light");
        let text = [&name[..], "use OmniMap"];
        scene.expect("shadow_map", light, &text, despawn(light));
    }
    for kind in [LightKind::Point, LightKind::Sphere { radius: 0.0 }, SPOT] {
        let light = scene.light(of(kind), PenumbraWedge::default());
        let text = ["hard shadow", "no size", "radius", "StencilVolume"];
        scene.expect("penumbra_wedge", light, &text, |world| {
            world.entity_mut(light).insert(of(RECT));
        });
        scene.world.despawn(light);
    }
    let entity = scene
        .world
        .spawn((StencilVolume::default(), Transform::default()));
    let entity = entity.id();
    let text = ["StencilVolume has no effect", "no light", "Put it on"];
    scene.expect("technique", entity, &text, |world| {
        world.entity_mut(entity).insert(point());
    });
    scene.world.entity_mut(entity).insert(OmniMap::default());
    let text = ["2 shadow techniques, StencilVolume and OmniMap", "Remove"];
    scene.expect("technique", entity, &text, |world| {
        world.entity_mut(entity).remove::<OmniMap>();
    });
}

#[test]
fn maps_that_are_refused_or_short() {
    let mut scene = Scene::new();
    let light = scene.light(of(SPOT), ShadowMap::default());
    let soft = ShadowMap {
        filter: MapFilter::Soft4 { softness: f32::NAN },
        ..Default::default()
    };
    scene.world.entity_mut(light).insert(soft);
    let text = ["no shadow", "softness is NaN", "Set it in its ShadowMap"];
    scene.expect("shadow_map", light, &text, |world| {
        world.entity_mut(light).insert(ShadowMap::default());
    });
    let fixed = ShadowMap {
        resolution: MapResolution::Fixed(256),
        ..Default::default()
    };
    scene.world.entity_mut(light).insert(fixed);
    assert!(scene.frame().is_empty());
    let limit = |world: &mut World, bytes: u64| world.resource_mut::<TextureMemory>().limit = bytes;
    let enough = scene.world.resource::<TextureMemory>().limit;
    limit(&mut scene.world, 200_000);
    let text = ["shadow_map is poorer", "256 became", "TextureMemory::limit"];
    scene.expect("texture_memory", light, &text, |world| limit(world, enough));
    limit(&mut scene.world, 0);
    let text = ["shadow_map is poorer", "not kept", "fewer lights"];
    scene.expect("texture_memory", light, &text, |world| limit(world, enough));
    scene.world.resource_mut::<MapSettings>().largest = 128;
    let text = ["resolution 256 is beyond the limit of 128 texels"];
    scene.expect("shadow_map", light, &text, |world| {
        world.resource_mut::<MapSettings>().largest = 8192;
    });
}

/// Inserts a component, runs a frame, and tells what is new and what stands about the entity.
fn after(scene: &mut Scene, entity: Entity, component: impl Bundle) -> (usize, String) {
    scene.world.entity_mut(entity).insert(component);
    let new = scene.frame().len();
    let reports = scene.world.resource::<Reports>();
    let messages: Vec<&str> = reports.of_entity(entity).map(|report| &*report.message).collect();
    (new, messages.join("\n"))
}

#[test]
fn messages_follow_their_values_and_a_fault_of_another_name_is_new() {
    let mut scene = Scene::new();
    let light = scene.light(of(SPOT), ());
    let near = |near: f32| ShadowMap {
        near: Some(near),
        ..Default::default()
    };
    let soft = ShadowMap {
        filter: MapFilter::Soft4 { softness: f32::NAN },
        ..Default::default()
    };
    for (map, new, text) in [
        (near(-1.0), 1, "near is -1 m"),
        (near(-2.0), 0, "near is -2 m"),
        (soft, 1, "softness is NaN"),
        (near(-2.0), 1, "near is -2 m"),
    ] {
        let (found, message) = after(&mut scene, light, map);
        assert_eq!(found, new, "{text}");
        assert!(
            message.contains(text) && !message.contains('\n'),
            "{text}: {message}"
        );
    }
    let (_, message) = after(&mut scene, light, ShadowMap::default());
    assert_eq!(message, "");

    let fixed = |texels: u32| ShadowMap {
        resolution: MapResolution::Fixed(texels),
        ..Default::default()
    };
    scene.world.resource_mut::<MapSettings>().largest = 64;
    for (texels, new) in [(256, 1), (128, 0)] {
        let (found, message) = after(&mut scene, light, fixed(texels));
        assert_eq!(found, new);
        assert!(message.contains(&format!("resolution {texels} is")), "{message}");
    }
    scene.world.entity_mut(light).remove::<ShadowMap>();

    let broken = |name: &str, index: u32| {
        let mut mesh = MeshData::cuboid(Vec3::splat(0.5));
        mesh.name = name.to_owned();
        mesh.indices[0] = index;
        SceneMesh(Arc::new(mesh))
    };
    let caster = scene.object(MeshData::cuboid(Vec3::splat(0.5)), Transform::default());
    for (name, index, new) in [("gate", 100, 1), ("gate", 200, 0), ("tower", 200, 1)] {
        let (found, message) = after(&mut scene, caster, broken(name, index));
        assert_eq!(found, new, "{name}");
        let text = [format!("`{name}`"), format!("vertex {index}")];
        assert!(text.iter().all(|text| message.contains(text)), "{message}");
    }
}

#[test]
fn sums_of_wedges_that_overflow_are_reported_of_the_camera() {
    let mut scene = Scene::new();
    let camera = scene
        .world
        .query_filtered::<Entity, With<Camera>>()
        .single(&scene.world)
        .unwrap();
    scene.world.resource::<WedgeOverflow>().set(17);
    let text = ["17 pixels", "31 hard faces", "VisibilityBuffer::Float"];
    scene.expect("penumbra_wedge", camera, &text, |world| {
        world.resource::<WedgeOverflow>().set(0);
    });
}

#[test]
fn the_order_of_spawning_does_not_show() {
    let of = |backwards: bool| {
        let mut scene = Scene::new();
        let mut faults: Vec<usize> = (0..6).collect();
        if backwards {
            faults.reverse();
        }
        for fault in faults {
            let entity = match fault % 3 {
                0 => scene.light(
                    Light {
                        range: 0.0,
                        ..point()
                    },
                    (),
                ),
                1 => scene.light(of(RECT), ShadowMap::default()),
                _ => scene.world.spawn((OmniMap::default(), Transform::default())).id(),
            };
            scene
                .world
                .entity_mut(entity)
                .insert(Name::new(format!("fault {fault}")));
        }
        let new = scene.frame();
        let mut named: Vec<(String, Report)> = new
            .into_iter()
            .map(|report| {
                let name = scene.world.get::<Name>(report.entity.unwrap()).unwrap();
                let unnamed = Report {
                    entity: None,
                    ..report
                };
                (name.to_string(), unnamed)
            })
            .collect();
        assert!(named.is_sorted_by_key(|(_, report)| report.topic));
        named.sort_by(|(a, _), (b, _)| a.cmp(b));
        named
    };
    assert_eq!(of(false), of(true));
    assert_eq!(of(false).len(), 6);
}

/// A host that clears its world's trackers has no report; one that does not is told after a thousand frames.
#[test]
fn worlds_that_keep_every_removal_are_reported() {
    let mut scene = Scene::new();
    for _ in 0..1100 {
        assert!(scene.frame().is_empty());
        scene.world.clear_trackers();
    }
    let told: Vec<_> = (0..1100).flat_map(|_| scene.frame()).collect();
    let [report] = &told[..] else {
        panic!("{told:#?}");
    };
    assert_eq!((report.topic, report.entity), ("world", None));
    assert!(report.message.contains("clear_trackers"), "{}", report.message);
    assert_eq!(scene.standing(), 1);
    // The world keeps removals for one more call.
    scene.world.clear_trackers();
    scene.world.clear_trackers();
    assert!(scene.frame().is_empty());
    assert_eq!(scene.standing(), 0);
}
