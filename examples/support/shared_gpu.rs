//! One [`Gpu`] for each device: stages that draw on the same device share its shaders and pipelines.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use antumbra::prelude::RenderContext;
use antumbra::render::{Gpu, RenderError};

/// The [`Gpu`]s that something still draws on.
static KNOWN: Mutex<Vec<Weak<Gpu>>> = Mutex::new(Vec::new());

/// Returns the [`Gpu`] of a device. It is made if nothing draws on the device yet, and dropped with the last renderer that
/// draws on it.
///
/// # Errors
/// A shader that does not compose.
pub fn shared_gpu(context: RenderContext) -> Result<Arc<Gpu>, RenderError> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.retain(|gpu| gpu.strong_count() > 0);
    let of_device = |gpu: &Arc<Gpu>| gpu.context.is_clone_of(&context);
    if let Some(gpu) = known.iter().filter_map(Weak::upgrade).find(of_device) {
        return Ok(gpu);
    }
    let gpu = Arc::new(Gpu::new(context)?);
    known.push(Arc::downgrade(&gpu));
    Ok(gpu)
}
