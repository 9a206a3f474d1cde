//! Errors of the lit pictures. The truth is Bevy's own light on every surface, multiplied by the ray caster's
//! visibility.

use antumbra::reference::{LightSource, RayScene, VisibilityImage, hard_visibility, primary_hits};
use antumbra::scene::{Light, LightSelection};
use bevy::prelude::PointLight;
use bevy_transform::prelude::GlobalTransform;
use glam::{UVec2, Vec3};

use crate::Arguments;
use crate::game::{Game, Shadows};
use crate::rooms::{LUMENS, RANGE, Rooms};

/// Number of lights in the pictures.
const LIGHTS: usize = 9;

/// Number of frames until the picture no longer changes.
const FRAMES: usize = 4;

fn picture(rooms: &Rooms, shadows: Shadows, size: UVec2) -> Vec<Vec3> {
    let mut game = Game::new(rooms, shadows, LIGHTS, size);
    (0..FRAMES).for_each(|_| game.frame());
    game.radiance()
}

/// Returns pictures without shadows: first without any light, then with each light alone.
fn parts(rooms: &Rooms, size: UVec2) -> Vec<Vec<Vec3>> {
    let mut game = Game::new(rooms, Shadows::None, LIGHTS, size);
    let lights = game.lights.clone();
    let mut shine = |chosen: Option<usize>| {
        for (index, &light) in lights.iter().enumerate() {
            let mut light = game.world().get_mut::<PointLight>(light).expect("a light");
            light.intensity = if Some(index) == chosen {
                LUMENS / (LIGHTS as f32).sqrt()
            } else {
                0.0
            };
        }
        (0..FRAMES).for_each(|_| game.frame());
        game.radiance()
    };
    std::iter::once(None)
        .chain((0..lights.len()).map(Some))
        .map(&mut shine)
        .collect()
}

fn visibilities(rooms: &mut Rooms, size: UVec2) -> Result<Vec<VisibilityImage>, String> {
    let scene = RayScene::from_world(&mut rooms.world);
    let view = GlobalTransform::from(rooms.view);
    let hits = primary_hits(&scene, &rooms.camera, &view, size).map_err(|error| error.to_string())?;
    let lamps = rooms.lamps.iter().take(LIGHTS);
    lamps
        .map(|lamp| {
            let light = Light::point(Vec3::ONE, 1.0, RANGE);
            let place = GlobalTransform::from_translation(*lamp);
            let source = LightSource::new(&light, &place, LightSelection::default());
            Ok(hard_visibility(
                &scene,
                &hits,
                &source.map_err(|error| error.to_string())?,
            ))
        })
        .collect()
}

/// Returns the share of the pixels whose colour is wrong by more than a tenth of the true colour, and the root mean
/// square of the relative error.
fn error(got: &[Vec3], truth: &[Vec3]) -> (f64, f64) {
    let relative = |(got, truth): (&Vec3, &Vec3)| {
        let scale = truth.max_element().max(0.02);
        f64::from(((*got - *truth).abs().max_element() / scale).min(1.0))
    };
    let errors: Vec<f64> = got.iter().zip(truth).map(relative).collect();
    let count = errors.len() as f64;
    let wrong = errors.iter().filter(|error| **error > 0.1).count() as f64 / count;
    (
        wrong,
        (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt(),
    )
}

fn bytes(picture: &[Vec3]) -> Vec<u8> {
    let encode = |x: f32| (x.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
    picture
        .iter()
        .flat_map(|texel| texel.to_array().map(encode))
        .collect()
}

/// Draws the relative error: green is 0, and red is 1 or more.
fn heat(got: &[Vec3], truth: &[Vec3]) -> Vec<Vec3> {
    let pairs = got.iter().zip(truth);
    pairs
        .map(|(got, truth)| {
            let scale = truth.max_element().max(0.02);
            let error = ((*got - *truth).abs().max_element() / scale).min(1.0);
            let dim = 0.15 + 0.85 * error;
            Vec3::new((2.0 * error).min(1.0), (2.0 - 2.0 * error).min(1.0), 0.0) * dim
        })
        .collect()
}

/// Puts pictures side by side.
fn beside(pictures: &[&[Vec3]], size: UVec2) -> (UVec2, Vec<Vec3>) {
    let width = size.x as usize;
    let rows =
        (0..size.y as usize).flat_map(|y| pictures.iter().flat_map(move |p| p[y * width..][..width].iter()));
    (
        UVec2::new(size.x * pictures.len() as u32, size.y),
        rows.copied().collect(),
    )
}

/// Writes pictures and prints errors.
///
/// # Errors
/// One line that names the file.
pub fn compare(mut rooms: Rooms, arguments: &Arguments) -> Result<(), String> {
    let size = arguments.size;
    let parts = parts(&rooms, size);
    let visible = visibilities(&mut rooms, size)?;
    let (dark, alone) = parts.split_first().ok_or("there is no light")?;
    let truth: Vec<Vec3> = (0..dark.len())
        .map(|p| {
            let lit = alone.iter().zip(&visible).map(|(alone, visible)| {
                // Where visibility is undefined, no light arrives.
                let share = visible.values()[p];
                (alone[p] - dark[p]) * if share.is_nan() { 0.0 } else { share }
            });
            dark[p] + lit.sum::<Vec3>()
        })
        .collect();
    let bevy = picture(&rooms, Shadows::Bevy, size);
    let ours = picture(&rooms, Shadows::Antumbra, size);
    let write = |name: &str, size: UVec2, picture: &[Vec3]| {
        let path = arguments.out.join(name);
        image::save_buffer(
            &path,
            &bytes(picture),
            size.x,
            size.y,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(|error| format!("{}: {error}", path.display()))
    };
    for (name, picture) in [("bevy", &bevy), ("antumbra", &ours)] {
        let (wrong, rms) = error(picture, &truth);
        println!(
            "{name}: {:.2} % of the pixels wrong by more than a tenth, relative RMS error {rms:.4}",
            100.0 * wrong
        );
        write(&format!("{name}.png"), size, picture)?;
    }
    write("truth.png", size, &truth)?;
    let (wide, pictures) = beside(&[&bevy, &ours, &truth], size);
    write("bevy_antumbra_truth.png", wide, &pictures)?;
    let (wide, errors) = beside(&[&heat(&bevy, &truth), &heat(&ours, &truth)], size);
    write("errors_bevy_antumbra.png", wide, &errors)?;
    println!("{}", arguments.out.join("bevy_antumbra_truth.png").display());
    Ok(())
}
