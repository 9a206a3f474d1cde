//! Reports about everything that is refused, skipped, limited or overflowing. A report names the entity and
//! says what to do about it.
//!
//! Each source of reports is a *topic*. Once a frame a topic goes through a [`Round`]. [`Reports`] holds the
//! reports that were raised in the latest round; a report of the frame before that is not raised again is
//! withdrawn. A host shows a report when it is new and again when its code changes ([`Reports::drain_new`]).
//! Statistics and tests read the whole list. A round in which nothing changed allocates nothing.
//!
//! | topic | about | raised by |
//! | --- | --- | --- |
//! | `import` | what was left out of glTF files | [`scene`](crate::scene) |
//! | `light` | lights that cannot shine | [`sets`](crate::sets) |
//! | `light_model` | parts of a light's model that have no effect | [`sets`](crate::sets) |
//! | `object` | objects that are neither drawn nor cast shadows | [`sets`](crate::sets) |
//! | `cell` | cells and portals that hide less than they should | [`sets`](crate::sets) |
//! | `caster` | meshes that cast no shadow | [`silhouettes`](crate::silhouettes) |
//! | `shadow_origin` | lights whose shadows are cast from inside of a caster | [`silhouettes`](crate::silhouettes) |
//! | `mesh` | meshes that the device cannot hold, or whose data the host cannot give | [`render`](crate::render), the adapter |
//! | `material` | materials whose holes some lights do not see | the adapter |
//! | `renderer` | a frame or a view that is not drawn | [`render`](crate::render), the adapter |
//! | `technique` | a shadow technique without a light, or several on one light | [`techniques`](crate::techniques), the adapter |
//! | `texture_memory` | lights with poorer shadows, or none, because memory for textures is short | [`techniques`](crate::techniques) |
//! | `texture` | textures of materials and cookies that are shown at a smaller size than they have | [`render`](crate::render) |
//! | `world` | removals of components that the world keeps for ever | [`schedule`](crate::schedule) |
//! | a technique's name | lights whose shadow is refused or reduced by the technique | [`techniques`](crate::techniques) |

use std::cmp::Ordering;
use std::fmt::{self, Write as _};

use bevy_ecs::prelude::*;

/// A report about one thing that is wrong now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Source of the report, in snake case: `light`, `mesh`, or the name of a technique.
    pub topic: &'static str,
    /// Entity that the report is about; `None` if it is about the frame or the device.
    pub entity: Option<Entity>,
    /// Number of the fault within its topic, often that of a kind of fault, or one by [`code_of`]. A report whose
    /// code changes is new.
    pub code: u32,
    /// One or two sentences that say what is wrong and what to do about it.
    pub message: String,
}

