//! The gallery as tasks, which several threads take one after the other. Each thread draws on a device of its own.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use serde_json::Value;

use super::judge::Workbench;
use super::page::Page;
use super::results::PageResult;
use super::{day, uberlight};

/// A part of the gallery.
pub enum Task<'a> {
    /// A page whose pictures are judged.
    Page(&'a Page),
    /// The looks of the light model, from the shot files of a folder.
    Uberlight(PathBuf),
    /// The sun's day.
    Day,
}

/// The result of a task.
pub enum Done {
    /// Results of a page.
    Page(PageResult),
    /// A scene of the web page, whose pictures have no numbers.
    Look(Value),
}

impl Task<'_> {
    /// # Errors
    /// One line that names the file and the element.
    fn run(&self, bench: &Workbench, out: &Path) -> Result<Done, String> {
        match self {
            Self::Page(page) => bench.judge_page(page, out).map(Done::Page),
            Self::Uberlight(shots) => uberlight::draw(bench, shots, out).map(Done::Look),
            Self::Day => day::draw(bench, out).map(Done::Look),
        }
    }
}

/// Runs all tasks, on one thread for each workbench. Writes pictures to `out`, and calls `finished` with each task and what it
/// has drawn. Returns that in the order of the tasks.
///
/// # Errors
/// The error of the first task that fails. Tasks that have not begun then do not begin.
pub fn run(
    tasks: &[Task],
    benches: &[Workbench],
    out: &Path,
    finished: impl Fn(&Task, &Done) + Sync,
) -> Result<Vec<Done>, String> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(tasks.len()));
    let work = |bench: &Workbench| {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(task) = tasks.get(index) else {
                break;
            };
            let result = task.run(bench, out);
            match &result {
                Ok(done) => finished(task, done),
                Err(_) => next.store(tasks.len(), Ordering::Relaxed),
            }
            if let Ok(mut results) = results.lock() {
                results.push((index, result));
            }
        }
    };
    thread::scope(|scope| {
        for bench in benches {
            scope.spawn(|| work(bench));
        }
    });
    let mut results = results.into_inner().map_err(|_| "a thread has panicked")?;
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
