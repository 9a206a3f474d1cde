//! The pixels at which the coverage of edges is computed.

use antumbra::insides::PASSES;
use antumbra::prelude::*;
use antumbra::render::ShaderFile;
use antumbra::techniques::penumbra_wedge::{Overlap, VisibilityBuffer, WedgeCulling};

use super::box_stage;
use super::scenes::rect;
use crate::harness::strict_context;

const WEDGE: &str = "techniques/penumbra_wedge/wedge.wgsl";

/// Visibility that each shaded fragment takes away, so that pixels count them.
const STEP: f32 = 1.0 / 256.0;

/// Replaces the body of a function.
fn with_body(text: &str, function: &str, body: &str) -> String {
    let start = text.find(&format!("fn {function}(")).expect("the function");
    let open = start + text[start..].find("{\n").expect("its body");
    let close = open + text[open..].find("\n}").expect("its end");
    format!("{}{{\n    {body}{}", &text[..open], &text[close..])
}

/// The shader of the wedges in which each fragment whose coverage would be computed adds one step instead.
fn counting_shader() -> String {
    let (_, text) = PASSES
        .iter()
        .find(|(path, _)| *path == WEDGE)
        .expect("the shader");
    let counted = format!("return targets(layered(vec4f(-{STEP:?}), 1u));");
    let nothing = "return targets(NOTHING);";
    let bodies = [
        ("shell", counted.as_str()),
        ("half", &counted),
        ("separator", nothing),
        ("hard_side", nothing),
        ("cap", nothing),
    ];
    let start = text.to_string();
    bodies
        .iter()
        .fold(start, |text, (function, body)| with_body(&text, function, body))
}

/// Wedges cover 3664 fragments. Culling by depth leaves 2332 of them, and culling by stencil leaves 400.
#[test]
fn culling_saves_most_of_the_pixels_that_wedges_cover() {
    let context = strict_context();
    let wedge = |culling| PenumbraWedge {
        culling,
        overlap: Overlap::Additive,
        buffer: VisibilityBuffer::Float,
        ..Default::default()
    };
    let mut stage = box_stage(&context, rect(0.5, 0.5), wedge(WedgeCulling::None));
    // A device of its own state, whose shaders no other test sees.
    let renderer = Renderer::new(context).expect("shaders compose");
    let counting = ShaderFile {
        path: WEDGE,
        source: counting_shader().leak(),
    };
    renderer.gpu().shaders.add(&[counting]).expect("it composes");
    stage.world.insert_resource(renderer);
    let [all, by_depth, by_stencil] =
        [WedgeCulling::None, WedgeCulling::Depth, WedgeCulling::Stencil].map(|culling| {
            let light = stage.lights[0];
            stage.world.entity_mut(light).insert(wedge(culling));
            let rendered = stage.render().expect("a frame");
            let lit = rendered.visibility[0].iter().filter(|value| **value > 0.0);
            (lit.map(|value| 1.0 - value).sum::<f32>() / STEP).round() as u32
        });
    println!("coverage is computed {all} times, {by_depth} by depth, {by_stencil} by stencil");
    assert!(by_stencil > 200, "{by_stencil}");
    assert!(4 * by_depth < 3 * all, "{by_depth} of {all}");
    assert!(4 * by_stencil < by_depth, "{by_stencil} of {by_depth}");
}
