//! Work on disjoint pieces, on all threads if there are any.

use bevy_tasks::ComputeTaskPool;

/// Calls `work` for every piece: on the threads of the [`ComputeTaskPool`] if `parallel` and the app made one
/// (`TaskPoolPlugin` does), else here and in order. Pieces must not share what they write, so the outcome is the same either way.
///
/// A task costs about a microsecond, and so does a sleeping thread's waking some ten; pieces should take longer.
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
