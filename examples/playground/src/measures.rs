//! Numbers of a frame at each pixel, in false colours: texels per pixel of the selected light's map, and lights.
//!
//! They come from what the frame drew. The renderer counts lights and gives planes of surfaces from its own draw lists, and
//! the light's technique, whichever it is, counts the texels that the surface of a pixel covers
//! ([`Technique::texels`](antumbra::techniques::Technique::texels)).

use antumbra::render::SurfacePlane;
use antumbra::sets::ViewData;
use antumbra::techniques::{SurfacePatch, TexelLookup};
use glam::{DVec2, DVec3, DVec4, UVec2};
use rayon::prelude::*;

/// A number at each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Texels of the selected light's map for each pixel.
    Texels,
    /// Lights drawn at each pixel.
    Lights,
}

/// A colour of a legend: from which value it is meant, and the text beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Least value of the step, or the value itself on a continuous scale.
    pub from: f32,
    /// Its colour, sRGB.
    pub color: [u8; 3],
    /// Text beside the colour in the legend.
    pub text: &'static str,
}

const fn step(from: f32, color: [u8; 3], text: &'static str) -> Step {
    Step { from, color, text }
}

/// Texels for each pixel: below 1 the map's texels are seen, far above 1 they are wasted.
const TEXELS: [Step; 7] = [
    step(1.0 / 64.0, [110, 10, 30], "1/64"),
    step(1.0 / 16.0, [215, 50, 40], "1/16"),
    step(0.25, [245, 165, 60], "1/4"),
    step(1.0, [110, 200, 90], "1"),
    step(4.0, [60, 190, 205], "4"),
    step(16.0, [65, 105, 230], "16"),
    step(64.0, [125, 60, 185], "64"),
];

/// Lights drawn at a pixel.
const LIGHTS: [Step; 11] = [
    step(0.0, [52, 54, 62], "none"),
    step(1.0, [50, 75, 165], "1"),
    step(2.0, [45, 130, 220], "2"),
    step(3.0, [35, 185, 190], "3"),
    step(4.0, [75, 205, 110], "4"),
    step(5.0, [170, 215, 60], "5"),
    step(6.0, [240, 200, 55], "6 to 7"),
    step(8.0, [250, 140, 45], "8 to 11"),
    step(12.0, [235, 75, 45], "12 to 15"),
    step(16.0, [190, 35, 70], "16 to 31"),
    step(32.0, [250, 185, 250], "32 or more"),
];

/// Colour of surfaces without a value.
const NOTHING: [u8; 3] = [70, 70, 76];

/// Colour of pixels without a surface.
const BEHIND: [u8; 3] = [18, 19, 22];

/// Share of a colour's brightness that surfaces seen edge on keep, so that shapes are seen.
const EDGE_ON: f64 = 0.7;

impl Measure {
    /// The legend.
    pub fn steps(self) -> &'static [Step] {
        match self {
            Self::Texels => &TEXELS,
            Self::Lights => &LIGHTS,
        }
    }

    /// The title of the legend.
    pub fn title(self) -> &'static str {
        match self {
            Self::Texels => "Texels per pixel",
            Self::Lights => "Lights per pixel",
        }
    }

    /// The colour of a value, sRGB.
    pub fn color(self, value: f32) -> [u8; 3] {
        let steps = self.steps();
        let next = steps.iter().position(|step| step.from > value);
        match (self, next) {
            (_, Some(0)) => steps[0].color,
            (Self::Lights, Some(next)) => steps[next - 1].color,
            (_, None) => steps[steps.len() - 1].color,
            (Self::Texels, Some(next)) => {
                let (a, b) = (steps[next - 1], steps[next]);
                let share = (value / a.from).log2() / (b.from / a.from).log2();
                std::array::from_fn(|c| {
                    let (a, b) = (f32::from(a.color[c]), f32::from(b.color[c]));
                    (a + (b - a) * share).round() as u8
                })
            }
        }
    }
}

/// The values of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The quantity that the values are of.
    pub measure: Measure,
    /// Size of the picture, pixels.
    pub size: UVec2,
    /// The value of each pixel, rows from the top; NaN where there is none.
    pub values: Vec<f32>,
    /// The values in numbers.
    pub summary: Summary,
    /// The picture in false colours, sRGB RGBA, rows from the top.
    pub rgba8: Vec<u8>,
}

/// The values of a picture in numbers; 0 without a value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of pixels that have a value.
    pub pixels: usize,
    /// Mean.
    pub mean: f64,
    /// 5th percentile.
    pub p5: f32,
    /// Median.
    pub median: f32,
    /// Largest value.
    pub most: f32,
}

impl Summary {
    fn of(values: &[f32]) -> Self {
        let mut sorted: Vec<f32> = values.iter().copied().filter(|value| !value.is_nan()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let Some(&most) = sorted.last() else {
            return Self::default();
        };
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
        Self {
            pixels: sorted.len(),
            mean: sorted.iter().copied().map(f64::from).sum::<f64>() / sorted.len() as f64,
            p5: at(0.05),
            median: at(0.5),
            most,
        }
    }
}

/// Surfaces and lights at the pixels of a frame, read back from the renderer.
#[derive(Debug)]
pub struct Pixels<'a> {
    /// The view of the frame.
    pub view: &'a ViewData,
    /// Texels of the planes of surfaces ([`SurfacePlane::of_texel`]).
    pub planes: &'a [[u32; 2]],
    /// Number of lights drawn at each pixel: of all lights, or of the one whose texels are counted.
    pub lights: &'a [f32],
}

