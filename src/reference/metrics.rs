//! Measures how far an answer is from the truth. The definitions are those of `tools/truth.py`, except that
//! an answer of NaN where the truth counts is wrong by 1.

use super::error::ReferenceError;
use super::visibility::VisibilityImage;

/// Error counts of a hard shadow. A pixel is wrong if it differs from the truth by more than ½.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HardError {
    /// Number of pixels that count.
    pub counted: usize,
    /// Number of counted pixels outside the band around edges.
    pub inner: usize,
    /// Number of wrong pixels outside the band around edges.
    pub wrong_inner: usize,
    /// Number of wrong pixels, inside or outside the band.
    pub wrong_all: usize,
}

impl HardError {
    /// Share of wrong pixels among those outside the band. `None` if there are no such pixels, because then
    /// nothing is known.
    pub fn share(&self) -> Option<f64> {
        (self.inner > 0).then(|| self.wrong_inner as f64 / self.inner as f64)
    }

    /// Share of wrong pixels among all pixels that count. `None` if there are none.
    pub fn share_all(&self) -> Option<f64> {
        (self.counted > 0).then(|| self.wrong_all as f64 / self.counted as f64)
    }
}

/// Error measures of a soft shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftError {
    /// Number of pixels that count.
    pub counted: usize,
    /// Number of counted pixels where the truth lies between 0 and 1.
    pub penumbra: usize,
    /// Root mean squared error over all counted pixels.
    pub rmse: f64,
    /// Root mean squared error over the pixels where the truth lies between 0 and 1; 0 if there are none, which
    /// [`SoftError::penumbra_rmse`] tells from no error.
    pub rmse_penumbra: f64,
    /// The error that 99 % of the counted pixels do not exceed.
    pub p99: f64,
    /// Share of the counted pixels where the truth is 0 and the answer is more than 0.1.
    pub umbra_lit: f64,
    /// Share of the counted pixels where the truth is 1 and the answer is less than 0.9.
    pub lit_dark: f64,
}

impl SoftError {
    /// Root mean squared error over the pixels where the truth lies between 0 and 1. `None` if there are no such
    /// pixels, because then nothing is known.
    pub fn penumbra_rmse(&self) -> Option<f64> {
        (self.penumbra > 0).then_some(self.rmse_penumbra)
    }
}

/// Whether each pixel lies within `radius` pixels of a change of the image, or of the border of the region
/// that counts.
///
/// The image wraps round at its borders, as in `tools/truth.py`, so that both exclude the same pixels.
pub fn edge_band(image: &VisibilityImage, radius: u32) -> Vec<bool> {
    let (width, height) = (image.size().x as usize, image.size().y as usize);
    let values: Vec<f32> = image
        .values()
        .iter()
        .map(|value| if value.is_nan() { -1.0 } else { *value })
        .collect();
    let (radius_x, radius_y) = ((radius as usize).min(width), (radius as usize).min(height));
    let mut band = Vec::with_capacity(values.len());
    for y in 0..height {
        for x in 0..width {
            let value = values[y * width + x];
            band.push((0..=2 * radius_y).any(|dy| {
                let row = (y + height + dy - radius_y) % height * width;
                (0..=2 * radius_x).any(|dx| values[row + (x + width + dx - radius_x) % width] != value)
            }));
        }
    }
    band
}

/// Counts wrong pixels. A band of one pixel around edges is counted separately.
///
/// # Errors
/// [`ReferenceError::Size`] if the images differ in size.
pub fn compare_hard(truth: &VisibilityImage, got: &VisibilityImage) -> Result<HardError, ReferenceError> {
    let band = edge_band(truth, 1);
    let mut error = HardError {
        counted: 0,
        inner: 0,
        wrong_inner: 0,
        wrong_all: 0,
    };
    for (difference, in_band) in differences(truth, got)?.zip(band) {
        let Some(difference) = difference else { continue };
        let is_wrong = usize::from(difference > 0.5);
        error.counted += 1;
        error.wrong_all += is_wrong;
        if !in_band {
            error.inner += 1;
            error.wrong_inner += is_wrong;
        }
    }
    Ok(error)
}

/// Measures the error of a soft shadow. `None` if no pixel counts, because then nothing is known.
///
/// # Errors
/// [`ReferenceError::Size`] if the images differ in size.
pub fn compare_soft(
    truth: &VisibilityImage,
    got: &VisibilityImage,
) -> Result<Option<SoftError>, ReferenceError> {
    let mut counted: Vec<f64> = Vec::new();
    let mut sum_sq_penumbra = 0.0;
    let (mut penumbra, mut umbra_lit, mut lit_dark) = (0usize, 0usize, 0usize);
    for (difference, &truth) in differences(truth, got)?.zip(truth.values()) {
        let Some(difference) = difference else { continue };
        counted.push(difference);
        if truth > 0.0 && truth < 1.0 {
            penumbra += 1;
            sum_sq_penumbra += difference * difference;
        }
        umbra_lit += usize::from(truth == 0.0 && difference > 0.1);
        lit_dark += usize::from(truth == 1.0 && difference > 0.1);
    }
    if counted.is_empty() {
        return Ok(None);
    }
    let count = counted.len() as f64;
    let sum_sq: f64 = counted.iter().map(|difference| difference * difference).sum();
    counted.sort_unstable_by(f64::total_cmp);
    Ok(Some(SoftError {
        counted: counted.len(),
        penumbra,
        rmse: (sum_sq / count).sqrt(),
        rmse_penumbra: (sum_sq_penumbra / penumbra.max(1) as f64).sqrt(),
        p99: quantile(&counted, 0.99),
        umbra_lit: umbra_lit as f64 / count,
        lit_dark: lit_dark as f64 / count,
    }))
}

/// The error |got − truth| of every pixel; `None` where the truth does not count. A `got` that is not finite
/// is wrong by 1.
pub(super) fn differences<'a>(
    truth: &'a VisibilityImage,
    got: &'a VisibilityImage,
) -> Result<impl Iterator<Item = Option<f64>> + 'a, ReferenceError> {
    if truth.size() != got.size() {
        return Err(ReferenceError::Size {
            truth: truth.size(),
            got: got.size(),
        });
    }
    let pairs = truth.values().iter().zip(got.values());
    Ok(pairs.map(|(&truth, &got)| {
        let difference = (f64::from(got) - f64::from(truth)).abs();
        (!truth.is_nan()).then(|| if difference.is_finite() { difference } else { 1.0 })
    }))
}

/// Quantile of sorted values with linear interpolation, as in `numpy.quantile`. `sorted` must not be empty.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let low = sorted[place.floor() as usize];
    let high = sorted[place.ceil() as usize];
    low + (high - low) * place.fract()
}
