//! What the textures of maps hold, or will hold once a recorded frame is submitted.
//!
//! A face counts as drawn from the moment it is recorded, so that the next frame can be prepared before this one is
//! submitted. A host may drop the encoder instead: then what it recorded is taken back, and drawn again.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The revisions of a face that its textures hold; 0 stands for nothing.
#[derive(Clone, Debug, Default)]
pub struct FaceRecord {
    /// The revision of the still layer.
    pub still: Arc<AtomicU64>,
    /// The revision of what is looked up.
    pub shown: Arc<AtomicU64>,
}

/// The faces that one encoder draws.
#[derive(Debug, Default)]
pub struct Recorded {
    faces: Vec<(FaceRecord, u64, u64)>,
}

impl Recorded {
    /// Counts a face as drawn.
    pub fn push(&mut self, record: &FaceRecord, still: u64, shown: u64) {
        record.still.store(still, Ordering::Relaxed);
        record.shown.store(shown, Ordering::Relaxed);
        self.faces.push((record.clone(), still, shown));
    }

    /// Takes the faces back if the encoder, or the command buffer made of it, is dropped without being submitted. In a
    /// frame that draws no face this does nothing.
    pub fn confirm_on_submission(self, encoder: &wgpu::CommandEncoder) {
        if self.faces.is_empty() {
            return;
        }
        // wgpu calls this once the work is done, and drops it uncalled with an encoder that is never submitted.
        let unless_submitted = TakeBack(self.faces);
        encoder.on_submitted_work_done(move || unless_submitted.keep());
    }
}

/// Takes faces back when it is dropped.
struct TakeBack(Vec<(FaceRecord, u64, u64)>);

impl TakeBack {
    fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for TakeBack {
    fn drop(&mut self) {
        for (record, still, shown) in &self.0 {
            // A later frame may have recorded the face again, which counts.
            for (at, revision) in [(&record.still, *still), (&record.shown, *shown)] {
                let _ = at.compare_exchange(revision, 0, Ordering::Relaxed, Ordering::Relaxed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorded(record: &FaceRecord, revision: u64) -> TakeBack {
        let mut recorded = Recorded::default();
        recorded.push(record, revision, revision);
        TakeBack(recorded.faces)
    }

    #[test]
    fn what_is_dropped_is_taken_back_and_what_is_submitted_or_newer_stays() {
        let record = FaceRecord::default();
        let held = |record: &FaceRecord| record.shown.load(Ordering::Relaxed);
        drop(recorded(&record, 3));
        assert_eq!(held(&record), 0);
        recorded(&record, 4).keep();
        assert_eq!(held(&record), 4);
        let older = recorded(&record, 5);
        recorded(&record, 6).keep();
        drop(older);
        assert_eq!(held(&record), 6);
    }
}
