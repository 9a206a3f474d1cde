//! The plugin: the systems of the crate in an [`App`].

use bevy_app::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::TransformSystems;
use bevy_transform::prelude::TransformPlugin;

use crate::schedule::{AntumbraSystems, add_systems, init_resources};
use crate::techniques::{AddTechnique, Row, Technique, add_row};

/// Adds the systems to an [`App`], in `PostUpdate` after transforms are propagated.
///
/// Adds [`TransformPlugin`] if the app does not have it; add this plugin after plugins that bring it. A
/// [`Renderer`](crate::render::Renderer) is a resource that the app inserts when it has a device; without one the CPU
/// side runs alone.
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
/// assert_eq!(lights.lights[0].i.count_ones(..), 1, "the sphere is lit");
/// assert_eq!(lights.lights[0].s.count_ones(..), 1, "and may cast on itself");
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct AntumbraPlugin;

impl Plugin for AntumbraPlugin {
    fn build(&self, app: &mut App) {
        #[cfg(feature = "bevy")]
        if crate::bevy_adapter::install::install(app) {
            return;
        }
        if !app.is_plugin_added::<TransformPlugin>() {
            app.add_plugins(TransformPlugin);
        }
        init_resources(app.world_mut());
        app.edit_schedule(PostUpdate, |schedule| {
            add_systems(schedule);
            schedule.configure_sets(AntumbraSystems::UpdateBounds.after(TransformSystems::Propagate));
        });
    }
}

impl AddTechnique for App {
    /// In an app of Bevy's, lights of Bevy's with the component get their shadows from us; before the first frame.
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
