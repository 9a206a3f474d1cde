//! Copies the reports of the mirrors and of the adapter to the game's [`Reports`], and logs each new one
//! once.

use bevy::ecs::prelude::*;
use bevy::ecs::world::EntityRef;
use bevy::render::MainWorld;

use super::cut_outs::CutOutCasters;
use super::forward_masks::MAX_KEPT;
use super::light_convert::convert_light;
use super::mirror::{HostEntity, Mirror, Mirrors};
use super::refused::RefusedMeshes;
use crate::render::report::raise_failure;
use crate::reports::{Report, Reports};
use crate::techniques::Techniques;

/// Entities of the game that have a shadow technique but no light, in ascending order. The resource is in the
/// render world and is updated when lights are synchronised.
#[derive(Resource, Debug, Default)]
pub struct LightlessTechniques(Vec<Entity>);

impl LightlessTechniques {
    /// Updates the list for an entity whose light or technique may have changed. `light` is `None` if the
    /// entity is gone.
    pub(super) fn look_at(&mut self, entity: Entity, light: Option<&EntityRef>, techniques: &Techniques) {
        let lacks_light = light
            .is_some_and(|light| techniques.on(*light).next().is_some() && convert_light(light).is_none());
        match (self.0.binary_search(&entity), lacks_light) {
            (Err(at), true) => self.0.insert(at, entity),
            (Ok(at), false) => {
                self.0.remove(at);
            }
            _ => {}
        }
    }
}

/// Copies the reports of all views' last frame to the game's [`Reports`], with the game's entities, and logs
/// the new ones as warnings. If several cameras report the same fault of an entity, it is reported once.
///
/// Runs in `ExtractSchedule`, before [`Collect`](super::AntumbraExtractSystems::Collect), while the mirrors
/// are still those that ran.
pub(super) fn publish_reports(
    mut main: ResMut<MainWorld>,
    mirrors: Res<Mirrors>,
    refused: Res<RefusedMeshes>,
    lightless: Res<LightlessTechniques>,
    cut_outs: Res<CutOutCasters>,
    mut own: Local<Reports>,
    mut log: Local<Log>,
) {
    refused.raise(&mut own);
    cut_outs.raise(&mirrors, &mut own);
    raise_lightless(&lightless, &mut own);
    raise_views(&mirrors, &mut own);
    let Some(mut all) = main.get_resource_mut::<Reports>() else {
        return;
    };
    let all = all.bypass_change_detection();
    let of_views = mirrors
        .iter()
        .flat_map(|(camera, mirror)| reports_of_view(camera, mirror));
    all.gather(own.iter().map(|report| (report.entity, report)).chain(of_views));
    log.begin_frame();
    if all.has_new() {
        let mut all = std::mem::take(all);
        for report in all.drain_new() {
            log.warn(&main, report);
        }
        main.insert_resource(all);
    }
}

fn raise_lightless(lightless: &LightlessTechniques, own: &mut Reports) {
    let mut round = own.round("technique");
    for &entity in &lightless.0 {
        round.raise(Some(entity), 1, || {
            "The shadow technique has no effect: the entity has no light. Put it on the entity with the PointLight, \
             SpotLight, DirectionalLight or RectLight."
                .to_owned()
        });
    }
}

fn raise_views(mirrors: &Mirrors, own: &mut Reports) {
    let mut round = own.round("renderer");
    for (camera, mirror) in mirrors.iter() {
        if let Some(error) = &mirror.view.failed {
            raise_failure(&mut round, Some(camera), error);
            continue;
        }
        if mirror.view.unkept_lights > 0 {
            round.raise(Some(camera), UNKEPT_LIGHTS, || {
                format!(
                    "Meshes that are drawn forward show the shadows of {MAX_KEPT} lights only, and the camera has more. Give \
                     their materials a deferred shader, or use fewer lights with a technique."
                )
            });
        }
        if mirror.view.odd_projection {
            round.raise(Some(camera), ODD_PROJECTION, || {
                "The camera shows no shadows of ours: its projection is neither perspective nor orthographic. Give it a \
                 PerspectiveProjection or an OrthographicProjection."
                    .to_owned()
            });
        }
    }
}

/// Report code of a camera with an unsupported projection. It is greater than the codes of [`raise_failure`].
const ODD_PROJECTION: u32 = 100;

/// Report code of a camera with more managed lights than forward meshes can show.
const UNKEPT_LIGHTS: u32 = 101;

/// Yields the reports of a mirror with the game's entities. Reports about entities that are gone are left
/// out.
fn reports_of_view(camera: Entity, mirror: &Mirror) -> impl Iterator<Item = (Option<Entity>, &Report)> {
    let reports = mirror.world.get_resource::<Reports>();
    reports
        .into_iter()
        .flat_map(Reports::iter)
        .filter_map(move |report| match report.entity {
            None => Some((None, report)),
            Some(entity) if entity == mirror.camera => Some((Some(camera), report)),
            Some(entity) => {
                let host = mirror.world.get::<HostEntity>(entity)?;
                Some((Some(host.0), report))
            }
        })
}

/// Number of frames in which a topic logs at most [`LINES`] lines, so that a fault in every frame does not
/// flood the log.
const FRAMES: u64 = 600;

/// Largest number of lines that a topic logs in [`FRAMES`] frames.
const LINES: u32 = 32;

/// Counts of the lines that were logged lately, by topic.
#[derive(Debug, Default)]
pub struct Log {
    frame: u64,
    topics: Vec<Topic>,
}

#[derive(Debug)]
struct Topic {
    name: &'static str,
    since: u64,
    lines: u32,
}

impl Log {
    fn begin_frame(&mut self) {
        self.frame += 1;
    }

    /// Counts a line of a topic. Returns `None` if the line must not be logged, otherwise whether it is the
    /// last for a while.
    fn admit(&mut self, topic: &'static str) -> Option<bool> {
        let frame = self.frame;
        let at = self.topics.iter().position(|known| known.name == topic);
        let at = at.unwrap_or_else(|| {
            self.topics.push(Topic {
                name: topic,
                since: frame,
                lines: 0,
            });
            self.topics.len() - 1
        });
        let known = &mut self.topics[at];
        if frame - known.since >= FRAMES {
            (known.since, known.lines) = (frame, 0);
        }
        known.lines += 1;
        (known.lines <= LINES).then_some(known.lines == LINES)
    }

    fn warn(&mut self, main: &World, report: &Report) {
        let Some(is_last) = self.admit(report.topic) else {
            return;
        };
        let Report {
            topic,
            entity,
            message,
            ..
        } = report;
        let rest = if is_last {
            " (more of this kind is not logged for some seconds; `Reports` has it)"
        } else {
            ""
        };
        match entity.map(|entity| (entity, main.get::<Name>(entity))) {
            Some((entity, Some(name))) => tracing::warn!("{topic}: `{name}` ({entity}): {message}{rest}"),
            Some((entity, None)) => tracing::warn!("{topic}: entity {entity}: {message}{rest}"),
            None => tracing::warn!("{topic}: {message}{rest}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_has_so_many_lines_in_a_while() {
        let mut log = Log::default();
        let mut admitted = 0;
        for _ in 0..FRAMES {
            log.begin_frame();
            admitted += u32::from(log.admit("light").is_some());
        }
        assert_eq!(admitted, LINES);
        assert_eq!(
            log.admit("mesh"),
            Some(false),
            "another topic has lines of its own"
        );
        log.begin_frame();
        assert_eq!(log.admit("light"), Some(false), "later it may speak again");
    }
}
