//! Shows what tight wedges and culling save. Compares the pixels that wedges cover and the times of frames with those
//! of wedges around a sphere and of a plain renderer, in one run.
//!
//! Section 6 of Assarsson et al. 2003 reports factors of 1.2 to 2 for tight wedges.

use std::path::Path;
use std::time::Instant;

use antumbra::insides::build_penumbra_wedges;
use antumbra::prelude::*;
use antumbra::techniques::PenumbraWedges;
use antumbra::techniques::penumbra_wedge::{
    CoverageMaths, Overlap, VisibilityBuffer, WedgeBounds, WedgeCulling, WedgeSilhouette,
};
use bevy_ecs::system::RunSystemOnce;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::soft_pages::{LIGHT, SQUARE, WIDE, casters};
use super::support::stage::{Stage, one_line};

/// Number of frames of which a time is the median.
const RUNS: usize = 9;

/// Amount that the debug view adds to blue where a wedge's front and back are in front of the surface.
const DEBUG_BLUE: f32 = 0.03;

/// Prints a line for each scene and light.
///
/// # Errors
/// One line that names the file and the element.
pub fn print(context: &RenderContext, assets: &Path, size: UVec2) -> Result<(), String> {
    let ours = PenumbraWedge::default();
    let sphere = PenumbraWedge {
        bounds: WedgeBounds::Sphere,
        ..ours
    };
    let ways = [
        ("ours", ours),
        ("sphere bounds", sphere),
        (
            "stencil culled",
            PenumbraWedge {
                culling: WedgeCulling::Stencil,
                ..ours
            },
        ),
        (
            "not culled",
            PenumbraWedge {
                culling: WedgeCulling::None,
                ..ours
            },
        ),
        (
            "plain",
            PenumbraWedge {
                culling: WedgeCulling::None,
                ..sphere
            },
        ),
        (
            "additive",
            PenumbraWedge {
                overlap: Overlap::Additive,
                ..ours
            },
        ),
        (
            "additive half",
            PenumbraWedge {
                overlap: Overlap::Additive,
                buffer: VisibilityBuffer::Half,
                ..ours
            },
        ),
        (
            "additive split8",
            PenumbraWedge {
                buffer: VisibilityBuffer::Split8,
                ..ours
            },
        ),
        (
            "additive tables",
            PenumbraWedge {
                overlap: Overlap::Additive,
                maths: CoverageMaths::Tables,
                ..ours
            },
        ),
        (
            "from the centre",
            PenumbraWedge {
                silhouette: WedgeSilhouette::Center,
                ..ours
            },
        ),
    ];
    println!("{size}, {}; times as ratios to ours", context.adapter);
    for page in casters(&assets.join("models")) {
        let mut stage = page.stage(size)?.stage;
        let added = stage.add_renderer(context.clone(), RenderSettings::default());
        added.map_err(|error| one_line(&error))?;
        for (name, kind) in [("square", SQUARE), ("wide", WIDE)] {
            set_light(&mut stage, kind, ours);
            let first = visibility(&mut stage)?;
            let mut covered = [0.0; 2];
            for (covered, wedge) in covered.iter_mut().zip([ours, sphere]) {
                set_light(&mut stage, kind, wedge);
                *covered = cover(&mut stage)?;
            }
            set_light(&mut stage, kind, ways[4].1);
            let plain = visibility(&mut stage)?;
            let apart = first.iter().zip(&plain).map(|(a, b)| (a - b).abs());
            let apart = apart.filter(|apart| *apart > 2e-3).count();
            // The variants take turns, so that drift affects all of them equally.
            let mut times = vec![Vec::new(); ways.len()];
            for run in 0..=RUNS {
                for ((_, wedge), times) in ways.iter().zip(&mut times) {
                    let entity = stage.lights[0];
                    stage.world.entity_mut(entity).insert(*wedge);
                    stage.draw().map_err(|error| one_line(&error))?; // creates chunks and pipelines
                    let begin = Instant::now();
                    stage.draw().map_err(|error| one_line(&error))?;
                    if run > 0 {
                        times.push(begin.elapsed().as_secs_f64() * 1e3);
                    }
                }
            }
            let medians: Vec<f64> = times
                .iter_mut()
                .map(|times| {
                    times.sort_by(f64::total_cmp);
                    times[RUNS / 2]
                })
                .collect();
            let mut line = format!(
                "{:<9} {name:<7} covered {:>9.0} px, sphere bounds {:.2}x; ours {:.1} ms",
                page.name,
                covered[0],
                covered[1] / covered[0].max(1.0),
                medians[0]
            );
            for ((name, _), time) in ways.iter().zip(&medians).skip(1) {
                line += &format!(", {name} {:.2}x", time / medians[0]);
            }
            println!("{line}; plain differs at {apart} px");
            set_light(&mut stage, kind, ours);
            println!("{}", build(&mut stage, medians[0])?);
        }
    }
    Ok(())
}

/// Replaces the light of a stage.
fn set_light(stage: &mut Stage, kind: LightKind, wedge: PenumbraWedge) {
    for light in std::mem::take(&mut stage.lights) {
        stage.world.despawn(light);
    }
    let light = Light {
        kind,
        color: Vec3::ONE,
        intensity: 70.0,
        range: f32::INFINITY,
    };
    let place = Transform::from_translation(LIGHT).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
    stage.spawn_light(light, place, Some(wedge));
}

/// Times the construction of all wedges on the CPU, as after a move of the light, and compares it with a frame of
/// `frame` milliseconds.
fn build(stage: &mut Stage, frame: f64) -> Result<String, String> {
    stage.draw().map_err(|error| one_line(&error))?;
    let mut times = Vec::new();
    for _ in 0..RUNS {
        stage.world.insert_resource(PenumbraWedges::default());
        let begin = Instant::now();
        stage
            .world
            .run_system_once(build_penumbra_wedges)
            .map_err(|error| error.to_string())?;
        times.push(begin.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    let edges = stage.world.resource::<PenumbraWedges>().wedges.len();
    let build = times[RUNS / 2];
    Ok(format!(
        "          build of {edges} wedges {build:.3} ms, {:.2} us each, {:.1} % of the frame",
        build * 1e3 / edges.max(1) as f64,
        100.0 * build / frame
    ))
}

fn visibility(stage: &mut Stage) -> Result<Vec<f32>, String> {
    let rendered = stage.render().map_err(|error| one_line(&error))?;
    Ok(rendered.visibility[0].clone())
}

/// Counts the pixels that wedges cover, by the debug view. A pixel counts once for each wedge over it.
fn cover(stage: &mut Stage) -> Result<f64, String> {
    let mut blue = |debug_volumes: bool| {
        stage.world.resource_mut::<Renderer>().settings.debug_volumes = debug_volumes;
        let rendered = stage.render().map_err(|error| one_line(&error))?;
        let blue = rendered.radiance.iter().skip(2).step_by(4);
        Ok::<f64, String>(blue.map(|&blue| f64::from(blue)).sum())
    };
    Ok((blue(true)? - blue(false)?) / f64::from(DEBUG_BLUE))
}