/// Returns the code of a fault of a named thing, like a setting or a mesh. With it, a fault of another thing is new, even if it
/// is of the same `kind` and about the same entity.
///
/// Codes of names are 2³¹ or greater. Two names hardly ever have the same.
///
/// Source: Fowler, Noll & Vo 1991, the hash FNV-1a.
pub fn code_of(kind: u32, name: &str) -> u32 {
    let bytes = kind.to_le_bytes().into_iter().chain(name.bytes());
    let hash = bytes.fold(0x811c_9dc5_u32, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    hash | (1 << 31)
}

/// Everything that is wrong now, sorted by topic, entity and code. The set `PrepareGpu` writes it.
///
/// An app without Bevy's log shows new reports after each frame:
///
/// ```
/// # use antumbra::prelude::*;
/// # use antumbra::reports::Reports;
/// # use bevy_transform::prelude::Transform;
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(AntumbraPlugin);
/// # app.world_mut().spawn((Light::point(glam::Vec3::ONE, 10.0, 0.0), Transform::default()));
/// app.update();
/// let mut reports = app.world_mut().resource_mut::<Reports>();
/// for report in reports.drain_new() {
///     eprintln!("{} {:?}: {}", report.topic, report.entity, report.message);
/// }
/// # drop(reports);
/// # assert_eq!(app.world().resource::<Reports>().iter().count(), 1);
/// ```
///
/// In a Bevy game the resource is in the main world and one frame late. The plugin takes the new reports and
/// logs them, so a game reads [`Reports::iter`].
#[derive(Resource, Clone, Debug, Default)]
pub struct Reports {
    entries: Vec<Entry>,
    /// Scratch space for a message while it is compared. It is kept to reuse its allocation.
    line: String,
    /// Entities of the crate's own, in ascending order, each with the entity that reports about it are about.
    stand_ins: Vec<(Entity, Entity)>,
}

#[derive(Clone, Debug)]
struct Entry {
    report: Report,
    is_new: bool,
    is_raised: bool,
}

impl Reports {
    /// Begins this frame's round of a topic. The round ends when it is dropped.
    pub fn round(&mut self, topic: &'static str) -> Round<'_> {
        self.begin(Some(topic));
        Round { reports: self, topic }
    }

    /// From now on, reports about the first entity of a pair are about the second one.
    pub(crate) fn stand_in(&mut self, pairs: impl Iterator<Item = (Entity, Entity)>) {
        self.stand_ins.clear();
        self.stand_ins.extend(pairs);
        self.stand_ins.sort_unstable();
    }

    /// Returns the entity that a report about an entity is about.
    fn subject(&self, entity: Option<Entity>) -> Option<Entity> {
        let entity = entity?;
        let at = self.stand_ins.binary_search_by_key(&entity, |(own, _)| *own);
        Some(at.map_or(entity, |at| self.stand_ins[at].1))
    }

    /// Replaces all reports by those of other lists, each given with the entity that it is about in this
    /// world. Reports that are in none of the lists are withdrawn. If several have the same topic, entity and
    /// code, the first counts.
    pub fn gather<'a>(&mut self, all: impl IntoIterator<Item = (Option<Entity>, &'a Report)>) {
        self.begin(None);
        for (entity, report) in all {
            self.state(
                report.topic,
                entity,
                report.code,
                format_args!("{}", report.message),
            );
        }
        self.end(None);
    }

    /// Yields all reports, sorted by topic, entity and code.
    pub fn iter(&self) -> impl Iterator<Item = &Report> {
        self.entries.iter().map(|entry| &entry.report)
    }

    /// Yields the reports about one entity.
    pub fn of_entity(&self, entity: Entity) -> impl Iterator<Item = &Report> {
        self.iter().filter(move |report| report.entity == Some(entity))
    }

    /// Whether [`Reports::drain_new`] would yield anything.
    pub fn has_new(&self) -> bool {
        self.entries.iter().any(|entry| entry.is_new)
    }

    /// Yields each new report once. A report is new when it is first raised and again when its code changes.
    /// A report that was withdrawn before this call is not yielded.
    pub fn drain_new(&mut self) -> impl Iterator<Item = &Report> {
        self.entries
            .iter_mut()
            .filter_map(|entry| std::mem::take(&mut entry.is_new).then_some(&entry.report))
    }

    fn begin(&mut self, topic: Option<&str>) {
        for entry in &mut self.entries {
            entry.is_raised &= topic.is_some_and(|topic| entry.report.topic != topic);
        }
    }

    fn end(&mut self, topic: Option<&str>) {
        self.entries
            .retain(|entry| entry.is_raised || topic.is_some_and(|topic| entry.report.topic != topic));
    }

    /// Returns the index of a report, or as an error the index at which to insert it.
    fn find(&self, topic: &str, entity: Option<Entity>, code: u32) -> Result<usize, usize> {
        self.entries.binary_search_by(|entry| -> Ordering {
            let report = &entry.report;
            (report.topic, report.entity, report.code).cmp(&(topic, entity, code))
        })
    }

    fn insert(&mut self, at: usize, report: Report) {
        self.entries.insert(
            at,
            Entry {
                report,
                is_new: true,
                is_raised: true,
            },
        );
    }

    fn state(&mut self, topic: &'static str, entity: Option<Entity>, code: u32, message: fmt::Arguments<'_>) {
        let entity = self.subject(entity);
        match self.find(topic, entity, code) {
            Ok(at) => {
                let entry = &mut self.entries[at];
                if std::mem::replace(&mut entry.is_raised, true) {
                    return; // the first message of the round counts
                }
                self.line.clear();
                let written = self.line.write_fmt(message);
                if written.is_ok() && self.line != entry.report.message {
                    entry.report.message.clone_from(&self.line);
                }
            }
            Err(at) => self.insert(
                at,
                Report {
                    topic,
                    entity,
                    code,
                    message: message.to_string(),
                },
            ),
        }
    }
}

/// A round, in which the reports of one topic are raised for one frame.
#[derive(Debug)]
pub struct Round<'a> {
    reports: &'a mut Reports,
    topic: &'static str,
}

impl Round<'_> {
    /// Raises a report whose message stays the same while its entity and code do. The message is built only if the
    /// report is new. A message with a value that may change goes through [`Round::state`], or an old value stays in it.
    ///
    /// An entity has one report of the topic for each code that is raised in the frame.
    pub fn raise(&mut self, entity: Option<Entity>, code: u32, message: impl FnOnce() -> String) {
        let topic = self.topic;
        let entity = self.reports.subject(entity);
        match self.reports.find(topic, entity, code) {
            Ok(at) => self.reports.entries[at].is_raised = true,
            Err(at) => self.reports.insert(
                at,
                Report {
                    topic,
                    entity,
                    code,
                    message: message(),
                },
            ),
        }
    }

    /// Raises a report whose message holds numbers that may change. The message is updated, and a change of
    /// its numbers alone does not make the report new. If the message names a thing that may become another, take its
    /// code from [`code_of`], so that a fault of the other is new.
    pub fn state(&mut self, entity: Option<Entity>, code: u32, message: fmt::Arguments<'_>) {
        self.reports.state(self.topic, entity, code, message);
    }
}

