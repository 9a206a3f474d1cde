//! Time of the sets F, V, L, I and S: `cargo bench --bench sets --features bevy [-- [--short] [--only PART]]`.
//!
//! The main comparison is [`bevy`](mod@bevy) (feature `bevy`): our sets and Bevy's own light visibility, in one world
//! and one run. [`naive`] compares with the obvious loop. [`touched`] shows what the cost depends on. Results are
//! asserted before anything is timed.

#[cfg(feature = "bevy")]
mod bevy;
mod field;
mod naive;
mod touched;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let short = arguments.iter().any(|argument| argument == "--short");
    let only = arguments.iter().position(|argument| argument == "--only");
    let only = only.and_then(|at| arguments.get(at + 1));
    let wanted = |part: &str| only.is_none_or(|only| only == part);
    if wanted("naive") {
        naive::run(short);
    }
    if wanted("touched") {
        touched::run(short);
    }
    if wanted("bevy") {
        #[cfg(feature = "bevy")]
        bevy::run(short);
        #[cfg(not(feature = "bevy"))]
        println!("\nwithout Bevy: its comparison needs `--features bevy`");
    }
}
