//! Reports: whatever is refused, skipped, short or overflowing, with the entity and what to do about it.
//!
//! Each source of reports is a *topic*. Once a frame a topic goes through a [`Round`]: what is raised in it stands in
//! [`Reports`], and what was raised in the frame before and is not raised again is withdrawn. A host shows a report when
//! it is new and again when its code changes ([`Reports::drain_new`]); the lists themselves are for statistics and tests.
//! A round in which nothing changed allocates nothing.
//!
//! | topic | about | raised by |
//! | --- | --- | --- |
//! | `light` | lights that cannot shine | [`sets`](crate::sets) |
//! | `object` | objects that are left out | [`sets`](crate::sets) |
//! | `cell` | cells and portals that hide less than they should | [`sets`](crate::sets) |
//! | `caster` | meshes that cast no shadow | [`silhouettes`](crate::silhouettes) |
//! | `mesh` | meshes that the device cannot hold, or that the host cannot give | [`render`](crate::render), the adapter |
//! | `renderer` | a frame or a view that is not drawn | [`render`](crate::render), the adapter |
//! | `technique` | a shadow technique without a light, or two on one light | [`techniques`](crate::techniques) |
//! | a technique's name | what a technique cannot do for a light | [`techniques`](crate::techniques) |

use std::cmp::Ordering;
use std::fmt::{self, Write as _};

use bevy_ecs::prelude::*;

/// One thing that is wrong now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Source of the report, in snake case: `light`, `mesh`, or the name of a technique.
    pub topic: &'static str,
    /// Entity that the report is about; `None` if it is about the frame or the device.
    pub entity: Option<Entity>,
    /// Number of the fault within its topic. A report whose code changes is new.
    pub code: u32,
    /// One or two sentences: what is wrong, and what to do about it.
    pub message: String,
}

/// Everything that is wrong now, ascending by topic, entity and code. Written in the set `PrepareGpu`.
///
/// An app without Bevy's log shows what is new after each frame:
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
/// In a game of Bevy's the resource is in the main world, one frame late, and the plugin logs what is new: a game reads
/// [`Reports::iter`].
#[derive(Resource, Clone, Debug, Default)]
pub struct Reports {
    entries: Vec<Entry>,
    /// Holds a message while it is compared; kept for its allocation.
    line: String,
}

#[derive(Clone, Debug)]
struct Entry {
    report: Report,
    is_new: bool,
    is_raised: bool,
}

impl Reports {
    /// Begins the frame's round of a topic. The round ends when it is dropped.
    pub fn round(&mut self, topic: &'static str) -> Round<'_> {
        self.begin(Some(topic));
        Round { reports: self, topic }
    }

    /// Takes the reports of other lists over, each with the entity that stands for its own here. Reports that are in
    /// none of the lists are withdrawn; of several with one topic, entity and code the first counts.
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

    /// All reports, ascending by topic, entity and code.
    pub fn iter(&self) -> impl Iterator<Item = &Report> {
        self.entries.iter().map(|entry| &entry.report)
    }

    /// Reports of one entity.
    pub fn of_entity(&self, entity: Entity) -> impl Iterator<Item = &Report> {
        self.iter().filter(move |report| report.entity == Some(entity))
    }

    /// Whether [`Reports::drain_new`] would give something.
    pub fn has_new(&self) -> bool {
        self.entries.iter().any(|entry| entry.is_new)
    }

    /// Gives each report that was raised, or changed its code, since it was last given. A report that was withdrawn
    /// before anyone asked is not given.
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

    /// Where a report stands, or belongs.
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
        match self.find(topic, entity, code) {
            Ok(at) => {
                let entry = &mut self.entries[at];
                if std::mem::replace(&mut entry.is_raised, true) {
                    return; // the first one of the round counts
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

/// The reports of one topic in one frame.
#[derive(Debug)]
pub struct Round<'a> {
    reports: &'a mut Reports,
    topic: &'static str,
}

impl Round<'_> {
    /// Raises a report whose message does not change while its code is the same: it is made only if the report is new.
    ///
    /// An entity has one report of a topic for each code that is raised in a frame.
    pub fn raise(&mut self, entity: Option<Entity>, code: u32, message: impl FnOnce() -> String) {
        let topic = self.topic;
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

    /// Raises a report whose message holds numbers that may change: the message follows them, and the report is not new
    /// because of that.
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
