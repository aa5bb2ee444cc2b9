//! Headlines while the tool works.

use std::io::IsTerminal as _;

/// Prints a headline for the next part of the work.
pub fn headline(text: &str) {
    if std::io::stderr().is_terminal() {
        eprintln!("\x1b[1;34m▸\x1b[0m \x1b[1m{text}\x1b[0m");
    } else {
        eprintln!("▸ {text}");
    }
}
