//! System sets and schedules. This file names every system of the core; each technique adds its own systems.

use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_transform::systems::{mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms};
use bevy_transform::{StaticTransformOptimizations, TransformSystems};

use crate::reports::Reports;
use crate::scene::uncleared::report_uncleared;
use crate::scene::{FaceCulling, bounds, pose};
use crate::sets;
use crate::sets::report::report_sets;
use crate::sets::view::seen_into;
use crate::sets::{FrameLights, SeenInto};
use crate::silhouettes::report::{RefusedCasters, report_buried_origins, report_casters};
use crate::silhouettes::{
    BuriedOrigins, CasterMeshes, CoincidentCasters, Silhouettes, buried, cache, casters, coincident,
};
use crate::techniques::registry::companions::{keep_companions, limit_companions};
use crate::techniques::registry::report::report_techniques;
use crate::techniques::shared::texture_memory::{self, TextureMemory, report::report_texture_memory};
use crate::techniques::{LeavingSystems, TechniqueSystems, Techniques, choose_techniques};

/// The stages of a frame as system sets, chained in this order. Each set says what is true after it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraSystems {
    /// After this set every object's [`WorldBounds`](crate::scene::WorldBounds) fit its pose and transform in
    /// this frame.
    UpdateBounds,
    /// After this set the view and every light have their sets F, V, L, I, S, scissors and depth bounds.
    CollectSets,
    /// After this set every caster that some light needs has its silhouette.
    BuildSilhouettes,
    /// After this set every technique has its geometry on the CPU.
    BuildTechniques,
    /// After this set the GPU holds everything that the frame draws, and [`Reports`] holds everything that is
    /// wrong with the frame.
    PrepareGpu,
}

impl AntumbraSystems {
    /// All sets in the order in which they run.
    pub const ALL: [Self; 5] = [
        Self::UpdateBounds,
        Self::CollectSets,
        Self::BuildSilhouettes,
        Self::BuildTechniques,
        Self::PrepareGpu,
    ];

    /// Name of the set in statistics, in snake case.
    pub fn name(self) -> &'static str {
        match self {
            Self::UpdateBounds => "update_bounds",
            Self::CollectSets => "collect_sets",
            Self::BuildSilhouettes => "build_silhouettes",
            Self::BuildTechniques => "build_techniques",
            Self::PrepareGpu => "prepare_gpu",
        }
    }
}

/// CPU time of each set in the last frame.
#[derive(Resource, Clone, Debug, Default)]
pub struct SetTimes {
    /// CPU time of each set, in the order of [`AntumbraSystems::ALL`].
    pub durations: [Duration; 5],
    last: Option<Instant>,
}

/// The label of [`standalone_schedule`].
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct AntumbraSchedule;

/// Inserts the missing ones of the resources that the systems need.
pub fn init_resources(world: &mut World) {
    world.init_resource::<StaticTransformOptimizations>(); // as `TransformPlugin` does
    sets::init_set_resources(world);
    world.init_resource::<SeenInto>();
    world.init_resource::<seen_into::SeeThrough>();
    world.init_resource::<FaceCulling>();
    world.init_resource::<CasterMeshes>();
    world.init_resource::<CoincidentCasters>();
    world.init_resource::<Silhouettes>();
    world.init_resource::<BuriedOrigins>();
    world.init_resource::<SetTimes>();
    world.init_resource::<Reports>();
    world.init_resource::<TextureMemory>();
    world.init_resource::<Techniques>();
    for row in world.resource::<Techniques>().rows().to_vec() {
        row.init(world);
    }
}

/// Builds a schedule of transform propagation and all systems of the crate, for an engine without an `App`.
///
/// ```
/// use antumbra::schedule::{init_resources, standalone_schedule};
/// use antumbra::prelude::*;
/// use bevy_ecs::prelude::*;
/// use bevy_transform::prelude::Transform;
///
/// let mut world = World::new();
/// init_resources(&mut world);
/// world.insert_resource(ViewportSize(glam::UVec2::new(320, 180)));
/// world.spawn((Camera::default(), Transform::from_xyz(0.0, 1.0, 5.0)));
///
/// let mut schedule = standalone_schedule();
/// schedule.run(&mut world); // once a frame
/// world.clear_trackers(); // after all schedules of the frame
/// assert!(world.resource::<antumbra::sets::View>().data.is_some());
/// ```
pub fn standalone_schedule() -> Schedule {
    let mut schedule = Schedule::new(AntumbraSchedule);
    schedule.configure_sets(TransformSystems::Propagate.before(AntumbraSystems::UpdateBounds));
    schedule.add_systems(
        (
            mark_dirty_trees,
            propagate_parent_transforms,
            sync_simple_transforms,
        )
            .chain()
            .in_set(TransformSystems::Propagate),
    );
    add_systems(&mut schedule);
    schedule
}

