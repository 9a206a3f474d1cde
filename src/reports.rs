//! Reports: whatever is refused, skipped, short or overflowing, with the entity and what to do about it.
//!
//! Each source of reports is a *topic*. Once a frame a topic goes through a [`Round`]: what is raised in it stands in
//! [`Reports`], and what was raised in the frame before and is not raised again is withdrawn. A host shows a report when
//! it is new and again when its code changes ([`Reports::drain_new`]); the lists themselves are for statistics and tests.
//! A round in which nothing changed allocates nothing.

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

/// Everything that is wrong now.
#[derive(Resource, Clone, Debug, Default)]
pub struct Reports {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug)]
struct Entry {
    report: Report,
    is_new: bool,
    is_raised: bool,
}

impl Reports {
    /// Begins the frame's round of a topic. Its end is when the round is dropped.
    pub fn round(&mut self, topic: &'static str) -> Round<'_> {
        for entry in self
            .entries
            .iter_mut()
            .filter(|entry| entry.report.topic == topic)
        {
            entry.is_raised = false;
        }
        Round { reports: self, topic }
    }

    /// All reports, in the order in which they were first raised.
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

    /// Gives each report that was raised, or changed its code, since it was last given.
    pub fn drain_new(&mut self) -> impl Iterator<Item = &Report> {
        self.entries
            .iter_mut()
            .filter_map(|entry| std::mem::take(&mut entry.is_new).then_some(&entry.report))
    }
}

/// The reports of one topic in one frame.
#[derive(Debug)]
pub struct Round<'a> {
    reports: &'a mut Reports,
    topic: &'static str,
}

impl Round<'_> {
    /// Raises a report. The message is made only if the report is new or its code changed.
    ///
    /// An entity has one report of a topic for each code that is raised in a frame.
    pub fn raise(&mut self, entity: Option<Entity>, code: u32, message: impl FnOnce() -> String) {
        let topic = self.topic;
        let same = |entry: &&mut Entry| {
            let report = &entry.report;
            report.topic == topic && report.entity == entity && report.code == code
        };
        if let Some(entry) = self.reports.entries.iter_mut().find(same) {
            entry.is_raised = true;
            return;
        }
        self.reports.entries.push(Entry {
            report: Report {
                topic,
                entity,
                code,
                message: message(),
            },
            is_new: true,
            is_raised: true,
        });
    }
}

impl Drop for Round<'_> {
    fn drop(&mut self) {
        let topic = self.topic;
        self.reports
            .entries
            .retain(|entry| entry.report.topic != topic || entry.is_raised);
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
}
