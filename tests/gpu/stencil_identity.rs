//! Ways of drawing the same shadow volumes that must not change a mask: not one bit of it; where far ends lie elsewhere, none
//! but that of a pixel on a shadow's edge in a hundred thousand, since the rasterizer rounds those ends to its grid.

use crate::harness::{ModelStage, file_name, models_below, models_folder, strict_context, truth};
use antumbra::prelude::*;
use antumbra::reference::edge_band;
use antumbra::techniques::stencil_volume::{Counting, Extent, StencilVolumes};
use glam::UVec2;

const SIZE: UVec2 = UVec2::new(128, 72);

/// A way to draw the volumes.
struct Way {
    name: &'static str,
    /// Sides have other far ends, and so other roundings.
    other_ends: bool,
    shadow: StencilVolume,
    settings: RenderSettings,
}

fn ways() -> [Way; 3] {
    let (shadow, settings) = (StencilVolume::default(), RenderSettings::default());
    [
        Way {
            name: "depth-fail forced",
            other_ends: false,
            shadow: StencilVolume {
                counting: Counting::DepthFail,
                ..shadow
            },
            settings,
        },
        Way {
            name: "infinite volumes",
            other_ends: true,
            shadow: StencilVolume {
                extent: Extent::Infinite,
                ..shadow
            },
            settings,
        },
        Way {
            name: "no scissor, no depth bounds",
            other_ends: false,
            shadow,
            settings: RenderSettings {
                scissor: false,
                depth_bounds: false,
                ..settings
            },
        },
    ]
}

/// Differing pixels of two masks, among those that count.
fn differing(counts: &[bool], a: &[f32], b: &[f32]) -> usize {
    let pairs = counts.iter().zip(a.iter().zip(b));
    pairs.filter(|(counts, (a, b))| **counts && a != b).count()
}

#[test]
fn counting_extent_and_bounds_change_no_mask() {
    let folder = models_folder();
    let context = strict_context();
    let mut differences = Vec::new();
    let (mut pixels, mut rounded, mut depth_pass, mut finite) = (0, 0, 0, 0);
    for (index, path) in models_below(&folder).iter().enumerate() {
        let Some(mut model) = ModelStage::new(path, &context, SIZE) else {
            continue;
        };
        let one_of = if model.scene.triangles().len() > 100_000 {
            8
        } else {
            3
        };
        for (label, case) in model.some_cases(index, one_of) {
            let render = |model: &mut ModelStage, shadow, settings| {
                model.stage.world.resource_mut::<Renderer>().settings = settings;
                model.set(&case, shadow);
                let mut rendered = model.stage.render().expect("the frame renders");
                (rendered.visibility.swap_remove(0), rendered.radiance)
            };
            let (usual, radiance) = render(&mut model, StencilVolume::default(), RenderSettings::default());
            let volumes = model.stage.world.resource::<StencilVolumes>();
            for caster in volumes.lights.iter().flat_map(|light| &light.casters) {
                depth_pass += usize::from(caster.depth_pass);
                finite += usize::from(caster.extrusion > 0.0);
            }
            let truth = truth(&model.stage, &model.scene, 0);
            let reached: Vec<bool> = truth.values().iter().map(|value| !value.is_nan()).collect();
            let edges = edge_band(&truth, 1);
            let off_edges: Vec<bool> = reached
                .iter()
                .zip(&edges)
                .map(|(reached, edge)| *reached && !edge)
                .collect();
            pixels += reached.iter().filter(|reached| **reached).count();
            for way in ways() {
                let (mask, lit) = render(&mut model, way.shadow, way.settings);
                // A mask is 1 where scissor or bounds cut the light off; the radiance shows it.
                let cut_off = !way.other_ends && lit != radiance;
                let mut count = differing(&reached, &usual, &mask);
                if way.other_ends {
                    rounded += count;
                    count = differing(&off_edges, &usual, &mask);
                }
                if count > 0 || cut_off {
                    differences.push(format!(
                        "{} {label}, {}: {count} of the mask, radiance: {cut_off}",
                        file_name(path),
                        way.name
                    ));
                }
            }
        }
    }
    println!(
        "{pixels} pixels in each way; {depth_pass} casters by depth-pass, {finite} finite volumes; {rounded} pixels on edges differ by far ends"
    );
    assert!(depth_pass > 100 && finite > 100, "both ways must have been taken");
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    assert!(
        rounded <= pixels / 100_000,
        "{rounded} pixels of {pixels} differ by far ends"
    );
}

#[test]
fn a_difference_is_found() {
    let reached = [true, true, false];
    assert_eq!(differing(&reached, &[0.0, 1.0, 0.0], &[0.0, 1.0, 1.0]), 0);
    assert_eq!(differing(&reached, &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]), 1);
}
