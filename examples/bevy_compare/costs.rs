//! Costs of frames without shadows, with Bevy's maps and with our volumes.

use std::time::Instant;

use crate::Arguments;
use crate::game::{Game, Shadows};
use crate::rooms::Rooms;

/// Time of a frame, milliseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    cpu: f64,
    gpu: f64,
}

impl Cost {
    fn all(self) -> f64 {
        self.cpu + self.gpu
    }
}

/// Number of frames before timing starts. They create pipelines and allocate textures.
const WARM_UP: usize = 4;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Times frames of a game in which the camera turns and four balls move.
fn cost(rooms: &Rooms, shadows: Shadows, lights: usize, arguments: &Arguments) -> Cost {
    let mut game = Game::new(rooms, shadows, lights, arguments.size);
    let mut times = Vec::new();
    for frame in 0..WARM_UP + arguments.frames.max(1) {
        game.advance(rooms, frame as f32 / 30.0);
        let begin = Instant::now();
        game.frame();
        game.wait();
        let done = begin.elapsed();
        let submitted = game.recorded() - begin;
        if frame >= WARM_UP {
            times.push((
                submitted.as_secs_f64() * 1e3,
                (done - submitted).as_secs_f64() * 1e3,
            ));
        }
    }
    Cost {
        cpu: median(times.iter().map(|time| time.0).collect()),
        gpu: median(times.iter().map(|time| time.1).collect()),
    }
}

/// Prints the table.
pub fn compare(rooms: &Rooms, arguments: &Arguments) {
    println!(
        "\nmilliseconds of a frame of {}x{}; a camera that turns, four balls that move; added: to a frame without shadows",
        arguments.size.x, arguments.size.y
    );
    for &lights in &arguments.lights {
        let lights = lights.clamp(1, rooms.lamps.len());
        let [none, bevy, ours] = [Shadows::None, Shadows::Bevy, Shadows::Antumbra]
            .map(|shadows| cost(rooms, shadows, lights, arguments));
        let added = [bevy, ours].map(|cost| cost.all() - none.all());
        println!(
            "without {lights} {:.2} {:.2}, added by Bevy {:.2}, by antumbra {:.2}: {:.2} of Bevy's",
            none.cpu,
            none.gpu,
            added[0],
            added[1],
            added[1] / added[0]
        );
        println!(
            "frame {lights} {:.2} {:.2} {:.2} {:.2}",
            bevy.cpu, bevy.gpu, ours.cpu, ours.gpu
        );
    }
}
