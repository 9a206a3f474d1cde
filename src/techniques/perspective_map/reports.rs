//! Reports about perspective maps.

use bevy_ecs::prelude::*;

use super::component::{PerspectiveMap, PerspectiveProjection};
use super::fit::Fit;
use super::grounds::{BlurredGrounds, LeftOut};
use crate::reports::Round;
use crate::sets::{FrameLights, View, ViewData};
use crate::techniques::maps::Maps;

/// Share of the picture's height that the median texel covers, from which on a shadow is reported as coarse. From 3 % of the
/// pixels on were wrong in such views.
const COARSE_SHARE: f64 = 1.0 / 12.0;

/// Raises the reports of this frame. `fits` are the indices of lights and how their maps were fitted.
pub fn report(world: &World, fits: &[(usize, Fit)], round: &mut Round) {
    report_left_out(world, round);
    let Some(view) = &world.resource::<View>().data else {
        return;
    };
    report_coarse(world, view, fits, round);
    if view.is_orthographic() {
        report_uniform(world, round);
    }
}

/// Raises a report for each ground that is not blurred.
fn report_left_out(world: &World, round: &mut Round) {
    for &(entity, left_out) in &world.resource::<BlurredGrounds>().left_out {
        let (code, why) = match left_out {
            LeftOut::TooMany => (
                2,
                "four other grounds are blurred already. Remove the component from some, or put grounds into one plane",
            ),
            LeftOut::Radius => (3, "its radius must be finite and greater than 0"),
        };
        round.raise(Some(entity), code, || {
            format!("The shadows of perspective maps are not blurred on this `BlurredGround`: {why}.")
        });
    }
}

/// Raises a report for each light whose texels are much larger than pixels, although its map has about as many or more.
fn report_coarse(world: &World, view: &ViewData, fits: &[(usize, Fit)], round: &mut Round) {
    let lights = &world.resource::<FrameLights>().lights;
    let maps = world.resource::<Maps>();
    let height = f64::from(view.viewport.y);
    for &(light, fit) in fits {
        let Some(map) = maps.of_light(light) else {
            continue;
        };
        // A map of fewer texels than pixels is as coarse as it was asked for.
        let share = fit.usual_side / f64::from(map.resolution).max(height);
        if share > COARSE_SHARE {
            // A power of two does not change with every move of the view.
            let pixels = (share * height).log2().floor().exp2();
            let entity = lights[light].entity;
            let settings = world.get::<PerspectiveMap>(entity);
            let why = match settings.map(|settings| settings.projection) {
                Some(PerspectiveProjection::SlideBack) => {
                    "the virtual viewer stands behind all casters. Set the projection to `Inverse`"
                }
                _ => {
                    "it lights what is very near and what is very far. Leave the far things to another light by layers"
                }
            };
            round.state(
                Some(entity),
                4,
                format_args!(
                    "The light's perspective map is coarse in this view: half of what is visible has texels that cover \
                     {pixels} pixels or more along a side, because {why}, raise the resolution, or use a ShadowMap or OmniMap."
                ),
            );
        }
    }
}

/// Raises a report for each light that gains nothing by a perspective map, because the view is orthographic.
fn report_uniform(world: &World, round: &mut Round) {
    let lights = &world.resource::<FrameLights>().lights;
    for light in lights
        .iter()
        .filter(|light| light.is_shadowed_by::<PerspectiveMap>())
    {
        round.raise(Some(light.entity), 1, || {
            "The light's perspective map is a uniform one: the view is orthographic, and shows near and far \
             alike. A ShadowMap or OmniMap is kept from frame to frame and looks the same."
                .to_owned()
        });
    }
}
