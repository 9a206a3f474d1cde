//! Silhouettes on the GPU. Two buffers hold the edges and the caps of all kept pairs of light and caster.

use bevy_ecs::prelude::*;
use offset_allocator::{Allocation, Allocator};

use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::runs::joined;
use crate::render::{RenderContext, RenderError};
use crate::silhouettes::{Contour, Silhouettes};

/// The place of one silhouette in the pool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PooledContour {
    /// Index of the first edge in the buffer of edges.
    pub first_edge: u32,
    /// Number of edges that count once. They come first.
    pub single_count: u32,
    /// Number of edges that count twice. They follow those that count once.
    pub double_count: u32,
    /// Position of the first cap index in the buffer of caps.
    pub first_cap: u32,
    /// Number of cap indices.
    pub cap_count: u32,
    /// Number of cap indices of triangles that are wound towards the light. They come first; the rest are
    /// wound away from it.
    pub caps_away_start: u32,
}

impl PooledContour {
    /// Returns whether two silhouettes have equal counts, wherever they are in the pool.
    pub fn is_like(&self, other: &Self) -> bool {
        let counts = |contour: &Self| {
            (
                contour.single_count,
                contour.double_count,
                contour.cap_count,
                contour.caps_away_start,
            )
        };
        counts(self) == counts(other)
    }
}

/// The size of an edge, bytes. An edge is two vertex indices.
const EDGE_SIZE: u64 = 8;

#[derive(Default)]
struct Slot {
    revision: u64,
    place: PooledContour,
    edges: Option<Allocation>,
    caps: Option<Allocation>,
}

struct LightSlots {
    light: Entity,
    /// The [`LightSilhouettes::revision`](crate::silhouettes::LightSilhouettes::revision) that was uploaded.
    revision: u64,
    slots: Vec<Slot>,
}

/// The edges and caps of all kept silhouettes, in two buffers. Updates upload changed silhouettes, free
/// forgotten ones, and grow the buffers as needed.
pub struct ContourPool {
    lights: Vec<LightSlots>,
    edges: Arena,
    caps: Arena,
}

impl std::fmt::Debug for ContourPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ContourPool").finish_non_exhaustive()
    }
}

/// Elements on their way to the buffer, in two parts.
struct Placed<'a, T> {
    /// Index of the first element in the buffer.
    first: usize,
    parts: [&'a [T]; 2],
}

impl<T> Placed<'_, T> {
    fn range(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.parts[0].len() + self.parts[1].len()
    }
}

/// A buffer whose elements are allocated in ranges.
struct Arena {
    buffer: GrowingBuffer,
    allocator: Allocator,
    capacity: u32,
    element_size: u64,
}

impl Arena {
    const FIRST_CAPACITY: u32 = 1 << 14;

    fn new(
        context: &RenderContext,
        label: &'static str,
        usage: wgpu::BufferUsages,
        element_size: u64,
    ) -> Self {
        let mut buffer = GrowingBuffer::new(context, label, usage);
        buffer.reserve(context, u64::from(Self::FIRST_CAPACITY) * element_size, false);
        Self {
            buffer,
            allocator: Allocator::new(Self::FIRST_CAPACITY),
            capacity: Self::FIRST_CAPACITY,
            element_size,
        }
    }

    fn free(&mut self, allocation: Option<Allocation>) {
        if let Some(allocation) = allocation {
            self.allocator.free(allocation);
        }
    }

    /// Allocates a range for the parts, and notes that they go there, one after the other. Returns `None` if there is no room.
    fn place<'a, T: bytemuck::Pod>(
        &mut self,
        parts: [&'a [T]; 2],
        placed: &mut Vec<Placed<'a, T>>,
    ) -> Option<Option<Allocation>> {
        let count = parts[0].len() + parts[1].len();
        if count == 0 {
            return Some(None);
        }
        let allocation = self.allocator.allocate(u32::try_from(count).ok()?)?;
        let first = allocation.offset as usize;
        placed.push(Placed { first, parts });
        Some(Some(allocation))
    }

