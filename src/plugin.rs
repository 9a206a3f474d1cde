//! The plugin, which adds the systems of the crate to an [`App`].

use bevy_app::prelude::*;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_transform::TransformSystems;
use bevy_transform::prelude::TransformPlugin;
use bevy_transform::systems::{mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms};

use crate::schedule::{AntumbraSystems, add_systems, init_resources};
use crate::techniques::{AddTechnique, Row, Technique, add_row};

/// Adds the systems of the crate to an [`App`], in `PostUpdate` after transforms are propagated.
///
/// The plugin can be added before or after other plugins. If the finished app has [`TransformPlugin`], that
/// plugin propagates transforms; otherwise this plugin does. In an app with Bevy's renderer the systems do
/// not run in `PostUpdate`, but in the render world, once for each marked camera.
///
/// The app inserts a [`Renderer`](crate::render::Renderer) as a resource when it has a device. Without a
/// renderer only the CPU side runs.
///
/// ```
/// use antumbra::prelude::*;
/// use bevy_app::App;
/// use bevy_transform::prelude::Transform;
/// use std::sync::Arc;
///
/// let mut app = App::new();
/// app.add_plugins(AntumbraPlugin);
/// app.insert_resource(ViewportSize(glam::UVec2::new(320, 180)));
/// app.world_mut().spawn((
///     SceneMesh(Arc::new(MeshData::icosphere(1.0, 3))),
///     SceneMaterials([Arc::new(Material::matte(glam::Vec3::ONE))].into()),
///     (ShadowCaster, ShadowReceiver),
/// ));
/// app.world_mut().spawn((Camera::default(), Transform::from_xyz(0.0, 0.0, 5.0)));
/// app.world_mut().spawn((
///     Light::point(glam::Vec3::ONE, 100.0, 20.0),
///     StencilVolume::default(),
///     Transform::from_xyz(0.0, 3.0, 3.0),
/// ));
/// app.update();
///
/// let lights = app.world().resource::<FrameLights>();
/// assert_eq!(lights.lights[0].sets.i.count_ones(..), 1, "the sphere is lit");
/// assert_eq!(lights.lights[0].sets.s.count_ones(..), 1, "and may cast on itself");
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct AntumbraPlugin;

impl Plugin for AntumbraPlugin {
    fn build(&self, app: &mut App) {
        #[cfg(feature = "bevy")]
        {
            crate::bevy_adapter::install::register(app);
            if crate::bevy_adapter::install::install(app) {
                return;
            }
        }
        add_core(app);
    }

    fn finish(&self, app: &mut App) {
        #[cfg(feature = "bevy")]
        crate::bevy_adapter::install::install(app);
        if app.is_plugin_added::<TransformPlugin>() {
            app.world_mut().remove_resource::<PropagatesTransforms>();
        }
    }
}

/// Adds the systems of the core. They run unless the app gets Bevy's renderer before it is finished.
fn add_core(app: &mut App) {
    if !app.is_plugin_added::<TransformPlugin>() {
        app.insert_resource(PropagatesTransforms);
        app.add_schedule(transform_schedule());
        let propagate = || {
            propagate_transforms
                .in_set(TransformSystems::Propagate)
                .run_if(resource_exists::<PropagatesTransforms>)
        };
        app.add_systems(PostStartup, propagate());
        app.add_systems(PostUpdate, propagate());
    }
    init_resources(app.world_mut());
    app.edit_schedule(PostUpdate, |schedule| {
        add_systems(schedule);
        schedule.configure_sets(AntumbraSystems::UpdateBounds.after(TransformSystems::Propagate));
        #[cfg(feature = "bevy")]
        for set in AntumbraSystems::ALL {
            let installed = resource_exists::<crate::bevy_adapter::systems::Installed>;
            schedule.configure_sets(set.run_if(not(installed)));
        }
    });
}

/// Marks an app without [`TransformPlugin`], in which this plugin propagates transforms. Adding that plugin
/// here would forbid the app to add it later.
#[derive(Resource)]
struct PropagatesTransforms;

/// Label of the schedule that propagates transforms in place of [`TransformPlugin`].
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct PropagateTransforms;

fn transform_schedule() -> Schedule {
    let mut schedule = Schedule::new(PropagateTransforms);
    schedule.add_systems(
        (
            mark_dirty_trees,
            propagate_parent_transforms,
            sync_simple_transforms,
        )
            .chain(),
    );
    schedule
}

fn propagate_transforms(world: &mut World) {
    world.run_schedule(PropagateTransforms);
}

impl AddTechnique for App {
    /// Adds the technique `T` to the app. Call it before the first frame. In an app with Bevy's renderer,
    /// Bevy's lights with the component `T` then get their shadows from this crate.
    fn add_technique<T: Technique>(&mut self) -> &mut Self {
        #[cfg(feature = "bevy")]
        if crate::bevy_adapter::techniques::add_technique::<T>(self) {
            return self;
        }
        let mut schedule = self
            .world_mut()
            .resource_mut::<Schedules>()
            .remove(PostUpdate)
            .unwrap_or_else(|| Schedule::new(PostUpdate));
        add_row(Row::of::<T>(), self.world_mut(), &mut schedule);
        self.world_mut().resource_mut::<Schedules>().insert(schedule);
        self
    }
}
