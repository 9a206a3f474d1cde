//! GPU time by pass, where the device has timestamp queries and they were asked for.

use std::sync::Mutex;

use crate::render::{RenderContext, RenderError};

/// Passes that can be timed in one frame; further ones are not.
const PASS_CAPACITY: u32 = 256;

/// Records begin and end of passes.
#[derive(Debug)]
pub struct Timings {
    queries: Option<Queries>,
    labels: Mutex<Vec<String>>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    period_ns: f32,
}

/// GPU time of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass's label.
    pub label: String,
    /// Milliseconds.
    pub milliseconds: f64,
}

impl Timings {
    /// Timers if the device has them, else an object that does nothing.
    pub fn new(context: &RenderContext) -> Self {
        let queries = context
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
            .then(|| Queries {
                set: context.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("pass times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * PASS_CAPACITY,
                }),
                resolved: context.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("pass times"),
                    size: u64::from(2 * PASS_CAPACITY * wgpu::QUERY_SIZE),
                    usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
                period_ns: context.queue.get_timestamp_period(),
            });
        Self {
            queries,
            labels: Mutex::new(Vec::new()),
        }
    }

    /// Whether passes are timed.
    pub fn is_active(&self) -> bool {
        self.queries.is_some()
    }

    fn labels(&self) -> std::sync::MutexGuard<'_, Vec<String>> {
        self.labels
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Forgets the last frame's passes.
    pub fn begin_frame(&self) {
        self.labels().clear();
    }

    /// What a pass with this label writes; `None` without timers.
    pub fn pass(&self, label: &str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let queries = self.queries.as_ref()?;
        let mut labels = self.labels();
        let index = labels.len() as u32;
        if index >= PASS_CAPACITY {
            return None;
        }
        labels.push(label.to_owned());
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &queries.set,
            beginning_of_pass_write_index: Some(2 * index),
            end_of_pass_write_index: Some(2 * index + 1),
        })
    }

    /// What a pass of one light writes, labelled `<light>/<pass>`. The label is made only where somebody looks at it.
    pub fn pass_of(&self, light: &str, pass: &str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.queries.as_ref()?;
        self.pass(&format!("{light}/{pass}"))
    }

    /// Records the resolve; after the last pass.
    pub fn end_frame(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = self.labels().len() as u32;
        if let Some(queries) = self.queries.as_ref().filter(|_| count > 0) {
            encoder.resolve_query_set(&queries.set, 0..2 * count, &queries.resolved, 0);
        }
    }

    /// Waits for the frame and reads its times; empty without timers.
    ///
    /// # Errors
    /// [`RenderError::Readback`].
    pub fn read(&self, context: &RenderContext) -> Result<Vec<PassTime>, RenderError> {
        let labels = self.labels().clone();
        let Some(queries) = self.queries.as_ref().filter(|_| !labels.is_empty()) else {
            return Ok(Vec::new());
        };
        let size = labels.len() as u64 * 2 * u64::from(wgpu::QUERY_SIZE);
        let bytes = super::readback::read_buffer(context, &queries.resolved, size, "pass times")?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(labels
            .into_iter()
            .zip(ticks.chunks_exact(2))
            .map(|(label, ticks)| PassTime {
                label,
                milliseconds: ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(queries.period_ns) * 1e-6,
            })
            .collect())
    }
}