impl Drop for Round<'_> {
    fn drop(&mut self) {
        self.reports.end(Some(self.topic));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_new_once_and_again_when_its_code_changes() {
        let mut reports = Reports::default();
        let frame = |reports: &mut Reports, code: Option<u32>| {
            let mut round = reports.round("light");
            if let Some(code) = code {
                round.raise(None, code, || format!("fault {code}"));
            }
            drop(round);
            let new: Vec<String> = reports.drain_new().map(|report| report.message.clone()).collect();
            (new, reports.iter().count())
        };
        let fault = |code: u32| vec![format!("fault {code}")];
        assert_eq!(frame(&mut reports, Some(1)), (fault(1), 1));
        assert_eq!(frame(&mut reports, Some(1)), (vec![], 1));
        assert_eq!(frame(&mut reports, Some(2)), (fault(2), 1));
        assert_eq!(frame(&mut reports, None), (vec![], 0));
        assert_eq!(frame(&mut reports, Some(2)), (fault(2), 1));
    }

    #[test]
    fn rounds_leave_other_topics_alone() {
        let mut reports = Reports::default();
        reports.round("light").raise(None, 0, || "a".to_owned());
        reports.round("mesh").raise(None, 0, || "b".to_owned());
        drop(reports.round("mesh"));
        let left: Vec<_> = reports.iter().map(|report| report.topic).collect();
        assert_eq!(left, ["light"]);
    }

    #[test]
    fn a_message_follows_its_numbers_and_is_not_new() {
        let mut reports = Reports::default();
        for bytes in [1, 1, 2] {
            reports
                .round("mesh")
                .state(None, 0, format_args!("{bytes} bytes"));
        }
        assert_eq!(reports.drain_new().count(), 1);
        reports.round("mesh").state(None, 0, format_args!("3 bytes"));
        assert_eq!(reports.drain_new().count(), 0);
        assert_eq!(reports.iter().next().unwrap().message, "3 bytes");
    }

    #[test]
    fn a_fault_of_another_name_is_new() {
        let mut reports = Reports::default();
        let mut is_new = |kind: u32, name: &str| {
            let message = format_args!("{name} is wrong");
            reports.round("mesh").state(None, code_of(kind, name), message);
            let is_new = reports.drain_new().count() == 1;
            assert_eq!(reports.iter().count(), 1);
            is_new
        };
        let steps = [
            (1, "near"),
            (1, "near"),
            (1, "softness"),
            (2, "softness"),
            (1, "near"),
        ];
        assert_eq!(
            steps.map(|(kind, name)| is_new(kind, name)),
            [true, false, true, true, true]
        );
    }

    #[test]
    fn the_order_does_not_tell_who_was_first() {
        let entities = [7, 3, 5].map(|row| Entity::from_raw_u32(row).unwrap());
        let of = |order: [usize; 3]| {
            let mut reports = Reports::default();
            let mut round = reports.round("light");
            for at in order {
                round.raise(Some(entities[at]), 1, String::new);
            }
            drop(round);
            reports.iter().cloned().collect::<Vec<_>>()
        };
        assert_eq!(of([0, 1, 2]), of([2, 1, 0]));
    }

    #[test]
    fn several_lists_become_one_and_what_none_has_is_withdrawn() {
        let list = |codes: &[u32]| {
            let mut reports = Reports::default();
            let mut round = reports.round("light");
            codes
                .iter()
                .for_each(|&code| round.raise(None, code, || format!("fault {code}")));
            drop(round);
            reports
        };
        let mut all = Reports::default();
        let gather = |all: &mut Reports, lists: &[Reports]| {
            all.gather(lists.iter().flat_map(Reports::iter).map(|report| (None, report)));
            let codes: Vec<u32> = all.iter().map(|report| report.code).collect();
            (codes, all.drain_new().count())
        };
        assert_eq!(
            gather(&mut all, &[list(&[1, 2]), list(&[2, 3])]),
            (vec![1, 2, 3], 3)
        );
        assert_eq!(gather(&mut all, &[list(&[2]), list(&[2, 3])]), (vec![2, 3], 0));
        assert_eq!(gather(&mut all, &[list(&[1])]), (vec![1], 1));
    }
}