impl Pixels<'_> {
    /// Returns the number of lights at each pixel that shows a surface.
    pub fn lights(&self) -> Measured {
        self.measured(Measure::Lights, |_, _, count| count)
    }

    /// Returns the number of texels for each pixel that the light is drawn at.
    pub fn texels(&self, lookup: &TexelLookup) -> Measured {
        let rays = PixelRays::new(self.view);
        self.measured(Measure::Texels, |pixel, plane, count| {
            let patch = (count > 0.0).then(|| rays.patch(pixel, plane, self.view.eye));
            patch
                .flatten()
                .and_then(|patch| lookup(&patch))
                .map_or(f32::NAN, |texels| texels as f32)
        })
    }

    fn measured(
        &self,
        measure: Measure,
        value: impl Fn(UVec2, &SurfacePlane, f32) -> f32 + Sync,
    ) -> Measured {
        let size = self.view.viewport;
        let width = size.x.max(1);
        let rays = PixelRays::new(self.view);
        let pixels = self.planes.par_iter().zip(self.lights).enumerate();
        let both = pixels.map(|(index, (&texel, &count))| {
            let pixel = UVec2::new(index as u32 % width, index as u32 / width);
            let Some(plane) = SurfacePlane::of_texel(texel) else {
                return (f32::NAN, opaque(BEHIND, 1.0));
            };
            let value = value(pixel, &plane, count);
            let color = if value.is_nan() {
                NOTHING
            } else {
                measure.color(value)
            };
            let facing = plane.normal.as_dvec3().dot(rays.direction(pixel)).abs();
            (value, opaque(color, EDGE_ON + (1.0 - EDGE_ON) * facing))
        });
        let (values, colors): (Vec<f32>, Vec<[u8; 4]>) = both.unzip();
        Measured {
            measure,
            size,
            summary: Summary::of(&values),
            values,
            rgba8: colors.into_flattened(),
        }
    }
}

fn opaque(color: [u8; 3], brightness: f64) -> [u8; 4] {
    let [r, g, b] = color.map(|channel| (f64::from(channel) * brightness).round() as u8);
    [r, g, b, 255]
}

/// The lines of sight through the centres of pixels, relative to the eye. Their points at two depths are linear in the
/// pixel's coordinates.
#[derive(Clone, Copy, Debug)]
struct PixelRays {
    /// Origin of the ray of pixel (0, 0), and its change from one pixel to the next: right, down.
    origin: [DVec3; 3],
    /// Vector along the ray of pixel (0, 0), and its change from one pixel to the next: right, down.
    along: [DVec3; 3],
}

impl PixelRays {
    fn new(view: &ViewData) -> Self {
        let size = view.viewport.as_dvec2();
        let world_from_clip = view.clip_from_world.inverse();
        let point = |x: f64, y: f64, depth: f64| {
            let ndc = DVec2::new((x + 0.5) / size.x * 2.0 - 1.0, 1.0 - (y + 0.5) / size.y * 2.0);
            let point = world_from_clip * DVec4::new(ndc.x, ndc.y, depth, 1.0);
            point.truncate() / point.w - view.eye
        };
        let linear = |depth: f64| {
            let first = point(0.0, 0.0, depth);
            [
                first,
                point(1.0, 0.0, depth) - first,
                point(0.0, 1.0, depth) - first,
            ]
        };
        let (near, inner) = (linear(1.0), linear(0.5));
        Self {
            origin: near,
            along: std::array::from_fn(|k| inner[k] - near[k]),
        }
    }

    fn at([first, right, down]: [DVec3; 3], pixel: DVec2) -> DVec3 {
        first + right * pixel.x + down * pixel.y
    }

    fn direction(&self, pixel: UVec2) -> DVec3 {
        Self::at(self.along, pixel.as_dvec2()).normalize_or_zero()
    }

    /// Returns the part of a plane that a pixel shows. `None` if the plane is seen edge on.
    fn patch(&self, pixel: UVec2, plane: &SurfacePlane, eye: DVec3) -> Option<SurfacePatch> {
        let normal = plane.normal.as_dvec3();
        let on_plane = |pixel: DVec2| {
            let (origin, along) = (Self::at(self.origin, pixel), Self::at(self.along, pixel));
            origin + along * ((f64::from(plane.offset) - normal.dot(origin)) / normal.dot(along))
        };
        // A hundredth of a pixel: a whole one may be beyond the plane's horizon.
        const SMALL: f64 = 0.01;
        let pixel = pixel.as_dvec2();
        let at = on_plane(pixel);
        let sides = [DVec2::X, DVec2::Y].map(|step| (on_plane(pixel + step * SMALL) - at) / SMALL);
        let patch = SurfacePatch { at: eye + at, sides };
        (at.is_finite() && patch.area().is_finite()).then_some(patch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_those_of_the_legend() {
        for measure in [Measure::Texels, Measure::Lights] {
            for step in measure.steps() {
                assert_eq!(measure.color(step.from), step.color, "{measure:?} {}", step.text);
            }
            assert_eq!(measure.color(1e9), measure.steps().last().expect("a step").color);
        }
        assert_eq!(Measure::Lights.color(7.0), Measure::Lights.color(6.0));
        assert_ne!(Measure::Lights.color(8.0), Measure::Lights.color(7.0));
        assert_eq!(Measure::Texels.color(0.0), TEXELS[0].color);
        let between = Measure::Texels.color(2.0);
        assert_eq!(between, [85, 195, 148], "halfway between 1 and 4");
    }

    #[test]
    fn a_summary_leaves_out_what_has_no_value() {
        let values = [f32::NAN, 1.0, 3.0, 2.0, f32::NAN, 6.0];
        let summary = Summary::of(&values);
        assert_eq!((summary.pixels, summary.median, summary.most), (4, 2.0, 6.0));
        assert_eq!(summary.mean, 3.0);
        assert_eq!(Summary::of(&[f32::NAN]), Summary::default());
    }
}
