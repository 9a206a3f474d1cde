//! How the memory for maps is shared.
//!
//! All lights get what they want while it fits. Otherwise the least visible light loses resolution, halved
//! down to its smallest, then the next. When all have their smallest, the least visible lights lose their
//! kept map: they share one map, which is drawn again every frame.

/// The map that a light wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Want {
    /// Bytes per squared resolution: faces × textures × 4.
    pub bytes_per_square: u64,
    /// Texels along a side; > 0.
    pub resolution: u32,
    /// Smallest resolution, texels along a side; > 0.
    pub least: u32,
    /// Whether the map may be kept.
    pub cached: bool,
    /// How visible the light is. The least visible loses first and, among equals, the later one.
    pub visibility: u64,
}

/// The map that a light gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grant {
    /// Texels along a side.
    pub resolution: u32,
    /// Whether the map is kept.
    pub cached: bool,
}

fn bytes(want: &Want, grant: &Grant) -> u64 {
    if !grant.cached {
        return 0;
    }
    u64::from(grant.resolution)
        .pow(2)
        .saturating_mul(want.bytes_per_square)
}

/// Returns the memory of all maps that are kept, bytes.
pub fn total_bytes(wants: &[Want], grants: &[Grant]) -> u64 {
    let each = wants.iter().zip(grants).map(|(want, grant)| bytes(want, grant));
    each.fold(0, u64::saturating_add)
}

/// Shares out `limit` bytes. Deterministic; `order` is scratch memory.
pub fn share_out(wants: &[Want], limit: u64, grants: &mut Vec<Grant>, order: &mut Vec<usize>) {
    grants.clear();
    grants.extend(wants.iter().map(|want| Grant {
        resolution: want.resolution,
        cached: want.cached,
    }));
    let mut total = total_bytes(wants, grants);
    if total <= limit {
        return;
    }
    order.clear();
    order.extend((0..wants.len()).filter(|&i| wants[i].cached));
    order.sort_unstable_by_key(|&i| (wants[i].visibility, std::cmp::Reverse(i)));
    for &i in &*order {
        while total > limit && grants[i].resolution / 2 >= wants[i].least {
            let before = bytes(&wants[i], &grants[i]);
            grants[i].resolution /= 2;
            total = total - before + bytes(&wants[i], &grants[i]);
        }
    }
    for &i in &*order {
        if total <= limit {
            return;
        }
        total -= bytes(&wants[i], &grants[i]);
        grants[i].cached = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn want(visibility: u64) -> Want {
        Want {
            bytes_per_square: 24,
            resolution: 1024,
            least: 128,
            cached: true,
            visibility,
        }
    }

    fn plan(limit: u64) -> Vec<Grant> {
        let wants = [want(5), want(1), want(9)];
        let (mut grants, mut order) = (Vec::new(), Vec::new());
        share_out(&wants, limit, &mut grants, &mut order);
        assert!(total_bytes(&wants, &grants) <= limit);
        grants
    }

    #[test]
    fn least_visible_loses_resolution_then_its_cache() {
        let each = 24 << 20;
        let of = |limit| {
            plan(limit)
                .iter()
                .map(|g| (g.resolution, g.cached))
                .collect::<Vec<_>>()
        };
        assert_eq!(of(3 * each), [(1024, true); 3]);
        assert_eq!(of(3 * each - 1), [(1024, true), (512, true), (1024, true)]);
        assert_eq!(of(2 * each), [(512, true), (128, true), (1024, true)]);
        let least = 24 * 128 * 128;
        assert_eq!(of(3 * least), [(128, true); 3]);
        assert_eq!(of(2 * least), [(128, true), (128, false), (128, true)]);
        assert_eq!(of(least), [(128, false), (128, false), (128, true)]);
        assert_eq!(of(0), [(128, false); 3]);
    }
}
