//! Shadow volumes are kept while nothing changes that they depend on, and are what they would be if they were computed in every
//! frame.

use std::sync::Arc;

use antumbra::scene::{
    Camera, FaceCulling, Light, Material, MeshData, Orthographic, SceneMaterials, SceneMesh, ShadowCaster,
    ShadowReceiver,
};
use antumbra::schedule::{AntumbraSystems, init_resources, standalone_schedule};
use antumbra::sets::{DepthReach, FrameLights, Objects, SeeThrough, SeenInto, View, ViewportSize};
use antumbra::silhouettes::{CasterEdges, CasterMesh};
use antumbra::techniques::StencilVolume;
use antumbra::techniques::stencil_volume::{CasterVolume, Counting, Extent, StencilVolumes};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

/// A change of one input, made after the silhouettes of the frame are known. What else depends on the input does not follow.
#[derive(Resource, Default)]
struct LateChange(Option<fn(&mut World, usize)>, usize);

/// A floor, and above it a box and an open plate; a light over them, and one far away over a floor and a box of its own.
struct Scene {
    world: World,
    schedule: Schedule,
    camera: Entity,
    floor: Entity,
    cuboid: Entity,
    plate: Entity,
    light: Entity,
    far_light: Entity,
    far_cuboid: Entity,
}

const FAR: f32 = 60.0;

fn thing(world: &mut World, mesh: MeshData, x: f32, y: f32) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_xyz(x, y, 0.0),
    );
    world.spawn(parts).id()
}

fn lamp(world: &mut World, x: f32) -> Entity {
    let light = Light::point(Vec3::ONE, 10.0, 20.0);
    let place = Transform::from_xyz(x, 6.0, 0.5);
    world.spawn((light, place, StencilVolume::default())).id()
}

fn scene(orthographic: bool) -> Scene {
    let mut world = World::new();
    init_resources(&mut world);
    world.init_resource::<LateChange>();
    world.insert_resource(ViewportSize(UVec2::new(160, 90)));
    let camera = Camera {
        aspect: 160.0 / 90.0,
        orthographic: orthographic.then_some(Orthographic {
            height: 60.0,
            far: 900.0,
        }),
        ..Camera::default()
    };
    let view = Transform::from_xyz(30.0, 40.0, 60.0).looking_at(Vec3::new(30.0, 0.0, 0.0), Vec3::Y);
    let camera = world.spawn((camera, view)).id();
    let floor = thing(&mut world, MeshData::plane(8.0), 0.0, 0.0);
    let cuboid = thing(&mut world, MeshData::cuboid(Vec3::splat(0.4)), -1.5, 3.0);
    let plate = thing(&mut world, MeshData::plane(0.45), 1.5, 3.0);
    let far_cuboid = thing(&mut world, MeshData::cuboid(Vec3::splat(0.4)), FAR + 0.5, 3.0);
    thing(&mut world, MeshData::plane(8.0), FAR, 0.0);
    let light = lamp(&mut world, 0.0);
    let far_light = lamp(&mut world, FAR);
    let mut schedule = standalone_schedule();
    let make_change = |world: &mut World| {
        let late = world.resource::<LateChange>();
        if let (Some(change), object) = (late.0, late.1) {
            change(world, object);
        }
    };
    schedule.add_systems(
        make_change
            .after(AntumbraSystems::BuildSilhouettes)
            .before(AntumbraSystems::BuildTechniques),
    );
    Scene {
        world,
        schedule,
        camera,
        floor,
        cuboid,
        plate,
        light,
        far_light,
        far_cuboid,
    }
}

type Volumes = Vec<(Entity, usize, Vec<CasterVolume>, usize)>;

impl Scene {
    fn run(&mut self) {
        self.schedule.run(&mut self.world);
        self.world.clear_trackers();
    }

    fn volumes(&self) -> Volumes {
        let lights = &self.world.resource::<StencilVolumes>().lights;
        let all = lights.iter();
        all.map(|light| (light.entity, light.light, light.casters.clone(), light.culled))
            .collect()
    }

    /// Runs a frame. Returns its volumes after they were compared with those that a later frame computes anew.
    fn checked(&mut self, what: &str) -> Volumes {
        self.run();
        let kept = self.volumes();
        let lights = self.world.resource::<FrameLights>();
        for (entity, light, ..) in &kept {
            assert_eq!(lights.lights[*light].entity, *entity, "{what}");
        }
        self.world.insert_resource(StencilVolumes::default());
        self.run();
        assert_eq!(self.volumes(), kept, "{what}");
        kept
    }

