//! Which technique shadows a light, and what is done for it before the technique runs.

use std::sync::Arc;

use antumbra::plugin::AntumbraPlugin;
use antumbra::reports::Reports;
use antumbra::scene::{
    Camera, Light, Material, MeshData, SceneMaterials, SceneMesh, ShadowCaster, ShadowReceiver,
};
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::sets::{FrameLights, Objects, ViewportSize};
use antumbra::silhouettes::Silhouettes;
use antumbra::techniques::stencil_volume::StencilVolumes;
use antumbra::techniques::{
    AddTechnique, NeededSilhouettes, Needs, OmniMap, ShadowMap, StencilVolume, Technique, Techniques,
};
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

/// A technique that keeps a picture of all that its light reaches.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
struct Keeper;

#[derive(Resource, Default)]
struct KeeperRuns(usize);

impl Technique for Keeper {
    const NAME: &'static str = "keeper";
    const NEEDS: Needs = Needs {
        silhouettes: NeededSilhouettes::Reached,
        ..Needs::NOTHING
    };

    fn init(world: &mut World) {
        world.init_resource::<KeeperRuns>();
    }

    fn add_systems(schedule: &mut Schedule) {
        let count = |mut runs: ResMut<KeeperRuns>| runs.0 += 1;
        schedule.add_systems(count.in_set(antumbra::techniques::TechniqueSystems));
    }

    #[cfg(feature = "render")]
    type Recorder = antumbra::render::NoRecorder;

    #[cfg(feature = "render")]
    fn recorder(
        _: &antumbra::render::Gpu,
    ) -> Result<antumbra::render::NoRecorder, antumbra::render::RenderError> {
        Ok(antumbra::render::NoRecorder)
    }
}

/// A ball in view, one behind the camera, and a light between them and above the view.
struct Scene {
    world: World,
    schedule: Schedule,
    light: Entity,
    in_view: Entity,
    behind: Entity,
}

fn spawn_ball(world: &mut World, z: f32) -> Entity {
    let parts = (
        SceneMesh(Arc::new(MeshData::icosphere(0.5, 2))),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_xyz(0.0, 0.0, z),
    );
    world.spawn(parts).id()
}

fn scene() -> Scene {
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(UVec2::new(160, 90)));
    world.spawn((Camera::default(), Transform::IDENTITY));
    let [in_view, behind] = [-5.0, 5.0].map(|z| spawn_ball(&mut world, z));
    let light = Light::point(Vec3::ONE, 10.0, 30.0);
    let light = world.spawn((light, Transform::from_xyz(0.0, 0.6, -2.0))).id();
    Scene {
        world,
        schedule: standalone_schedule(),
        light,
        in_view,
        behind,
    }
}

impl Scene {
    fn run(&mut self) {
        self.schedule.run(&mut self.world);
    }

    fn technique(&mut self) -> Option<&'static str> {
        self.run();
        let lights = self.world.resource::<FrameLights>();
        let light = lights.of_entity(self.light).expect("the light shines");
        light.technique.map(|technique| technique.name)
    }

    fn has_silhouette(&self, caster: Entity) -> bool {
        let index = self
            .world
            .resource::<Objects>()
            .index_of(caster)
            .expect("an object");
        let silhouettes = self.world.resource::<Silhouettes>().of_light(self.light);
        silhouettes.is_some_and(|light| light.of_object(index).is_some())
    }

    fn said(&self) -> Vec<String> {
        let reports = self.world.resource::<Reports>().of_entity(self.light);
        reports.map(|report| report.message.clone()).collect()
    }
}

#[test]
fn silhouettes_of_casters_out_of_view_are_there_for_those_who_need_them() {
    let mut scene = scene();
    (&mut scene.world, &mut scene.schedule).add_technique::<Keeper>();
    scene
        .world
        .entity_mut(scene.light)
        .insert(StencilVolume::default());
    assert_eq!(scene.technique(), Some("stencil_volume"));
    let lights = scene.world.resource::<FrameLights>();
    let index = scene
        .world
        .resource::<Objects>()
        .index_of(scene.behind)
        .expect("an object");
    assert!(lights.lights[0].sets.l.contains(index) && !lights.lights[0].sets.s.contains(index));
    assert!(scene.has_silhouette(scene.in_view) && !scene.has_silhouette(scene.behind));
    scene
        .world
        .entity_mut(scene.light)
        .remove::<StencilVolume>()
        .insert(Keeper);
    assert_eq!(scene.technique(), Some("keeper"));
    assert!(scene.has_silhouette(scene.in_view) && scene.has_silhouette(scene.behind));
    assert!(scene.world.resource::<KeeperRuns>().0 > 0, "its systems run");
    // What nobody needs is not kept, and not extracted again.
    scene
        .world
        .entity_mut(scene.light)
        .remove::<Keeper>()
        .insert(OmniMap::default());
    assert_eq!(scene.technique(), Some("omni_map"));
    assert!(!scene.has_silhouette(scene.in_view) && !scene.has_silhouette(scene.behind));
    scene.run();
    assert_eq!(scene.world.resource::<Silhouettes>().extracted, 0);
}

