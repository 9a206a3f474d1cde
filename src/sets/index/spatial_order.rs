//! The order of objects in the dense index: neighbours share a word.

use glam::Vec4;

use super::boxes::WORD;
use crate::geometry::Aabb;
use crate::scene::tasks;

/// Number of items from which a half is worth a separate thread.
const PARALLEL: usize = 8192;

/// An item to be ordered: centre and size of an object, and its index in the list.
type Item = (Vec4, u32);

/// Finds an order in which each run of 64 boxes is close together, and so is each run of 4096. The runs are
/// the leaves of a balanced tree of median splits. Within a run the order of the list is kept, so lists of up
/// to 64 boxes keep their order throughout. Empty boxes come last.
///
/// Items are split along the axis in which they are spread most: the centre along x, y or z, or the size. An
/// object much larger than its neighbours (a floor under crates) is thus grouped with others like it and does
/// not enlarge the boxes of all. Sizes are split at the middle of their range, places at their median. O(n
/// log n). The result depends only on the list.
///
/// Source: Bentley 1975, "Multidimensional binary search trees used for associative searching"; the fourth
/// axis is ours.
pub(in crate::sets) fn spatial_order(boxes: impl Iterator<Item = Aabb>) -> Vec<u32> {
    let mut items: Vec<Item> = Vec::with_capacity(boxes.size_hint().0);
    let mut nowhere = Vec::new();
    for (index, aabb) in boxes.enumerate() {
        let aabb = aabb.padded();
        if aabb.is_empty() {
            nowhere.push(index as u32);
        } else {
            let size = aabb.half_size().max_element() * 2.0;
            items.push((aabb.center().extend(size), index as u32));
        }
    }
    let mut halves = halve(&mut items);
    let parallel = halves[0].len() >= PARALLEL;
    let quarters = halves.iter_mut().flat_map(|half| halve(half));
    tasks::for_each(quarters, parallel, split);
    let mut order: Vec<u32> = items.iter().map(|item| item.1).chain(nowhere).collect();
    for word in order.chunks_mut(WORD) {
        word.sort_unstable();
    }
    order
}

fn split(items: &mut [Item]) {
    if items.len() > WORD {
        halve(items).into_iter().for_each(split);
    }
}

/// Splits at a whole word, and at a whole block of words if the split is by place.
fn halve(items: &mut [Item]) -> [&mut [Item]; 2] {
    let (mut min, mut max) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    for (place, _) in items.iter() {
        min = min.min(*place);
        max = max.max(*place);
    }
    let widths = max - min;
    let mut axis = widths.max_position();
    let mut middle = middle(items.len());
    if axis == SIZE {
        let large = (min[SIZE] + max[SIZE]) * 0.5;
        let small = items.iter().filter(|item| item.0[SIZE] < large).count();
        middle = small / WORD * WORD;
    }
    if middle == 0 {
        axis = widths.truncate().max_position();
        middle = self::middle(items.len());
    }
    if middle < items.len() {
        let by_place = |a: &Item, b: &Item| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1));
        items.select_nth_unstable_by(middle, by_place);
    }
    let (left, right) = items.split_at_mut(middle);
    [left, right]
}

/// The axis of an item that is its size.
const SIZE: usize = 3;

/// Number of items in the first half.
fn middle(len: usize) -> usize {
    let words = len.div_ceil(WORD);
    let half = words.div_ceil(2);
    let half = if words > WORD {
        half.next_multiple_of(WORD)
    } else {
        half
    };
    (half * WORD).min(len)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn boxes(count: usize) -> Vec<Aabb> {
        let mut state = 5u64;
        let mut unit = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let mut place = |index: usize| {
            let center = Vec3::new(unit(), unit(), unit()) * 100.0;
            let half = if index.is_multiple_of(50) { 60.0 } else { 0.5 };
            Aabb::around(center, Vec3::splat(half))
        };
        (0..count).map(&mut place).collect()
    }

    #[test]
    fn it_is_a_permutation_with_the_empty_last() {
        for count in [0, 1, 63, 64, 65, 129, 4096, 4097, 20_000] {
            let mut boxes = boxes(count);
            for aabb in boxes.iter_mut().step_by(7) {
                *aabb = Aabb::EMPTY;
            }
            let order = spatial_order(boxes.iter().copied());
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.iter().copied().eq(0..count as u32));
            assert!(order.chunks(WORD).all(<[u32]>::is_sorted));
            let present = boxes.iter().filter(|aabb| !aabb.is_empty()).count();
            let tail = &order[present.next_multiple_of(WORD).min(count)..];
            assert!(tail.iter().all(|&i| boxes[i as usize].is_empty()));
        }
    }

    #[test]
    fn words_are_small_and_large_objects_keep_to_themselves() {
        let boxes = boxes(64 * 64);
        let order = spatial_order(boxes.iter().copied());
        let size = |word: &[u32]| {
            let around = word.iter().map(|&i| boxes[i as usize]);
            around.fold(Aabb::EMPTY, Aabb::union).half_size().max_element()
        };
        let mut sizes: Vec<f32> = order.chunks(WORD).map(size).collect();
        sizes.sort_unstable_by(f32::total_cmp);
        // 62 words of small objects fill a cube of 100 m: a quarter of a side each, half of it if split
        // evenly.
        assert!(sizes[61] < 30.0 && sizes[62] > 60.0, "{sizes:?}");
    }

    #[test]
    fn a_million_at_one_point_stay_in_their_order() {
        let one = Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        };
        let order = spatial_order(std::iter::repeat_n(one, 1_000_000));
        assert!(order.is_sorted());
    }
}
