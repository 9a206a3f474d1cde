//! The rule by which the memory for textures is shared.
//!
//! All lights get what they want while it fits. Otherwise the light whose textures take the most bytes for each pixel that
//! it reaches loses resolution, halved, again and again. So one light that asks for much leaves the others theirs, and of
//! equal wants the least visible loses first. When all have their smallest, the least visible lights lose their own
//! textures.

/// The textures that a light wants from one technique.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureWant {
    /// Memory of all the light's textures as bytes for each squared resolution: the bytes of a texel times the number of
    /// layers, summed over the textures. Six faces of 4-byte texels need 24.
    pub bytes_per_square: u64,
    /// Texels along a side; at least 1.
    pub resolution: u32,
    /// Smallest resolution, texels along a side, 1 to `resolution`. A shortage of memory does not go below it.
    pub least: u32,
    /// Whether the light needs textures of its own.
    pub storage: Storage,
}

/// Whether a light needs textures of its own, which count towards the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// The light needs no textures of its own: it draws into textures that lights share in turn. Those do not count.
    Shared,
    /// The light wants textures of its own. If not even the smallest fit, it shares textures, as with
    /// [`Storage::Shared`].
    OwnElseShared,
    /// The light needs textures of its own. If not even the smallest fit, it gets nothing.
    OwnElseNothing,
}

/// The textures that a light gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureGrant {
    /// Texels along a side.
    pub resolution: u32,
    /// True if the light has textures of its own; false if it must use textures that lights share in turn.
    pub is_own: bool,
}

/// A want, and how visible its light is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RankedWant {
    /// The want.
    pub want: TextureWant,
    /// How visible the light is: the binary logarithm of the pixels that it reaches. Among equals, the later one loses
    /// first.
    pub visibility: u32,
}

/// A step of resolution that a light can lose.
#[derive(Clone, Copy, Debug)]
pub struct Halving {
    /// Index of the want.
    index: usize,
    /// Resolution before the step.
    resolution: u32,
    /// Bytes before the step for each pixel that the light reaches.
    bytes_per_pixel: f64,
}

/// Scratch memory of [`share_out`].
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    halvings: Vec<Halving>,
    order: Vec<usize>,
}

/// What came of a want; `None` if the light gets nothing.
type Outcome = Option<TextureGrant>;

/// In 128 bits no sum of real sizes overflows, and what was added can be subtracted again.
fn bytes(want: &TextureWant, grant: Outcome) -> u128 {
    grant.filter(|grant| grant.is_own).map_or(0, |grant| {
        u128::from(grant.resolution)
            .pow(2)
            .saturating_mul(u128::from(want.bytes_per_square))
    })
}

fn total(wants: &[RankedWant], grants: &[Outcome]) -> u128 {
    let each = wants.iter().zip(grants);
    each.map(|(ranked, grant)| bytes(&ranked.want, *grant))
        .fold(0, u128::saturating_add)
}

/// Returns the memory of all textures that lights have of their own, bytes.
pub fn total_bytes(wants: &[RankedWant], grants: &[Outcome]) -> u64 {
    u64::try_from(total(wants, grants)).unwrap_or(u64::MAX)
}

/// Shares out `limit` bytes. Deterministic.
pub fn share_out(wants: &[RankedWant], limit: u64, grants: &mut Vec<Outcome>, scratch: &mut Scratch) {
    grants.clear();
    grants.extend(wants.iter().map(|RankedWant { want, .. }| {
        Some(TextureGrant {
            resolution: want.resolution,
            is_own: want.storage != Storage::Shared,
        })
    }));
    let limit = u128::from(limit);
    let mut left = total(wants, grants);
    if left <= limit {
        return;
    }
    let mut exchange = |i: usize, grants: &mut Vec<Outcome>, outcome: Outcome| {
        let (before, after) = (bytes(&wants[i].want, grants[i]), bytes(&wants[i].want, outcome));
        left = left - before + after;
        grants[i] = outcome;
        left <= limit
    };
    let Scratch { halvings, order } = scratch;
    order.clear();
    order.extend((0..wants.len()).filter(|&i| wants[i].want.storage != Storage::Shared));
    halvings.clear();
    halvings.extend(order.iter().flat_map(|&index| halvings_of(index, &wants[index])));
    // The steps of one light stay in their order, because each has fewer bytes than the one before.
    halvings.sort_unstable_by(|a, b| {
        let least_worth_first = b.bytes_per_pixel.total_cmp(&a.bytes_per_pixel);
        least_worth_first.then(b.index.cmp(&a.index))
    });
    for halving in &*halvings {
        let coarser = TextureGrant {
            resolution: halving.resolution / 2,
            is_own: true,
        };
        if exchange(halving.index, grants, Some(coarser)) {
            return;
        }
    }
    order.sort_unstable_by_key(|&i| (wants[i].visibility, std::cmp::Reverse(i)));
    for &i in &*order {
        let shared = grants[i].map(|grant| TextureGrant {
            is_own: false,
            ..grant
        });
        let shared = shared.filter(|_| wants[i].want.storage == Storage::OwnElseShared);
        if exchange(i, grants, shared) {
            return;
        }
    }
}