    fn place(&mut self, entity: Entity) -> Mut<'_, Transform> {
        self.world.get_mut::<Transform>(entity).expect("it has a place")
    }

    fn index(&self, entity: Entity) -> usize {
        let objects = self.world.resource::<Objects>();
        objects.index_of(entity).expect("an object")
    }

    fn volume(&self, caster: Entity) -> Option<CasterVolume> {
        let index = self.index(caster) as u32;
        let volumes = self.world.resource::<StencilVolumes>();
        let all = volumes.lights.iter().flat_map(|light| &light.casters);
        all.copied().find(|volume| volume.object == index)
    }

    /// When the volumes of the lights near and far were computed.
    fn revisions(&self) -> [u64; 2] {
        let volumes = self.world.resource::<StencilVolumes>();
        [self.light, self.far_light].map(|entity| {
            let mut lights = volumes.lights.iter();
            lights
                .find(|light| light.entity == entity)
                .map_or(0, |light| light.revision)
        })
    }

    fn is_recomputed(&self) -> bool {
        let lights = &self.world.resource::<FrameLights>().lights;
        lights.iter().any(|light| light.is_recomputed())
    }

    /// Runs a frame with a change of one input that nothing but the volumes sees.
    fn run_late(&mut self, object: usize, change: fn(&mut World, usize)) {
        *self.world.resource_mut::<LateChange>() = LateChange(Some(change), object);
        self.run();
        assert!(!self.is_recomputed(), "else it is no test of the input");
    }
}

#[test]
fn volumes_at_rest_are_kept() {
    let mut scene = scene(false);
    scene.run();
    let all = |scene: &Scene| scene.world.resource::<StencilVolumes>().revision;
    let (first, revision) = (scene.revisions(), all(&scene));
    assert!(first[0] > 0 && first[1] > 0);
    for _ in 0..3 {
        scene.run();
        assert_eq!((scene.revisions(), all(&scene)), (first, revision));
    }
    // A caster of one light moves.
    let far = scene.far_cuboid;
    scene.place(far).translation.x += 0.2;
    scene.run();
    let second = scene.revisions();
    assert!(second[0] == first[0] && second[1] > first[1] && all(&scene) > revision);
    // The view moves.
    let camera = scene.camera;
    scene.place(camera).translation.x += 0.5;
    scene.run();
    let third = scene.revisions();
    assert!(third[0] > second[0] && third[1] > second[1]);
    scene.run();
    assert_eq!(scene.revisions(), third);
}

#[test]
fn volumes_follow_what_they_depend_on() {
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 9] = [
        ("a receiver moves", |scene| {
            let floor = scene.floor;
            scene.place(floor).translation.y -= 1.0;
        }),
        ("a caster moves", |scene| {
            let cuboid = scene.cuboid;
            scene.place(cuboid).translation.x += 0.3;
        }),
        ("the light moves", |scene| {
            let light = scene.light;
            scene.place(light).translation.x += 0.3;
        }),
        ("the light reaches less far", |scene| {
            let light = scene.light;
            scene.world.get_mut::<Light>(light).expect("a light").range = 6.0;
        }),
        ("the view moves between caster and light", |scene| {
            let camera = scene.camera;
            *scene.place(camera) =
                Transform::from_xyz(-1.5, 2.5, 0.3).looking_at(Vec3::new(-4.0, 0.0, 0.0), Vec3::Y);
        }),
        ("another extent", |scene| {
            let settings = StencilVolume {
                extent: Extent::Infinite,
                ..StencilVolume::default()
            };
            scene.world.entity_mut(scene.light).insert(settings);
        }),
        ("another way to count", |scene| {
            let settings = StencilVolume {
                counting: Counting::DepthFail,
                ..StencilVolume::default()
            };
            scene.world.entity_mut(scene.light).insert(settings);
        }),
        ("another mesh in the same bounds", |scene| {
            let open = MeshData::from_triangles(
                "open",
                vec![Vec3::splat(-0.4), Vec3::new(0.4, -0.4, 0.4), Vec3::splat(0.4)],
                vec![0, 1, 2],
            );
            scene
                .world
                .entity_mut(scene.cuboid)
                .insert(SceneMesh(Arc::new(open)));
        }),
        ("another light comes", |scene| {
            lamp(&mut scene.world, 2.0);
        }),
    ];
    for (what, change) in changes {
        let mut scene = scene(false);
        let before = scene.checked("before");
        assert!(scene.volume(scene.cuboid).is_some_and(|volume| volume.depth_pass));
        change(&mut scene);
        let after = scene.checked(what);
        assert_ne!(before, after, "{what}: it changes the volumes");
        scene.run();
        assert_eq!(scene.volumes(), after, "{what}");
    }
}

/// Inputs on which other parts of the frame depend too: here they change after these have run.
#[test]
fn volumes_follow_what_hides_their_caps() {
    // Something looks into the box: its near cap is needed.
    let mut scene = scene(false);
    scene.run();
    let index = scene.index(scene.cuboid);
    assert!(scene.volume(scene.cuboid).is_some_and(|volume| volume.depth_pass));
    scene.run_late(index, |world, object| {
        world.resource_mut::<SeenInto>().0.insert(object);
    });
    assert!(
        scene
            .volume(scene.cuboid)
            .is_some_and(|volume| !volume.depth_pass)
    );

    // The back of the plate is drawn, and hides its cap.
    let changes: [fn(&mut World, usize); 2] = [
        |world, object| world.resource_mut::<SeeThrough>().two_sided.insert(object),
        |world, _| world.insert_resource(FaceCulling::None),
    ];
    for change in changes {
        let mut scene = self::scene(false);
        scene.run();
        let index = scene.index(scene.plate);
        assert!(scene.volume(scene.plate).is_some_and(|volume| !volume.depth_pass));
        scene.run_late(index, change);
        assert!(scene.volume(scene.plate).is_some_and(|volume| volume.depth_pass));
    }
}