#[test]
fn casters_that_do_not_cast_for_the_light_need_no_silhouette() {
    let mut scene = scene();
    (&mut scene.world, &mut scene.schedule).add_technique::<Keeper>();
    scene.world.entity_mut(scene.light).insert(Keeper);
    scene
        .world
        .entity_mut(scene.behind)
        .insert(antumbra::scene::SelectionLayers(0b10));
    scene
        .world
        .entity_mut(scene.light)
        .insert(antumbra::scene::LightSelection {
            casts_for: 0b01,
            ..Default::default()
        });
    scene.run();
    assert!(scene.has_silhouette(scene.in_view) && !scene.has_silhouette(scene.behind));
}

#[test]
fn a_light_whose_technique_is_taken_away_lights_what_it_does_not_see() {
    let mut scene = scene();
    scene
        .world
        .entity_mut(scene.light)
        .insert(StencilVolume::default());
    assert_eq!(scene.technique(), Some("stencil_volume"));
    let needs = |scene: &Scene| scene.world.resource::<FrameLights>().lights[0].needs();
    assert!(needs(&scene).light_occlusion);
    assert_eq!(scene.world.resource::<StencilVolumes>().lights.len(), 1);
    scene.world.entity_mut(scene.light).remove::<StencilVolume>();
    assert_eq!(scene.technique(), None);
    assert_eq!(needs(&scene), Needs::NOTHING);
    assert_eq!(scene.world.resource::<StencilVolumes>().lights.len(), 0);
}

#[test]
fn of_two_techniques_the_first_of_the_list_counts_in_whichever_order_they_came() {
    for swapped in [false, true] {
        let mut scene = scene();
        let mut light = scene.world.entity_mut(scene.light);
        if swapped {
            light.insert(OmniMap::default()).insert(StencilVolume::default());
        } else {
            light.insert(StencilVolume::default()).insert(OmniMap::default());
        }
        assert_eq!(scene.technique(), Some("stencil_volume"));
        let said = scene.said();
        assert!(
            said.len() == 1 && said[0].contains("StencilVolume is used"),
            "{said:?}"
        );
        scene.world.entity_mut(scene.light).remove::<StencilVolume>();
        assert_eq!(scene.technique(), Some("omni_map"));
        assert_eq!(scene.said(), Vec::<String>::new());
    }
}

#[test]
fn a_technique_that_does_not_fit_the_light_is_refused_and_says_what_does() {
    let mut scene = scene();
    scene.world.entity_mut(scene.light).insert(ShadowMap::default());
    assert_eq!(scene.technique(), None, "a point light has no single direction");
    let said = scene.said();
    assert!(
        said.len() == 1 && said[0].contains("point light") && said[0].contains("OmniMap"),
        "{said:?}"
    );
    // It is enough that the light becomes another.
    scene
        .world
        .entity_mut(scene.light)
        .insert(Light::directional(Vec3::ONE, 3.0));
    assert_eq!(scene.technique(), Some("shadow_map"));
    assert_eq!(scene.said(), Vec::<String>::new());
}

#[test]
fn a_technique_without_a_light_is_said() {
    let mut scene = scene();
    let lost = scene.world.spawn(StencilVolume::default()).id();
    scene.run();
    let reports = scene.world.resource::<Reports>();
    let said: Vec<&str> = reports
        .of_entity(lost)
        .map(|report| report.message.as_str())
        .collect();
    assert!(said.len() == 1 && said[0].contains("no light"), "{said:?}");
}

#[test]
fn an_app_takes_techniques_before_and_after_the_plugin_and_each_once() {
    for before in [true, false] {
        let mut app = App::new();
        if before {
            app.add_technique::<Keeper>();
        }
        app.add_plugins(AntumbraPlugin);
        app.add_technique::<Keeper>().add_technique::<Keeper>();
        app.world_mut()
            .spawn((Light::point(Vec3::ONE, 1.0, 5.0), Keeper, Transform::IDENTITY));
        app.update();
        let world = app.world();
        let names: Vec<&str> = world
            .resource::<Techniques>()
            .rows()
            .iter()
            .map(|row| row.name())
            .collect();
        assert_eq!(
            names,
            [
                "stencil_volume",
                "penumbra_wedge",
                "shadow_map",
                "omni_map",
                "smoothie",
                "perspective_map",
                "occlusion_texture",
                "occlusion_interval",
                "keeper"
            ],
            "before: {before}"
        );
        assert_eq!(world.resource::<KeeperRuns>().0, 1);
        let light = &world.resource::<FrameLights>().lights[0];
        assert!(light.is_shadowed_by::<Keeper>());
    }
}
