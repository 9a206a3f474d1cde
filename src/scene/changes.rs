//! Change ticks of whole columns: finds which of 100 000 objects changed, at a few microseconds a column.

use bevy_ecs::change_detection::{MAX_CHANGE_AGE, Tick};
use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;
use bevy_ecs::system::SystemParam;

use super::{SceneMaterials, SceneMesh};

/// Number of rows that one mask covers.
const BLOCK: usize = u64::BITS as usize;

/// The time since a system last ran, in change ticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Since {
    this_run: u32,
    age: u32,
}

impl Since {
    /// The time between two runs of a system.
    pub(crate) fn new(last_run: Tick, this_run: Tick) -> Self {
        let (last_run, this_run) = (last_run.get(), this_run.get());
        Self {
            this_run,
            age: this_run.wrapping_sub(last_run).min(MAX_CHANGE_AGE),
        }
    }

    /// [`Tick::is_newer_than`] without branches.
    #[inline]
    fn holds(self, tick: Tick) -> bool {
        self.this_run.wrapping_sub(tick.get()) < self.age
    }

    /// Whether any of the rows changed.
    pub(crate) fn any(self, ticks: &[Tick]) -> bool {
        ticks.chunks(8 * BLOCK).any(|chunk| {
            let fold = |any: bool, &tick: &Tick| any | self.holds(tick);
            chunk.iter().fold(false, fold)
        })
    }

    /// Mask of the rows that changed. It covers at most 64 rows.
    pub(crate) fn mask(self, ticks: &[Tick]) -> u64 {
        let set = |(mask, bit): (u64, u64), &tick: &Tick| {
            let mask = if self.holds(tick) { mask | bit } else { mask };
            (mask, bit << 1)
        };
        ticks.iter().fold((0, 1), set).0
    }

    /// First row and mask of each block of 64 rows in which something changed, ascending.
    pub(crate) fn blocks(self, ticks: &[Tick]) -> impl Iterator<Item = (usize, u64)> + '_ {
        let blocks = ticks.chunks(BLOCK).enumerate();
        blocks
            .filter(move |(_, block)| self.any(block))
            .map(move |(at, block)| (at * BLOCK, self.mask(block)))
    }
}

/// Indices of the set bits of a mask, ascending.
pub(crate) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            bit
        })
    })
}

/// Whether any component of this kind was added or written since the system last ran.
pub(crate) fn any_changed<T: Component, F: ArchetypeFilter>(query: &Query<Ref<'static, T>, F>) -> bool {
    let Ok(mut tables) = query.contiguous_iter() else {
        // The component is not kept in tables.
        return query.iter().any(|component| component.is_changed());
    };
    tables.any(|table| {
        let since = Since::new(table.last_run_tick(), table.this_run_tick());
        since.any(table.changed_ticks_slice())
    })
}

/// The meshes and materials of all objects.
///
/// The ticks are compared table by table. The filter `Or<(Changed<_>, Changed<_>)>` takes several times as long.
#[derive(SystemParam)]
pub struct Appearances<'w, 's> {
    meshes: Query<'w, 's, Ref<'static, SceneMesh>>,
    materials: Query<'w, 's, Ref<'static, SceneMaterials>>,
}

impl Appearances<'_, '_> {
    /// Whether a mesh or a list of materials was added or exchanged since the system last ran.
    pub(crate) fn any_changed(&self) -> bool {
        any_changed(&self.meshes) || any_changed(&self.materials)
    }
}

/// The last frame in which meshes or lists of materials were added or exchanged. Written by [`count_appearances`].
#[derive(Resource, Clone, Debug, Default)]
pub struct AppearanceCount {
    /// Number of such frames so far.
    frames: u64,
    /// The entities of the last such frame, each once.
    exchanged: Vec<Entity>,
}

/// Looks once a frame which objects got another appearance, for all systems that collect appearances.
///
/// Set: `CollectSets`, first. Cost: two columns of change ticks, and a list of the entities whose appearance changed.
pub fn count_appearances(
    mut count: ResMut<AppearanceCount>,
    appearances: Appearances,
    exchanged: Query<Entity, Or<(Changed<SceneMesh>, Changed<SceneMaterials>)>>,
) {
    if appearances.any_changed() {
        count.frames += 1;
        count.exchanged.clear();
        count.exchanged.extend(&exchanged);
    }
}

