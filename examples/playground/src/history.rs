//! Undo and redo: the documents before and after each change.

use crate::document::Document;

/// Number of changes that can be undone; older ones are forgotten.
const DEPTH: usize = 200;

/// Documents before and after the current one.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Document>,
    future: Vec<Document>,
    /// Name of the change in progress, such as the drag of one light. It is undone in one step.
    open: Option<String>,
}

impl History {
    /// Remembers the document before a change. Changes of the same name that follow one another are one, until
    /// [`History::close`].
    pub fn record(&mut self, name: &str, before: &Document) {
        if self.open.as_deref() == Some(name) {
            return;
        }
        self.open = Some(name.to_owned());
        if self.past.len() == DEPTH {
            self.past.remove(0);
        }
        self.past.push(before.clone());
        self.future.clear();
    }

    /// Ends the change in progress, so that the next one is undone by itself.
    pub fn close(&mut self) {
        self.open = None;
    }

    /// Forgets all changes, as when another scene is opened.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether there is anything to undo, and anything to redo.
    pub fn steps(&self) -> (usize, usize) {
        (self.past.len(), self.future.len())
    }

    /// Goes one change back. Returns whether there was one.
    pub fn undo(&mut self, now: &mut Document) -> bool {
        self.close();
        step(&mut self.past, &mut self.future, now)
    }

    /// Goes one change forward. Returns whether there was one.
    pub fn redo(&mut self, now: &mut Document) -> bool {
        self.close();
        step(&mut self.future, &mut self.past, now)
    }
}

fn step(from: &mut Vec<Document>, to: &mut Vec<Document>, now: &mut Document) -> bool {
    let Some(other) = from.pop() else {
        return false;
    };
    to.push(std::mem::replace(now, other));
    true
}
