//! This tool as a wrapper of the compiler, which cargo starts while it builds the variants of the
//! portable libraries.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

/// Crates that are compiled for AVX2 in the variant: the types of the lanes, and the code that uses
/// them. Each of them depends on the first one.
pub const WITH_AVX2: [&str; 4] = ["safe_arch", "wide", "pushbelt_solver", "pushbelt"];
const AVX2: &str = "-Ctarget-feature=+avx2";

/// Set for the compiler of the variant: this tool adds the flags, and then starts what the variable
/// contains, or the compiler.
pub const AS_COMPILER: &str = "PUSHBELT_COMPILER_OF_VARIANT";

/// Starts the compiler with the flags of the variant if cargo has started this tool in its place,
/// and returns how it ended.
pub fn act() -> Option<ExitCode> {
    let wrapper = std::env::var_os(AS_COMPILER)?;
    let mut words = std::env::args_os().skip(1);
    let compiler = words.next()?;
    let words: Vec<_> = words.collect();
    let mut command = if wrapper.is_empty() {
        Command::new(&compiler)
    } else {
        let mut command = Command::new(&wrapper);
        command.arg(&compiler);
        command
    };
    command.args(&words);
    if gets_avx2(&words) {
        command.arg(AVX2);
    }
    Some(match command.status() {
        Ok(status) => status
            .code()
            .and_then(|code| u8::try_from(code).ok())
            .map_or(ExitCode::FAILURE, ExitCode::from),
        Err(error) => {
            eprintln!("can't start {}: {error}", command.get_program().display());
            ExitCode::FAILURE
        }
    })
}

/// Whether arguments of the compiler are those of a crate of the variant. Crates for this machine
/// have no `--target`.
fn gets_avx2(words: &[OsString]) -> bool {
    let name = words.iter().skip_while(|word| *word != "--crate-name").nth(1);
    let listed = name
        .and_then(|name| name.to_str())
        .is_some_and(|name| WITH_AVX2.contains(&name));
    listed && words.iter().any(|word| word == "--target")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn only_the_variants_crates_get_its_flags() {
        for (line, expected) in [
            (
                "--crate-name pushbelt --edition=2024 --target x86_64-pc-windows-gnu",
                true,
            ),
            ("--crate-name wide --target x86_64-unknown-linux-gnu", true),
            ("--crate-name faer --target x86_64-unknown-linux-gnu", false),
            ("--crate-name pushbelt --edition=2024", false),
            ("-vV", false),
        ] {
            assert_eq!(gets_avx2(&words(line)), expected, "{line}");
        }
    }
}