    /// Uploads everything that was placed, neighbours together.
    fn write<T: bytemuck::Pod>(&self, context: &RenderContext, mut placed: Vec<Placed<T>>) {
        placed.sort_unstable_by_key(|placed| placed.first);
        let mut rest = placed.iter();
        let mut elements: Vec<T> = Vec::new();
        for run in joined(placed.iter().map(Placed::range), 0) {
            elements.clear();
            while elements.len() < run.len()
                && let Some(placed) = rest.next()
            {
                placed
                    .parts
                    .iter()
                    .for_each(|part| elements.extend_from_slice(part));
            }
            let offset = run.start as u64 * self.element_size;
            let bytes: &[u8] = bytemuck::cast_slice(&elements);
            context.queue.write_buffer(&self.buffer.buffer, offset, bytes);
        }
    }

    /// Empties the arena and makes room for `elements`.
    fn reset(&mut self, context: &RenderContext, elements: u64) -> Result<(), RenderError> {
        let limits = context.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        // The capacity is twice the need, because the allocator rounds sizes up and ranges fragment.
        let capacity = (2 * elements).next_power_of_two().max(u64::from(self.capacity));
        let capacity = capacity.min(limit / self.element_size);
        if elements > capacity {
            return Err(RenderError::Limit {
                what: "silhouettes of all lights",
                needed: elements * self.element_size,
                limit,
            });
        }
        self.capacity = capacity as u32;
        self.buffer.reserve(context, capacity * self.element_size, false);
        self.allocator = Allocator::new(self.capacity);
        Ok(())
    }
}

impl ContourPool {
    /// Makes an empty pool.
    pub fn new(context: &RenderContext) -> Self {
        Self {
            lights: Vec::new(),
            edges: Arena::new(
                context,
                "silhouette edges",
                wgpu::BufferUsages::STORAGE,
                EDGE_SIZE,
            ),
            caps: Arena::new(context, "caps", wgpu::BufferUsages::INDEX, 4),
        }
    }

    /// Returns the storage buffer of edges, two vertex indices each.
    pub fn edges(&self) -> &wgpu::Buffer {
        &self.edges.buffer.buffer
    }

    /// Returns the index buffer of caps.
    pub fn caps(&self) -> &wgpu::Buffer {
        &self.caps.buffer.buffer
    }

    /// Returns the position of the silhouette in a light's slot.
    pub fn get(&self, light: Entity, slot: usize) -> Option<PooledContour> {
        let at = self
            .lights
            .binary_search_by_key(&light, |entry| entry.light)
            .ok()?;
        let slot = self.lights[at].slots.get(slot)?;
        (slot.revision != 0).then_some(slot.place)
    }

    /// Brings the pool up to date. Returns whether all silhouettes have new places in new buffers, which invalidates bind
    /// groups. Cost: the lights, and the silhouettes of those lights that have new ones.
    ///
    /// # Errors
    /// [`RenderError::Limit`] if the device cannot hold all silhouettes.
    pub fn update(
        &mut self,
        context: &RenderContext,
        silhouettes: &Silhouettes,
    ) -> Result<bool, RenderError> {
        self.forget_lights(silhouettes);
        if self.upload(context, silhouettes) {
            return Ok(false);
        }
        // There is no room, so everything is placed again in larger buffers.
        let (mut edges, mut caps) = (0, 0);
        for silhouette in silhouettes.lights().iter().flat_map(|light| &light.slots) {
            let contour = &silhouette.contour;
            edges += (contour.edges.len() + contour.double_edges.len()) as u64;
            caps += silhouette.contour.caps.len() as u64;
        }
        self.lights.clear();
        self.edges.reset(context, edges)?;
        self.caps.reset(context, caps)?;
        self.forget_lights(silhouettes);
        if self.upload(context, silhouettes) {
            return Ok(true);
        }
        Err(RenderError::Limit {
            what: "silhouettes of all lights",
            needed: edges * EDGE_SIZE + caps * 4,
            limit: context.device.limits().max_storage_buffer_binding_size,
        })
    }