/// Tells a system whose appearances changed since it last asked. A change after [`count_appearances`] is seen a frame later.
#[derive(SystemParam)]
pub struct NewAppearances<'w, 's> {
    count: Res<'w, AppearanceCount>,
    seen: Local<'s, u64>,
}

/// The objects whose mesh or list of materials was added or exchanged since a system last asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exchanges<'a> {
    /// These objects and no others; often none.
    Of(&'a [Entity]),
    /// The system missed a frame with exchanges, so it may be any object.
    Unknown,
}

/// Number of objects up to which a sorted list is brought up to date object by object.
const FEW: usize = 32;

impl<'a> Exchanges<'a> {
    /// Whether nothing was exchanged.
    pub(crate) fn is_none(self) -> bool {
        self == Self::Of(&[])
    }

    /// The objects, if they are so few that each of them can be looked up in a sorted list.
    pub(crate) fn few(self) -> Option<&'a [Entity]> {
        match self {
            Self::Of(entities) if entities.len() <= FEW => Some(entities),
            _ => None,
        }
    }
}

impl NewAppearances<'_, '_> {
    /// The objects whose mesh or list of materials was added or exchanged since the last call.
    pub(crate) fn take(&mut self) -> Exchanges<'_> {
        let frames = self.count.frames;
        match frames.wrapping_sub(std::mem::replace(&mut *self.seen, frames)) {
            0 => Exchanges::Of(&[]),
            1 => Exchanges::Of(&self.count.exchanged),
            _ => Exchanges::Unknown,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_say_what_bevy_says() {
        let at = |tick: u32| Tick::new(tick);
        let runs = [(0, 1), (5, 9), (u32::MAX - 2, 3), (7, 7), (9, 5), (1, 1 << 31)];
        for (last, this) in runs {
            let since = Since::new(at(last), at(this));
            let near = (0..64).map(|i| at(last.wrapping_add(i).wrapping_sub(20)));
            let far = (0..64).map(|i| at(i * 0x0400_0001));
            for ticks in [near.collect::<Vec<_>>(), far.collect()] {
                let expected = |tick: &Tick| tick.is_newer_than(at(last), at(this));
                let mask = since.mask(&ticks);
                for (bit, tick) in ticks.iter().enumerate() {
                    assert_eq!(mask >> bit & 1 == 1, expected(tick), "{last} {this} {tick:?}");
                }
                assert_eq!(since.any(&ticks), ticks.iter().any(expected));
                assert_eq!(bits(mask).count(), mask.count_ones() as usize);
                let blocks: Vec<_> = since.blocks(&ticks).collect();
                assert_eq!(blocks, if mask == 0 { vec![] } else { vec![(0, mask)] });
            }
        }
    }

    #[test]
    fn a_system_that_misses_an_exchange_knows_that_it_did() {
        #[derive(Resource, Default)]
        struct Seen(Vec<Option<Vec<Entity>>>);
        let look = |mut appearances: NewAppearances, mut seen: ResMut<Seen>| {
            seen.0.push(match appearances.take() {
                Exchanges::Of(entities) => Some(entities.to_vec()),
                Exchanges::Unknown => None,
            });
        };
        let mut world = World::new();
        world.init_resource::<AppearanceCount>();
        world.init_resource::<Seen>();
        let (mut count, mut ask) = (Schedule::default(), Schedule::default());
        count.add_systems(count_appearances);
        ask.add_systems(look);
        let looks = || SceneMaterials(Default::default());
        let [first, second] = [(); 2].map(|()| world.spawn(looks()).id());
        let mut frame = |world: &mut World, asks: bool| {
            count.run(world);
            if asks {
                ask.run(world);
            }
        };
        frame(&mut world, true);
        frame(&mut world, true);
        *world.get_mut::<SceneMaterials>(second).unwrap() = looks();
        frame(&mut world, false);
        frame(&mut world, true); // the list outlives frames without exchanges
        for entity in [first, second] {
            *world.get_mut::<SceneMaterials>(entity).unwrap() = looks();
            frame(&mut world, false);
        }
        frame(&mut world, true);
        frame(&mut world, true);
        let seen = &world.resource::<Seen>().0;
        let mut all = seen[0].clone().unwrap();
        all.sort_unstable();
        let mut both = vec![first, second];
        both.sort_unstable();
        assert_eq!(all, both);
        assert_eq!(seen[1..], [Some(vec![]), Some(vec![second]), None, Some(vec![])]);
    }
}
