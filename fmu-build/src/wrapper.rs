//! This tool as a wrapper of the compiler and of Zig, which cargo starts while it builds the portable libraries.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::{Command, ExitCode};

/// Crates that are compiled for AVX2 in the variant: the types of the lanes, and the code that uses them. Each of them depends on the
/// first one.
pub const WITH_AVX2: [&str; 4] = ["safe_arch", "wide", "pushbelt_solver", "pushbelt"];
const AVX2: &str = "-Ctarget-feature=+avx2";

/// Set for the compiler of the variant: this tool adds the flags, and then starts what the variable contains, or the compiler.
pub const AS_COMPILER: &str = "PUSHBELT_COMPILER_OF_VARIANT";

/// Set for Zig: the Python interpreter with the package `ziglang`.
pub const AS_ZIG: &str = "PUSHBELT_PYTHON_OF_ZIG";

/// Starts the compiler or Zig if cargo has started this tool in place of them, and returns how it ended.
pub fn act() -> Option<ExitCode> {
    let mut words = std::env::args_os().skip(1);
    let first = words.next()?;
    let rest: Vec<_> = words.collect();
    let is_compiler = Path::new(&first).file_stem() == Some(OsStr::new("rustc"));
    let mut command = if is_compiler {
        compiler(&std::env::var_os(AS_COMPILER)?, &first, &rest)
    } else {
        zig(&std::env::var_os(AS_ZIG)?, &first, &rest)
    };
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

/// The compiler with the flags of the variant, started by another wrapper unless that is empty.
fn compiler(wrapper: &OsStr, compiler: &OsStr, words: &[OsString]) -> Command {
    let mut command = if wrapper.is_empty() {
        Command::new(compiler)
    } else {
        let mut command = Command::new(wrapper);
        command.arg(compiler);
        command
    };
    command.args(words);
    if gets_avx2(words) {
        command.arg(AVX2);
    }
    command
}

/// Whether arguments of the compiler are those of a crate of the variant. Crates for this machine have no `--target`.
fn gets_avx2(words: &[OsString]) -> bool {
    let name = words.iter().skip_while(|word| *word != "--crate-name").nth(1);
    let listed = name
        .and_then(|name| name.to_str())
        .is_some_and(|name| WITH_AVX2.contains(&name));
    listed && words.iter().any(|word| word == "--target")
}

/// Zig with the unwinder alone where `cargo-zigbuild` asks for the whole C++ library, which takes a minute to compile. Rust needs only the
/// unwinder of it.
fn zig(python: &OsStr, subcommand: &OsStr, words: &[OsString]) -> Command {
    let mut command = Command::new(python);
    command.args(["-m", "ziglang"]).arg(subcommand);
    command.args(
        words
            .iter()
            .map(|word| if word == "-lc++" { OsStr::new("-lunwind") } else { word }),
    );
    command
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

    #[test]
    fn zig_links_the_unwinder_instead_of_the_library_of_c_plus_plus() {
        let command = zig(
            OsStr::new("python"),
            OsStr::new("cc"),
            &words("-shared -lc++ -lkernel32"),
        );
        let found: Vec<_> = command.get_args().collect();
        assert_eq!(found, ["-m", "ziglang", "cc", "-shared", "-lunwind", "-lkernel32"]);
    }
}