    /// Makes the list of lights equal to that of the silhouettes, and frees the ranges of lights that are
    /// gone.
    fn forget_lights(&mut self, silhouettes: &Silhouettes) {
        let known = silhouettes.lights();
        let (edges, caps) = (&mut self.edges, &mut self.caps);
        self.lights.retain_mut(|entry| {
            let kept = known
                .binary_search_by_key(&entry.light, |light| light.light)
                .is_ok();
            if !kept {
                for slot in &mut entry.slots {
                    edges.free(slot.edges.take());
                    caps.free(slot.caps.take());
                }
            }
            kept
        });
        for light in known {
            if let Err(at) = self
                .lights
                .binary_search_by_key(&light.light, |entry| entry.light)
            {
                self.lights.insert(
                    at,
                    LightSlots {
                        light: light.light,
                        revision: 0,
                        slots: Vec::new(),
                    },
                );
            }
        }
    }

    /// Uploads all stale silhouettes. Returns `false` if there is no room.
    ///
    /// The ranges of all of them are freed first, so the new ones mostly follow each other and take few calls to write.
    fn upload(&mut self, context: &RenderContext, silhouettes: &Silhouettes) -> bool {
        let mut is_stale = false;
        for (entry, light) in self.lights.iter_mut().zip(silhouettes.lights()) {
            if entry.revision == light.revision {
                continue;
            }
            entry.slots.resize_with(light.slots.len(), Slot::default);
            for (slot, silhouette) in entry.slots.iter_mut().zip(&light.slots) {
                if slot.revision != silhouette.revision {
                    self.edges.free(slot.edges.take());
                    self.caps.free(slot.caps.take());
                    slot.revision = 0;
                    is_stale |= silhouette.revision != 0;
                }
            }
        }
        if !is_stale {
            return true;
        }
        let (mut new_edges, mut new_caps) = (Vec::new(), Vec::new());
        let has_room = self.place(silhouettes, &mut new_edges, &mut new_caps);
        self.edges.write(context, new_edges);
        self.caps.write(context, new_caps);
        has_room
    }

    /// Finds places for all stale silhouettes, which must have none. Returns `false` if there is no room for all of them.
    fn place<'a>(
        &mut self,
        silhouettes: &'a Silhouettes,
        new_edges: &mut Vec<Placed<'a, [u32; 2]>>,
        new_caps: &mut Vec<Placed<'a, u32>>,
    ) -> bool {
        for (entry, light) in self.lights.iter_mut().zip(silhouettes.lights()) {
            for (slot, silhouette) in entry.slots.iter_mut().zip(&light.slots) {
                if slot.revision == silhouette.revision {
                    continue;
                }
                let contour: &Contour = &silhouette.contour;
                let Some(edges) = self
                    .edges
                    .place([&contour.edges, &contour.double_edges], new_edges)
                else {
                    return false;
                };
                let Some(caps) = self.caps.place([&contour.caps, &[]], new_caps) else {
                    // The range is free again, so nothing may be written there.
                    self.edges.free(edges);
                    if edges.is_some() {
                        new_edges.pop();
                    }
                    return false;
                };
                slot.place = PooledContour {
                    first_edge: edges.map_or(0, |edges| edges.offset),
                    single_count: contour.edges.len() as u32,
                    double_count: contour.double_edges.len() as u32,
                    first_cap: caps.map_or(0, |caps| caps.offset),
                    cap_count: contour.caps.len() as u32,
                    caps_away_start: contour.caps_away_start as u32,
                };
                slot.edges = edges;
                slot.caps = caps;
                slot.revision = silhouette.revision;
            }
            entry.revision = light.revision;
        }
        true
    }
}
