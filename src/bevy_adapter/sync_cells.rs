//! Synchronisation of the mirrors' cells, portals and occluders with those of the game.

use bevy::camera::visibility::RenderLayers;
use bevy::ecs::prelude::*;
use bevy::render::{Extract, MainWorld};
use bevy::transform::components::GlobalTransform;

use super::light_convert::layer_bits;
use super::mirror::{Mirror, Mirrors};
use crate::scene::{Cell, InCells, Occluder, Portal, SelectionLayers};

/// Filter of entities with a component that the mirrors copy.
type HasCell = Or<(With<Cell>, With<Portal>, With<InCells>, With<Occluder>)>;

/// Filter of entities with a component that the mirrors must copy again.
type CellChanged = (
    HasCell,
    Or<(
        Changed<Cell>,
        Changed<Portal>,
        Changed<InCells>,
        Changed<Occluder>,
        Changed<RenderLayers>,
    )>,
);

/// Removed components that force an entity to be synchronised again.
#[derive(bevy::ecs::system::SystemParam)]
pub struct RemovedCells<'w, 's> {
    cell: Extract<'w, 's, RemovedComponents<'static, 'static, Cell>>,
    portal: Extract<'w, 's, RemovedComponents<'static, 'static, Portal>>,
    in_cells: Extract<'w, 's, RemovedComponents<'static, 'static, InCells>>,
    occluder: Extract<'w, 's, RemovedComponents<'static, 'static, Occluder>>,
    layers: Extract<'w, 's, RemovedComponents<'static, 'static, RenderLayers>>,
}

/// Copies cells, portals, lists of cells and occluders that appeared, changed or were removed to the mirrors.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync). In a steady frame it only
/// reads change ticks.
pub(super) fn sync_cells(
    main: Res<MainWorld>,
    mut mirrors: ResMut<Mirrors>,
    changed: Extract<Query<Entity, CellChanged>>,
    all: Extract<Query<Entity, HasCell>>,
    mut removed: RemovedCells,
    mut dirty: Local<Vec<Entity>>,
) {
    dirty.extend(changed.iter());
    dirty.extend(removed.cell.read());
    dirty.extend(removed.portal.read());
    dirty.extend(removed.in_cells.read());
    dirty.extend(removed.occluder.read());
    dirty.extend(removed.layers.read().filter(|&entity| all.contains(entity)));
    dirty.sort_unstable();
    dirty.dedup();
    for mirror in mirrors.iter_mut() {
        if mirror.fresh {
            all.iter().for_each(|entity| sync_cell(mirror, &main, entity));
        } else {
            dirty.iter().for_each(|&entity| sync_cell(mirror, &main, entity));
        }
    }
    dirty.clear();
}

fn sync_cell(mirror: &mut Mirror, main: &World, entity: Entity) {
    let Some((source, place)) = main
        .get_entity(entity)
        .ok()
        .and_then(|source| Some((source, source.get::<GlobalTransform>()?)))
    else {
        return; // its mirrored entity is despawned with its transform
    };
    // The entities that it names, which may come later in the list.
    let mut counterpart = |named: Entity| {
        let place = main.get::<GlobalTransform>(named)?;
        Some(mirror.get_or_spawn(named, place))
    };
    let no_cell = Entity::PLACEHOLDER;
    let portal = source.get::<Portal>().map(|portal| Portal {
        joins: portal.joins.map(|cell| counterpart(cell).unwrap_or(no_cell)),
        ..portal.clone()
    });
    let in_cells = source
        .get::<InCells>()
        .map(|cells| InCells(cells.0.iter().filter_map(|&cell| counterpart(cell)).collect()));
    let mirrored = mirror.get_or_spawn(entity, place);
    let mut target = mirror.world.entity_mut(mirrored);
    match source.get::<Cell>() {
        Some(cell) => {
            let layers = SelectionLayers(layer_bits(source.get::<RenderLayers>()));
            target.insert((*cell, layers));
        }
        None => {
            target.remove::<Cell>();
        }
    }
    match portal {
        Some(portal) => target.insert(portal),
        None => target.remove::<Portal>(),
    };
    match in_cells {
        Some(cells) => target.insert(cells),
        None => target.remove::<InCells>(),
    };
    match source.get::<Occluder>() {
        Some(occluder) => target.insert(occluder.clone()),
        None => target.remove::<Occluder>(),
    };
}
