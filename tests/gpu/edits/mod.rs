//! A scene that was changed over many frames is drawn as the same scene made at once: nothing that is kept from frame to frame
//! outlives its reason.

mod changes;
mod judge;
mod lamps;
mod shrink;
mod spec;
mod world;

use antumbra::prelude::*;
use antumbra::sets::SetWork;
use antumbra::silhouettes::Silhouettes;

use self::changes::Changes;
use self::judge::{Difference, compare, compare_pictures, facts, statistics};
use self::world::{Live, Step};
use crate::harness::strict_context;

/// Steps of one history.
const STEPS: usize = 14;

/// Runs one frame, and draws it if there is a device.
fn run(live: &mut Live, context: Option<&RenderContext>) {
    match context {
        Some(_) => live.stage.draw().expect("the frame renders"),
        None => live.stage.run(),
    }
}

/// Runs one frame, and compares the world with one that is made of the last step at once.
fn differences(live: &mut Live, step: &Step, context: Option<&RenderContext>) -> Vec<Difference> {
    let mut fresh = Live::fresh(step, live, context);
    let mut found = Vec::new();
    if context.is_none() {
        live.stage.run();
        fresh.stage.run();
        compare(&facts(live), &facts(&fresh), &mut found);
        return found;
    }
    let [shown, other] =
        [&mut *live, &mut fresh].map(|world| world.stage.render().expect("the frame renders"));
    compare(&facts(live), &facts(&fresh), &mut found);
    compare(
        &statistics(live, &shown),
        &statistics(&mut fresh, &other),
        &mut found,
    );
    compare_pictures(&shown, &other, &mut found);
    found
}

/// Frames after the last change compute nothing and show the same.
fn steady(live: &mut Live, frames: usize, context: Option<&RenderContext>) -> Vec<Difference> {
    let mut found = Vec::new();
    let shown = context.map(|_| live.stage.render().expect("the frame renders"));
    if context.is_none() {
        live.stage.run();
    }
    let before = (facts(live), *live.stage.world.resource::<SetWork>());
    for _ in 0..frames {
        run(live, context);
        let extracted = live.stage.world.resource::<Silhouettes>().extracted;
        if extracted > 0 {
            found.push(Difference {
                kind: "extracted".to_owned(),
                text: format!("{extracted} silhouettes at rest"),
            });
        }
    }
    let work = *live.stage.world.resource::<SetWork>();
    if work != before.1 {
        found.push(Difference {
            kind: "work".to_owned(),
            text: format!("work at rest: {:?} then {work:?}", before.1),
        });
    }
    compare(&facts(live), &before.0, &mut found);
    if let Some(shown) = shown {
        let again = live.stage.render().expect("the frame renders");
        compare_pictures(&again, &shown, &mut found);
    }
    found
}

/// Follows a history, and compares at its end.
fn end_of(history: &[Step], rests: usize, context: Option<&RenderContext>) -> Vec<Difference> {
    let mut live = Live::new(context);
    let (last, before) = history.split_last().expect("a history has steps");
    for step in before {
        live.sync(step);
        if step.draws {
            run(&mut live, context);
        }
    }
    live.sync(last);
    let mut found = differences(&mut live, last, context);
    if rests > 0 {
        found.extend(steady(&mut live, rests, context));
    }
    found
}

/// Follows the history of a seed, and compares at some steps. Returns what is to be said of the first difference.
fn follow(seed: u64, context: Option<&RenderContext>) -> Result<(), String> {
    let every = if context.is_some() { 4 } else { 1 };
    let mut changes = Changes::new(seed);
    let mut history = vec![changes.first()];
    let mut live = Live::new(context);
    for at in 0..STEPS {
        let step = history[at].clone();
        live.sync(&step);
        let rests = match (at + 1 == STEPS, context.is_some()) {
            (false, _) => 0,
            (true, true) => 11,
            (true, false) => 3,
        };
        if step.draws && (at % every == every - 1 || at + 1 == STEPS) {
            let mut found = differences(&mut live, &step, context);
            if rests > 0 {
                found.extend(steady(&mut live, rests, context));
            }
            if let Some(first) = found.first() {
                let all: Vec<&str> = found.iter().map(|difference| difference.text.as_str()).collect();
                eprintln!("seed {seed}, step {at}, {}:\n{}", first.kind, all.join("\n"));
                let fails = |history: &[Step]| {
                    let found = end_of(history, rests, context);
                    found.iter().any(|difference| difference.kind == first.kind)
                };
                let mut text = format!("SHRUNK seed {seed}, step {at}: ");
                if !fails(&history) {
                    return Err(text + "does not come again");
                }
                let short = shrink::shrink(history, fails);
                let left = end_of(&short, rests, context);
                let left: Vec<&str> = left.iter().map(|difference| difference.text.as_str()).collect();
                text += &format!("shrunk:\n{}\n{}", left.join("\n"), shrink::describe(&short));
                return Err(text);
            }
        } else if step.draws {
            run(&mut live, context);
        }
        let next = changes.next(&step);
        history.push(next);
    }
    Ok(())
}

/// Follows the histories of some seeds: those of the variable `ANTUMBRA_SEEDS`, as in `3..50`, if it is set.
fn follow_all(default: std::ops::Range<u64>, context: Option<&RenderContext>) {
    let given = std::env::var("ANTUMBRA_SEEDS").ok();
    let given = given.and_then(|text| {
        let (from, to) = text.split_once("..")?;
        Some(from.parse().ok()?..to.parse().ok()?)
    });
    let mut failures = Vec::new();
    for seed in given.unwrap_or(default) {
        let run = std::panic::AssertUnwindSafe(|| follow(seed, context));
        match std::panic::catch_unwind(run) {
            Ok(Ok(())) => {}
            Ok(Err(text)) => {
                eprintln!("{text}");
                failures.push(seed);
            }
            Err(_) => {
                eprintln!("seed {seed} panics");
                failures.push(seed);
            }
        }
    }
    assert!(failures.is_empty(), "seeds {failures:?}");
}

#[test]
fn sets_and_silhouettes_after_changes_are_those_of_a_new_world() {
    follow_all(100..112, None);
}

#[test]
fn pictures_after_changes_are_those_of_a_new_world() {
    follow_all(19..22, Some(&strict_context()));
}
