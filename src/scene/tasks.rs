//! Work on disjoint pieces, spread over all threads if there are several.

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
