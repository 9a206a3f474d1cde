//! The labels of the lights' passes.

use crate::sets::{CompanionPart, FrameLights};

/// The label of each light, by index in [`FrameLights`]. Labels are written again only when they change.
#[derive(Debug, Default)]
pub struct LightLabels {
    labels: Vec<String>,
    /// The light that each label names, and the part of a companion.
    of: Vec<(usize, Option<CompanionPart>)>,
}

impl LightLabels {
    /// Writes the labels of the lights of a frame: `light 3`, and `light 3/on_known` for a companion.
    pub fn follow(&mut self, lights: &FrameLights) {
        let mut completed = 0;
        for (index, light) in lights.lights.iter().enumerate() {
            let of = match light.companion_of {
                None => (index, None),
                Some(companion) => {
                    // Companions are in the order of the lights that they complete.
                    let of_scene = &lights.lights[completed..];
                    completed += of_scene
                        .iter()
                        .take_while(|light| light.companion_of.is_none() && light.entity != companion.light)
                        .count();
                    (completed, Some(companion.part))
                }
            };
            if self.of.get(index) == Some(&of) {
                continue;
            }
            let label = match of {
                (light, None) => format!("light {light}"),
                (light, Some(part)) => format!("light {light}/{}", part.name()),
            };
            if index < self.labels.len() {
                (self.labels[index], self.of[index]) = (label, of);
            } else {
                self.labels.push(label);
                self.of.push(of);
            }
        }
    }

    /// The labels by index in [`FrameLights`].
    pub fn all(&self) -> &[String] {
        &self.labels
    }
}
