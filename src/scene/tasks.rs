//! Work on disjoint pieces, spread over all threads if there are several.

#[cfg(feature = "render")]
use std::sync::{Mutex, PoisonError};

use bevy_tasks::ComputeTaskPool;

/// Calls `work` for every piece. The calls run on the threads of the [`ComputeTaskPool`] if `parallel` is set
/// and the app made a pool (`TaskPoolPlugin` does), and otherwise here and in order. Pieces must not share
/// data that they write, so the outcome is the same either way.
///
/// A task costs about a microsecond, and waking a sleeping thread some ten. Pieces should take longer than
/// that.
pub(crate) fn for_each<T: Send>(pieces: impl Iterator<Item = T>, parallel: bool, work: impl Fn(T) + Sync) {
    let pool = ComputeTaskPool::try_get().filter(|pool| parallel && pool.thread_num() > 0);
    let Some(pool) = pool else {
        pieces.for_each(work);
        return;
    };
    let work = &work;
    pool.scope(|scope| {
        for piece in pieces {
            scope.spawn(async move { work(piece) });
        }
    });
}

/// Calls `work` for every piece, as [`for_each`] does, and with threads of its own if the app made no pool. Starting
/// threads takes some 50 microseconds and allocates, so this is for work that is done once.
#[cfg(feature = "render")]
pub(crate) fn for_each_on_all_threads<T: Send>(
    pieces: impl Iterator<Item = T> + Send,
    parallel: bool,
    work: impl Fn(T) + Sync,
) {
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get());
    if !parallel || threads == 1 || ComputeTaskPool::try_get().is_some() {
        for_each(pieces, parallel, work);
        return;
    }
    let pieces = Mutex::new(pieces);
    let take = || pieces.lock().unwrap_or_else(PoisonError::into_inner).next();
    let run = || {
        while let Some(piece) = take() {
            work(piece);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            // Where no thread can be started, this one does the work.
            let _ = std::thread::Builder::new().spawn_scoped(scope, run);
        }
        run();
    });
}
