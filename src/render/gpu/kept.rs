//! A value that is made from other values and kept while these stay the same.

/// A value and the key from which it was made, such as a bind group and its resources.
#[derive(Debug)]
pub struct Kept<K, V> {
    entry: Option<(K, V)>,
    /// The number of times that the value was made. It does not grow in a steady frame.
    pub made: usize,
}

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self { entry: None, made: 0 }
    }
}

impl<K: PartialEq, V> Kept<K, V> {
    /// Returns the value made from `key`. If the key has changed, a new value replaces the last one.
    pub fn get(&mut self, key: K, make: impl FnOnce() -> V) -> &V {
        if self.entry.as_ref().is_some_and(|(known, _)| *known != key) {
            self.entry = None;
        }
        let made = &mut self.made;
        let (_, value) = self.entry.get_or_insert_with(|| {
            *made += 1;
            (key, make())
        });
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_made_when_its_key_changes() {
        let mut kept = Kept::default();
        for (key, made) in [(1, 1), (1, 1), (2, 2), (2, 2), (1, 3)] {
            assert_eq!(*kept.get(key, || key * 10), key * 10);
            assert_eq!(kept.made, made);
        }
    }
}
