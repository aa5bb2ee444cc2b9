//! Headlines and bars while the tool works. Bars are drawn on a terminal only, so that logs stay clean.

use std::io::IsTerminal as _;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A headline for what comes next.
pub fn headline(text: &str) {
    if std::io::stderr().is_terminal() {
        eprintln!("\x1b[1;34m▸\x1b[0m \x1b[1m{text}\x1b[0m");
    } else {
        eprintln!("▸ {text}");
    }
}

/// A bar over a known number of things.
pub fn bar(length: usize, what: &'static str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("  {msg} {bar:32} {pos}/{len}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length as u64).with_style(style).with_message(what)
}

/// A spinner with elapsed time, for work of unknown length.
pub fn spinner(what: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("  {spinner} {msg} ({elapsed})")
        .unwrap_or_else(|_| ProgressStyle::default_spinner());
    let spinner = ProgressBar::new_spinner()
        .with_style(style)
        .with_message(what.to_owned());
    spinner.enable_steady_tick(Duration::from_millis(120));
    spinner
}