/// Returns the steps from a want's resolution down to its smallest.
fn halvings_of(index: usize, ranked: &RankedWant) -> impl Iterator<Item = Halving> {
    let want = ranked.want;
    let pixels = f64::from(ranked.visibility).exp2();
    std::iter::successors(Some(want.resolution), |resolution| Some(resolution / 2))
        .take_while(move |resolution| resolution / 2 >= want.least.max(1))
        .map(move |resolution| Halving {
            index,
            resolution,
            bytes_per_pixel: f64::from(resolution).powi(2) * want.bytes_per_square as f64 / pixels,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn want(visibility: u32, storage: Storage) -> RankedWant {
        RankedWant {
            want: TextureWant {
                bytes_per_square: 24,
                resolution: 1024,
                least: 128,
                storage,
            },
            visibility,
        }
    }

    fn plan(storage: Storage, limit: u64) -> Vec<Option<(u32, bool)>> {
        let wants = [5, 1, 9].map(|visibility| want(visibility, storage));
        let (mut grants, mut scratch) = (Vec::new(), Scratch::default());
        share_out(&wants, limit, &mut grants, &mut scratch);
        assert!(total_bytes(&wants, &grants) <= limit);
        let plain = |grant: Outcome| grant.map(|grant| (grant.resolution, grant.is_own));
        grants.into_iter().map(plain).collect()
    }

    const EACH: u64 = 24 << 20;
    const LEAST: u64 = 24 * 128 * 128;

    #[test]
    fn least_visible_loses_resolution_then_its_own_textures() {
        let of = |limit| plan(Storage::OwnElseShared, limit);
        let all = |each: [(u32, bool); 3]| each.map(Some).to_vec();
        assert_eq!(of(3 * EACH), all([(1024, true); 3]));
        assert_eq!(of(3 * EACH - 1), all([(1024, true), (512, true), (1024, true)]));
        assert_eq!(of(2 * EACH), all([(512, true), (128, true), (1024, true)]));
        assert_eq!(of(3 * LEAST), all([(128, true); 3]));
        assert_eq!(of(2 * LEAST), all([(128, true), (128, false), (128, true)]));
        assert_eq!(of(LEAST), all([(128, false), (128, false), (128, true)]));
        assert_eq!(of(0), all([(128, false); 3]));
    }

    #[test]
    fn one_light_that_asks_for_much_leaves_the_others_theirs() {
        let mut wants = [want(9, Storage::OwnElseNothing); 5];
        wants[1].want.bytes_per_square *= 16;
        let (mut grants, mut scratch) = (Vec::new(), Scratch::default());
        let mut resolutions = |wants: &[RankedWant], limit| {
            share_out(wants, limit, &mut grants, &mut scratch);
            let each = grants.iter().flatten().map(|grant| grant.resolution);
            each.collect::<Vec<_>>()
        };
        assert_eq!(resolutions(&wants, 8 * EACH), [1024, 512, 1024, 1024, 1024]);
        assert_eq!(resolutions(&wants, 5 * EACH), [1024, 256, 1024, 1024, 1024]);
        // It is worth the more the more pixels it reaches.
        wants[1].visibility += 5;
        assert_eq!(resolutions(&wants, 17 * EACH), [512, 1024, 512, 512, 512]);
    }

    #[test]
    fn lights_that_cannot_share_get_nothing_and_lights_that_share_lose_nothing() {
        let nothing = plan(Storage::OwnElseNothing, LEAST);
        assert_eq!(nothing, [None, None, Some((128, true))]);
        assert_eq!(plan(Storage::Shared, 0), [Some((1024, false)); 3]);
    }

    #[test]
    fn sums_beyond_64_bits_are_limited_too() {
        let mut wants = [want(1, Storage::OwnElseShared); 2];
        for want in &mut wants {
            want.want.resolution = u32::MAX;
        }
        let (mut grants, mut scratch) = (Vec::new(), Scratch::default());
        share_out(&wants, EACH, &mut grants, &mut scratch);
        assert!(total_bytes(&wants, &grants) <= EACH);
        assert!(grants.iter().all(|grant| grant.is_some_and(|grant| grant.is_own)));
    }
}
