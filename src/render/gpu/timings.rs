//! The time of each pass on the GPU. It is measured where the device has timestamp queries, which must have
//! been asked for.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use super::readback::read_buffer;
use crate::render::{RenderContext, RenderError};

/// The number of passes that one query set times. WebGPU allows sets of twice as many, and drivers a few dozen sets.
const SET_CAPACITY: usize = 1024;

/// The largest number of query sets. They are made when a frame first needs them.
const MOST_SETS: usize = 16;

/// The timers of the passes of a frame: up to 16,384. [`Timings::untimed`] counts further passes.
#[derive(Debug)]
pub struct Timings {
    timers: Option<Timers>,
    passes: Mutex<Passes>,
}

#[derive(Debug)]
struct Timers {
    device: wgpu::Device,
    sets: [OnceLock<Queries>; MOST_SETS],
    period_ns: f32,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

/// The passes of the current frame.
#[derive(Debug, Default)]
struct Passes {
    /// The labels of the timed passes in the order of their queries.
    labels: Vec<String>,
    untimed: usize,
}

/// The time that one pass took on the GPU.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The label of the pass.
    pub label: String,
    /// The time of the pass, milliseconds.
    pub milliseconds: f64,
}

impl Timings {
    /// Makes timers if the device has timestamp queries. Otherwise it makes an object that does nothing.
    pub fn new(context: &RenderContext) -> Self {
        let timers = context
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
            .then(|| Timers {
                device: context.device.clone(),
                sets: Default::default(),
                period_ns: context.queue.get_timestamp_period(),
            });
        Self {
            timers,
            passes: Mutex::default(),
        }
    }

    /// Returns whether passes are timed.
    pub fn is_active(&self) -> bool {
        self.timers.is_some()
    }

    /// Returns the number of passes of the last recorded frame that were not timed, because there were too many. It is 0
    /// without timers.
    pub fn untimed(&self) -> usize {
        self.passes().untimed
    }

    fn passes(&self) -> MutexGuard<'_, Passes> {
        self.passes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Removes the last frame's passes.
    pub fn begin_frame(&self) {
        let mut passes = self.passes();
        passes.labels.clear();
        passes.untimed = 0;
    }

    /// Returns the timestamp writes of a pass with this label. Returns `None` without timers, and for a pass too many.
    pub fn pass(&self, label: &str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let timers = self.timers.as_ref()?;
        let mut passes = self.passes();
        let pass = passes.labels.len();
        let Some(set) = timers.sets.get(pass / SET_CAPACITY) else {
            passes.untimed += 1;
            return None;
        };
        passes.labels.push(label.to_owned());
        let first = 2 * (pass % SET_CAPACITY) as u32;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &set.get_or_init(|| Queries::new(&timers.device)).set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Returns the timestamp writes of a pass of one light, which is labelled `<light>/<pass>`. The label is
    /// made only if passes are timed.
    pub fn pass_of(&self, light: &str, pass: &str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.timers.as_ref()?;
        self.pass(&format!("{light}/{pass}"))
    }

    /// Records the resolve of the timestamps. Call it after the last pass of the frame.
    pub fn end_frame(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = self.passes().labels.len();
        for (queries, passes) in self.in_use(count) {
            encoder.resolve_query_set(&queries.set, 0..2 * passes as u32, &queries.resolved, 0);
        }
    }

    /// Waits for the frame and returns the times of its passes. The result is empty without timers. Passes that
    /// [`Timings::untimed`] counts are not in it.
    ///
    /// # Errors
    /// [`RenderError::Readback`] if the copy fails, [`RenderError::DeviceLost`] if the device is lost.
    pub fn read(&self, context: &RenderContext) -> Result<Vec<PassTime>, RenderError> {
        let labels = self.passes().labels.clone();
        let period_ms = self
            .timers
            .as_ref()
            .map_or(0.0, |timers| f64::from(timers.period_ns) * 1e-6);
        let mut times = Vec::with_capacity(labels.len());
        for (queries, passes) in self.in_use(labels.len()) {
            let size = 2 * passes as u64 * u64::from(wgpu::QUERY_SIZE);
            let bytes = read_buffer(context, &queries.resolved, size, "pass times")?;
            let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
            times.extend(
                ticks
                    .chunks_exact(2)
                    .map(|ticks| ticks[1].saturating_sub(ticks[0]) as f64 * period_ms),
            );
        }
        Ok(labels
            .into_iter()
            .zip(times)
            .map(|(label, milliseconds)| PassTime { label, milliseconds })
            .collect())
    }

    /// Yields the query sets that the first `count` passes use, each with its number of passes.
    fn in_use(&self, count: usize) -> impl Iterator<Item = (&Queries, usize)> {
        let sets = self.timers.iter().flat_map(|timers| &timers.sets);
        sets.enumerate().map_while(move |(index, set)| {
            let passes = count.saturating_sub(index * SET_CAPACITY).min(SET_CAPACITY);
            Some((set.get()?, passes)).filter(|_| passes > 0)
        })
    }
}

impl Queries {
    fn new(device: &wgpu::Device) -> Self {
        let count = 2 * SET_CAPACITY as u32;
        Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass times"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass times"),
                size: u64::from(count * wgpu::QUERY_SIZE),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;
    use crate::render::{RequestedFeatures, create_target};

    fn context() -> RenderContext {
        let timed = RequestedFeatures {
            timestamps: true,
            ..Default::default()
        };
        pollster::block_on(RenderContext::headless(timed)).expect("a GPU adapter is needed")
    }

    #[test]
    fn every_pass_of_a_long_frame_has_a_time() {
        let context = context();
        let timings = Timings::new(&context);
        assert!(timings.is_active(), "the device has timers");
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let target = create_target(&context, "target", UVec2::ONE, format).expect("a texel");
        let view = target.create_view(&Default::default());
        for count in [SET_CAPACITY + 3, 2] {
            timings.begin_frame();
            let mut encoder = context.device.create_command_encoder(&Default::default());
            for pass in 0..count {
                let color = wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                };
                encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    color_attachments: &[Some(color)],
                    timestamp_writes: timings.pass(&format!("pass {pass}")),
                    ..Default::default()
                });
            }
            timings.end_frame(&mut encoder);
            context.queue.submit([encoder.finish()]);
            let times = timings.read(&context).expect("times");
            assert_eq!((times.len(), timings.untimed()), (count, 0));
            let last = times.last().expect("a pass");
            assert_eq!(last.label, format!("pass {}", count - 1));
            assert!(last.milliseconds.is_finite());
        }
    }

    #[test]
    fn passes_too_many_are_counted() {
        let timings = Timings::new(&context());
        for _ in 0..MOST_SETS * SET_CAPACITY {
            assert!(timings.pass("timed").is_some());
        }
        assert_eq!(timings.untimed(), 0);
        assert!(timings.pass("one").is_none() && timings.pass_of("and", "another").is_none());
        assert_eq!(timings.untimed(), 2);
        timings.begin_frame();
        assert!(timings.pass("timed").is_some());
        assert_eq!(timings.untimed(), 0);
    }
}
