//! Time of the sets F, V, L, I, S: `cargo bench --bench sets --features bevy-bench [-- --short]`.
//!
//! [`bevy`](mod@bevy) (feature `bevy-bench`) is the comparison that counts: beside Bevy's own light visibility, in one
//! world and one run. [`naive`] compares with the obvious loop, [`touched`] shows what the cost follows. Answers are
//! asserted before anything is timed.

#[cfg(feature = "bevy-bench")]
mod bevy;
mod field;
mod naive;
mod touched;

fn main() {
    let short = std::env::args().any(|argument| argument == "--short");
    if std::env::var("ONE").is_err() {
        naive::run(short);
    }
    touched::run(short);
    #[cfg(feature = "bevy-bench")]
    bevy::run(short);
    #[cfg(not(feature = "bevy-bench"))]
    println!("\nwithout Bevy: its comparison needs `--features bevy-bench`");
}
