//! GPU resources in use, by index and by the key from which they were made.

use std::collections::HashMap;
use std::hash::Hash;

/// Entries with stable indices. Use is counted anew from [`Slots::begin`] to [`Slots::end`]: entries that
/// were not requested between the two calls are freed, and their indices are reused.
#[derive(Debug)]
pub struct Slots<K, T> {
    entries: Vec<Option<T>>,
    used: Vec<bool>,
    free: Vec<u32>,
    by_key: HashMap<K, u32>,
}

impl<K, T> Default for Slots<K, T> {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            used: Vec::new(),
            free: Vec::new(),
            by_key: HashMap::new(),
        }
    }
}

impl<K: Copy + Eq + Hash, T> Slots<K, T> {
    /// The entry at `index`, if it is in use.
    pub fn get(&self, index: u32) -> Option<&T> {
        self.entries.get(index as usize)?.as_ref()
    }

    /// Begins a new count of the entries in use.
    pub fn begin(&mut self) {
        self.used.fill(false);
    }

    /// Returns the index of the entry made from `key`, if there is one for which `is_current` is true. The
    /// entry then counts as used.
    pub fn acquire(&mut self, key: K, is_current: impl FnOnce(&T) -> bool) -> Option<u32> {
        let &index = self.by_key.get(&key)?;
        let entry = self.entries[index as usize].as_ref()?;
        if !is_current(entry) {
            return None;
        }
        self.used[index as usize] = true;
        Some(index)
    }

    /// Stores an entry that counts as used, and returns its index. An older entry with the same key loses the
    /// key, and [`Slots::end`] frees it.
    pub fn insert(&mut self, key: K, entry: T) -> u32 {
        let index = self.free.pop().unwrap_or_else(|| {
            self.entries.push(None);
            self.used.push(false);
            self.entries.len() as u32 - 1
        });
        self.entries[index as usize] = Some(entry);
        self.used[index as usize] = true;
        self.by_key.insert(key, index);
        index
    }

    /// Frees the entries that were not requested since [`Slots::begin`].
    pub fn end(&mut self) {
        let used = &self.used;
        self.by_key.retain(|_, index| used[*index as usize]);
        for (index, (entry, used)) in self.entries.iter_mut().zip(used).enumerate() {
            if !used && entry.take().is_some() {
                self.free.push(index as u32);
            }
        }
    }

    /// Frees the entries that are not among `indices`.
    pub fn keep(&mut self, indices: impl Iterator<Item = u32>) {
        self.begin();
        for index in indices {
            self.used[index as usize] = true;
        }
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_asked_for_is_freed_and_its_index_reused() {
        let mut slots = Slots::default();
        slots.begin();
        let (a, b) = (slots.insert('a', 1), slots.insert('b', 2));
        slots.end();
        slots.begin();
        assert_eq!(slots.acquire('a', |_| true), Some(a));
        slots.end();
        assert_eq!((slots.get(a), slots.get(b)), (Some(&1), None));
        assert_eq!(slots.insert('c', 3), b);
    }

    #[test]
    fn what_is_not_kept_is_freed() {
        let mut slots = Slots::default();
        let (a, b) = (slots.insert('a', 1), slots.insert('b', 2));
        slots.keep([b].into_iter());
        assert_eq!((slots.get(a), slots.get(b)), (None, Some(&2)));
        assert_eq!(slots.acquire('a', |_| true), None);
        assert_eq!(slots.acquire('b', |_| true), Some(b));
    }

    #[test]
    fn a_stale_entry_is_replaced() {
        let mut slots = Slots::default();
        let old = slots.insert('a', 1);
        slots.begin();
        assert_eq!(slots.acquire('a', |entry| *entry == 2), None);
        let new = slots.insert('a', 2);
        slots.end();
        assert_eq!((slots.get(old), slots.get(new)), (None, Some(&2)));
        assert_eq!(slots.acquire('a', |_| true), Some(new));
    }
}