#[test]
fn volumes_follow_silhouettes() {
    let mut scene = scene(false);
    scene.run();
    assert!(scene.volume(scene.cuboid).is_some_and(|volume| volume.depth_pass));
    let revisions = scene.revisions();
    // An open mesh, whose cap would be seen through its back.
    let edges = CasterMesh::build(&MeshData::plane(0.3)).expect("a mesh");
    scene
        .world
        .entity_mut(scene.cuboid)
        .insert(CasterEdges(Arc::new(edges)));
    scene.run();
    assert!(!scene.is_recomputed(), "the silhouette alone changed");
    assert!(
        scene
            .volume(scene.cuboid)
            .is_some_and(|volume| !volume.depth_pass)
    );
    assert!(scene.revisions()[0] > revisions[0] && scene.revisions()[1] == revisions[1]);
}

#[test]
fn volumes_follow_occluders_before_the_camera() {
    let mut scene = scene(false);
    // Beside everything else in view, and out of reach of the lights.
    let wall = thing(&mut scene.world, MeshData::cuboid(Vec3::splat(2.0)), 30.0, 15.0);
    scene.run();
    scene.run();
    let before = scene.revisions();
    scene.place(wall).translation.y += 0.5;
    scene.run();
    assert!(!scene.is_recomputed(), "nothing else is hidden than before");
    let after = scene.revisions();
    assert!(after[0] > before[0] && after[1] > before[1]);
    scene.run();
    assert_eq!(scene.revisions(), after);
}

#[test]
fn kept_volumes_hold_the_depth_of_an_orthographic_view_open() {
    let mut scene = scene(true);
    let state = |scene: &Scene| {
        let depth = scene
            .world
            .resource::<View>()
            .data
            .as_ref()
            .expect("a view")
            .depth;
        let reach = scene.world.resource::<DepthReach>().farthest();
        (depth, reach, scene.volumes())
    };
    scene.run();
    let (first, revisions) = (state(&scene), scene.revisions());
    assert!(first.1 > 60.0, "volumes reach beyond the floors: {}", first.1);
    // The depth was fitted after the volumes were built.
    scene.run();
    let (second, after) = (state(&scene), scene.revisions());
    assert!(after[0] > revisions[0] && after[1] > revisions[1]);
    for _ in 0..3 {
        scene.run();
        assert_eq!((state(&scene), scene.revisions()), (second.clone(), after));
    }
    let floor = scene.floor;
    scene.place(floor).translation.y -= 3.0;
    scene.checked("a receiver moved");
    assert_ne!(state(&scene), second);
}

#[test]
fn what_happens_while_a_light_has_no_volumes_is_seen_after() {
    let mut scene = scene(false);
    let before = scene.checked("before");
    let revision = |scene: &Scene| scene.world.resource::<StencilVolumes>().revision;
    let first = revision(&scene);
    scene.world.entity_mut(scene.light).remove::<StencilVolume>();
    scene.run();
    assert!(revision(&scene) > first && scene.volumes().len() == 1);
    let cuboid = scene.cuboid;
    scene.place(cuboid).translation.x += 0.25;
    scene.run();
    scene
        .world
        .entity_mut(scene.light)
        .insert(StencilVolume::default());
    let moved = scene.checked("the light has its technique again");
    assert_ne!(moved, before);

    scene.world.insert_resource(ViewportSize(UVec2::ZERO));
    scene.run();
    assert!(scene.volumes().is_empty());
    scene.place(cuboid).translation.x -= 0.25;
    scene.run();
    scene.world.insert_resource(ViewportSize(UVec2::new(160, 90)));
    assert_eq!(scene.checked("the view is back"), before);
}

#[test]
fn a_caster_whose_mesh_is_refused_loses_its_volume() {
    let mut scene = scene(false);
    scene.run();
    assert!(scene.volume(scene.cuboid).is_some());
    let mut bad = MeshData::cuboid(Vec3::splat(0.4));
    bad.indices[0] = 9999;
    scene
        .world
        .entity_mut(scene.cuboid)
        .insert(SceneMesh(Arc::new(bad)));
    scene.run();
    assert_eq!(scene.volume(scene.cuboid), None);
    let good = SceneMesh(Arc::new(MeshData::cuboid(Vec3::splat(0.4))));
    scene.world.entity_mut(scene.cuboid).insert(good);
    scene.run();
    assert!(scene.volume(scene.cuboid).is_some());
}
