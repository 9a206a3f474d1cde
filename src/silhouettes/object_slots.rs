//! Which objects have a slot in a list.

/// Number of objects of a page.
const PAGE: usize = 64;

/// Marks an object without a slot, and a page that no object needs.
const NONE: u32 = u32::MAX;

/// The slot of each object that has one, by dense object index. Neighbours share pages of 64 objects, and a page exists only
/// once one of its objects has a slot. So the memory follows the objects with slots: every other object takes half a bit.
#[derive(Clone, Debug, Default)]
pub(super) struct ObjectSlots {
    /// Page of each 64 objects.
    page_of: Vec<u32>,
    pages: Vec<[u32; PAGE]>,
    len: usize,
}

impl ObjectSlots {
    /// Returns the number of objects.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Forgets all slots, and makes room for `len` objects. Cost: O(len / 64).
    pub(super) fn reset(&mut self, len: usize) {
        self.len = len;
        self.pages.clear();
        self.page_of.clear();
        self.page_of.resize(len.div_ceil(PAGE), NONE);
    }

    /// Returns the slot of an object, if it has one.
    pub(super) fn get(&self, object: usize) -> Option<usize> {
        let page = *self.page_of.get(object / PAGE)?;
        let slot = self.pages.get(page as usize)?[object % PAGE];
        (slot != NONE).then_some(slot as usize)
    }

    /// Gives an object a slot.
    pub(super) fn set(&mut self, object: usize, slot: usize) {
        let page = &mut self.page_of[object / PAGE];
        if *page == NONE {
            *page = self.pages.len() as u32;
            self.pages.push([NONE; PAGE]);
        }
        self.pages[*page as usize][object % PAGE] = slot as u32;
    }

    /// Takes the slot of an object away, and returns it.
    pub(super) fn take(&mut self, object: usize) -> Option<usize> {
        let slot = self.get(object)?;
        let page = self.page_of[object / PAGE];
        self.pages[page as usize][object % PAGE] = NONE;
        Some(slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_are_found_where_they_were_set() {
        let mut slots = ObjectSlots::default();
        assert_eq!((slots.len(), slots.get(0)), (0, None));
        slots.reset(200);
        let objects = [0, 63, 64, 130, 199];
        for (slot, &object) in objects.iter().enumerate() {
            assert_eq!(slots.get(object), None);
            slots.set(object, slot);
        }
        let found: Vec<_> = (0..300).filter(|&object| slots.get(object).is_some()).collect();
        assert_eq!(found, objects);
        assert_eq!(objects.map(|object| slots.get(object)), [0, 1, 2, 3, 4].map(Some));
        assert_eq!(
            slots.pages.len(),
            4,
            "one for each 64 objects of which one has a slot"
        );
        assert_eq!(
            (slots.take(64), slots.take(64), slots.take(65)),
            (Some(2), None, None)
        );
        assert_eq!(slots.get(64), None);
        slots.reset(70);
        assert!((0..70).all(|object| slots.get(object).is_none()));
        assert_eq!(slots.len(), 70);
    }
}