/// Adds all systems of the crate to a schedule, in the chained sets [`AntumbraSystems`]. Transforms must be
/// propagated before [`AntumbraSystems::UpdateBounds`].
pub fn add_systems(schedule: &mut Schedule) {
    let [update, collect, silhouettes, techniques, prepare] = AntumbraSystems::ALL;
    schedule.configure_sets((update, collect, silhouettes, techniques, prepare).chain());
    schedule.add_systems((
        (
            pose::pose_meshes,
            bounds::update_local_bounds,
            bounds::update_world_bounds,
        )
            .chain()
            .in_set(update),
        (sets::collect_sets(), seen_into::collect_seen_into)
            .chain()
            .in_set(collect),
        (
            casters::build_caster_edges,
            casters::update_posed_planes,
            coincident::find_coincident_casters,
            cache::build_silhouettes,
            buried::find_buried_origins,
        )
            .chain()
            .in_set(silhouettes),
        keep_companions
            .after(sets::collect_visible_set)
            .before(sets::collect_frame_lights)
            .in_set(collect),
        (choose_techniques, limit_companions)
            .chain()
            .after(sets::collect_frame_lights)
            .before(sets::collect_light_sets)
            .in_set(collect),
        sets::fit_view_depth.in_set(prepare),
    ));
    schedule.configure_sets((
        TechniqueSystems.in_set(techniques),
        LeavingSystems
            .after(choose_techniques)
            .before(limit_companions)
            .in_set(collect),
    ));
    texture_memory::systems::add(schedule, TechniqueSystems);
    for row in Techniques::default().rows() {
        row.add_systems(schedule);
    }
    #[cfg(feature = "render")]
    {
        use crate::render::Renderer;
        use crate::render::frame::{prepare, prepare_draws};
        schedule.add_systems(
            (
                prepare::prepare_objects.after(sets::fit_view_depth),
                crate::techniques::registry::recorders::add_recorders,
                prepare::prepare_techniques,
                prepare_draws::prepare_draws,
            )
                .chain()
                .run_if(resource_exists::<Renderer>)
                .in_set(prepare),
        );
    }
    let collect = collect_reports.after(sets::fit_view_depth).in_set(prepare);
    #[cfg(feature = "render")]
    let collect = collect.after(crate::render::frame::prepare_draws::prepare_draws);
    schedule.add_systems(collect);
    schedule.add_systems(begin_times.after(TransformSystems::Propagate).before(update));
    for (index, set) in AntumbraSystems::ALL.into_iter().enumerate() {
        let stamp = move |mut times: ResMut<SetTimes>| times.stamp(index);
        let system = stamp.after(set);
        match AntumbraSystems::ALL.get(index + 1) {
            Some(next) => schedule.add_systems(system.before(*next)),
            None => schedule.add_systems(system),
        };
    }
}

/// Collects everything that is wrong in this frame.
///
/// Set: `PrepareGpu`, last. The system is exclusive, because it asks every source of reports, and techniques
/// read whatever resources they like. In a frame that changes nothing it allocates nothing and compares at
/// most one message for each report.
pub fn collect_reports(world: &mut World, casters: &mut RefusedCasters) {
    world.resource_scope(|world, mut reports: Mut<Reports>| {
        let reports = reports.bypass_change_detection();
        let lights = &world.resource::<FrameLights>().lights;
        let companions = lights
            .iter()
            .filter_map(|light| Some((light.entity, light.companion_of?.light)));
        reports.stand_in(companions);
        #[cfg(feature = "gltf")]
        crate::scene::gltf_import::report_imports(world, reports);
        report_uncleared(world, reports);
        report_sets(world, reports);
        casters.update_archetypes(world);
        report_casters(world, casters, reports);
        report_buried_origins(world, reports);
        report_techniques(world, reports);
        report_texture_memory(world, reports);
        #[cfg(feature = "render")]
        crate::render::report::report_renderer(world, reports);
    });
}

fn begin_times(mut times: ResMut<SetTimes>) {
    times.last = Some(Instant::now());
}

impl SetTimes {
    fn stamp(&mut self, index: usize) {
        let now = Instant::now();
        if let Some(last) = self.last.replace(now) {
            self.durations[index] = now - last;
        }
    }
}
