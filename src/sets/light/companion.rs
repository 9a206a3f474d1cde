//! Lights of the crate's own that complete the shadow of another light.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use crate::sets::index::boxes::WORD;

/// The receivers on which a companion shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CompanionPart {
    /// Receivers that the technique of the light knows. Only casters that it does not know shadow them.
    Known,
    /// All other receivers. All casters shadow them.
    Others,
}

impl CompanionPart {
    /// The name of the part in labels and statistics, in snake case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Known => "on_known",
            Self::Others => "on_others",
        }
    }
}

/// Marks an entity that the crate spawns to shadow a part of another light with the second technique of that light.
///
/// The entity has no [`Light`](crate::scene::Light) and gives no light. It stands for the light in the sets, in the techniques
/// and among the lights of the renderer, and is despawned when the light or one of its two techniques goes.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CompanionOf {
    /// Entity of the light whose shadow is completed.
    pub light: Entity,
    /// The receivers on which the companion shadows.
    pub part: CompanionPart,
}

/// A choice of objects, by dense object index.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ObjectFilter {
    /// All objects.
    #[default]
    All,
    /// The objects of a set.
    Only(FixedBitSet),
    /// All objects but those of a set.
    Except(FixedBitSet),
}

impl ObjectFilter {
    /// The choice of no object.
    pub const NOTHING: Self = Self::Only(FixedBitSet::new());

    /// Whether an object is among the chosen ones.
    pub fn contains(&self, object: usize) -> bool {
        match self {
            Self::All => true,
            Self::Only(set) => set.contains(object),
            Self::Except(set) => !set.contains(object),
        }
    }

    /// Bits of those objects of a word that are chosen.
    pub(in crate::sets) fn among(&self, word: usize, bits: usize) -> usize {
        let word_of = |set: &FixedBitSet| set.as_slice().get(word).copied().unwrap_or(0);
        debug_assert_eq!(
            WORD,
            usize::BITS as usize,
            "a word of a set is a word of the index"
        );
        match self {
            Self::All => bits,
            Self::Only(set) => bits & word_of(set),
            Self::Except(set) => bits & !word_of(set),
        }
    }

    /// Whether this is `Only` of the set.
    fn is_only(&self, of: &FixedBitSet) -> bool {
        matches!(self, Self::Only(set) if set == of)
    }

    /// Whether this is `Except` of the set.
    fn is_except(&self, of: &FixedBitSet) -> bool {
        matches!(self, Self::Except(set) if set == of)
    }
}

/// The objects that a technique does not know, by dense object index. A second technique of the light shadows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LeftObjects<'a> {
    /// The technique knows no object in this frame.
    All,
    /// The technique knows all objects but these.
    Some {
        /// Objects whose shadows the technique does not know.
        casters: &'a FixedBitSet,
        /// Objects on which the technique shows no shadows.
        receivers: &'a FixedBitSet,
    },
}

/// The objects that a light acts on, beside its [`LightSelection`](crate::scene::LightSelection). Only companions are limited.
#[derive(Clone, Debug, Default)]
pub struct ActsOn {
    /// The objects that may cast for the light.
    pub casters: ObjectFilter,
    /// The objects that the light lights.
    pub receivers: ObjectFilter,
    /// Increases whenever a choice changes.
    pub revision: u64,
}

impl ActsOn {
    /// Takes over what the technique of the light leaves to a companion. Returns whether that changed. It allocates nothing if
    /// not.
    pub(crate) fn follow(&mut self, part: CompanionPart, left: LeftObjects) -> bool {
        use CompanionPart::{Known, Others};
        let is_same = match (part, left) {
            (Known, LeftObjects::All) => self.receivers == ObjectFilter::NOTHING,
            (Others, LeftObjects::All) => self.receivers == ObjectFilter::All,
            (Known, LeftObjects::Some { casters, receivers }) => {
                self.casters.is_only(casters) && self.receivers.is_except(receivers)
            }
            (Others, LeftObjects::Some { receivers, .. }) => self.receivers.is_only(receivers),
        };
        if is_same {
            return false;
        }
        (self.casters, self.receivers) = match (part, left) {
            (Known, LeftObjects::All) => (ObjectFilter::NOTHING, ObjectFilter::NOTHING),
            (Others, LeftObjects::All) => (ObjectFilter::All, ObjectFilter::All),
            (Known, LeftObjects::Some { casters, receivers }) => (
                ObjectFilter::Only(casters.clone()),
                ObjectFilter::Except(receivers.clone()),
            ),
            (Others, LeftObjects::Some { receivers, .. }) => {
                (ObjectFilter::All, ObjectFilter::Only(receivers.clone()))
            }
        };
        self.revision += 1;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(objects: &[usize]) -> FixedBitSet {
        let mut set = FixedBitSet::with_capacity(130);
        set.extend(objects.iter().copied());
        set
    }

    #[test]
    fn parts_divide_what_is_left_and_follow_changes_once() {
        let (casters, receivers) = (set(&[3, 70]), set(&[3, 129]));
        let left = LeftObjects::Some {
            casters: &casters,
            receivers: &receivers,
        };
        let (mut known, mut others) = (ActsOn::default(), ActsOn::default());
        assert!(known.follow(CompanionPart::Known, left) && others.follow(CompanionPart::Others, left));
        assert!(!known.follow(CompanionPart::Known, left) && !others.follow(CompanionPart::Others, left));
        assert_eq!((known.revision, others.revision), (1, 1));
        for object in 0..130 {
            assert_eq!(known.casters.contains(object), casters.contains(object));
            assert!(others.casters.contains(object));
            assert_ne!(
                known.receivers.contains(object),
                others.receivers.contains(object)
            );
            let (word, bit) = (object / WORD, 1 << (object % WORD));
            assert_eq!(
                known.receivers.among(word, bit) != 0,
                known.receivers.contains(object)
            );
            assert_eq!(
                others.receivers.among(word, bit) != 0,
                others.receivers.contains(object)
            );
        }
        assert!(known.follow(CompanionPart::Known, LeftObjects::All));
        assert!(others.follow(CompanionPart::Others, LeftObjects::All));
        assert!(
            (0..130).all(|object| !known.receivers.contains(object) && others.receivers.contains(object))
        );
        assert!(!known.follow(CompanionPart::Known, LeftObjects::All));
        assert!(!others.follow(CompanionPart::Others, LeftObjects::All));
    }
}
