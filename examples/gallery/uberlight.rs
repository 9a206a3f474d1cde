//! One bust under the lights of a cinematographer: the looks of figures 10-1 to 10-8 of their paper. Each look is a shot
//! file of `examples/shots/uberlight`, so an artist changes it without a compiler.
//!
//! After Pellacini and Vidimce 2004, "Cinematic Lighting", GPU Gems, chapter 10.

use std::path::Path;

use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use glam::UVec2;
use serde_json::{Value, json};

use super::judge::Workbench;
use super::panels::reduce;
use super::support::picture::write_png;
use super::support::shot::Shot;
use super::support::stage::{Stage, one_line};

/// Name for `--only`, file names and links.
pub const NAME: &str = "uberlight";

/// A look: its shot file, and text that tells the reader what to look for.
struct Look {
    shot: &'static str,
    title: &'static str,
    caption: &'static str,
}

const LOOKS: [Look; 8] = [
    Look {
        shot: "plain",
        title: "A spot light",
        caption: "One hard light without a model, to compare with.",
    },
    Look {
        shot: "film_noir",
        title: "Film noir",
        caption: "Barn doors let a slit of light fall across the eyes, a second light draws the edge of the head, and a blind \
                  lies on the wall: a cookie of a light that lights the wall alone. Shadows are black.",
    },
    Look {
        shot: "musical",
        title: "Musical",
        caption: "Bright, warm and soft. Shadows take half of the light away and give some pink in its place, so no part of \
                  the face is dark.",
    },
    Look {
        shot: "window",
        title: "Window",
        caption: "A window that is not there, with the twigs before it: a cookie of a warm spot light, under hard shadows of \
                  the bust itself.",
    },
    Look {
        shot: "pierced_lamp",
        title: "Pierced lamp",
        caption: "A point light in a lamp of pierced metal: a cookie that is a cube around the light, from a picture of its \
                  six sides in a cross.",
    },
    Look {
        shot: "barn_door",
        title: "Barn doors",
        caption: "A superellipse, between a rectangle and an ellipse, with a soft edge: the light stays on the face and on a \
                  piece of the wall.",
    },
    Look {
        shot: "coloured_shadow",
        title: "Coloured shadow",
        caption: "The shadow of a warm light is blue. It keeps the diffuse gradients of the light, and has no highlights.",
    },
    Look {
        shot: "profile",
        title: "Luminaires",
        caption: "Two wall lamps by the IES file of a luminaire: a wide lobe below, a narrow one above.",
    },
];

/// Renders every look, and writes its picture to `out`. Pictures are upright. Returns a scene of the page, whose pictures have
/// no truth and no numbers.
///
/// # Errors
/// One line that names the file and the element.
pub fn draw(bench: &Workbench, shots: &Path, out: &Path) -> Result<Value, String> {
    let height = bench.shown().y;
    let size = UVec2::new(height * 4 / 5, height);
    let mut ways = Vec::new();
    for look in LOOKS {
        let path = shots.join(format!("{}.json", look.shot));
        let mut shot = Shot::load(&path, Techniques::default())?;
        shot.size = (2 * size).to_array();
        let mut stage = Stage::of_shot(&shot)?;
        stage.world.insert_resource(FaceCulling::None);
        let settings = RenderSettings {
            ambient: shot.ambient.into(),
            ..Default::default()
        };
        let named =
            |error: antumbra::render::RenderError| format!("{}: {}", path.display(), one_line(&error));
        stage
            .add_renderer(bench.context.clone(), settings)
            .map_err(named)?;
        let picture = bench.beside(|| stage.picture()).map_err(named)?;
        let pixels = reduce(2 * size, &picture, size);
        let file = format!("{NAME}-{}.png", look.shot);
        write_png(&out.join(&file), size, &pixels)?;
        let pictures = json!({ "picture": file });
        ways.push(
            json!({"name": look.shot, "title": look.title, "caption": look.caption, "pictures": pictures}),
        );
    }
    let shot = json!({"name": "looks", "caption": "Looks of the paper, each one shot file", "truth": null, "ways": ways});
    Ok(json!({
        "name": NAME,
        "title": "The cinematographer’s light",
        "about": "The light model beside the techniques: barn doors, cookies, luminaires, coloured shadows. Open one and wipe \
                  it against another.",
        "shots": [shot],
    }))
}
