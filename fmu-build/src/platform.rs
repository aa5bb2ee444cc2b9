//! Names that FMI and the operating system give to the same binary.

use anyhow::bail;

/// A platform that FMI 2.0 has a folder for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder below `binaries/`.
    pub folder: &'static str,
    /// Extension of a shared library.
    pub extension: &'static str,
}

impl Platform {
    /// Linux on x86-64.
    pub const LINUX64: Self = Self {
        folder: "linux64",
        extension: "so",
    };
    /// Windows on x86-64.
    pub const WIN64: Self = Self {
        folder: "win64",
        extension: "dll",
    };
    const DARWIN64: Self = Self {
        folder: "darwin64",
        extension: "dylib",
    };

    /// The platform that this tool runs on.
    ///
    /// # Errors
    /// FMI 2.0 names no folder for it.
    pub fn host() -> anyhow::Result<Self> {
        Self::of(std::env::consts::OS, std::env::consts::ARCH)
    }

    fn of(system: &str, processor: &str) -> anyhow::Result<Self> {
        match (system, processor) {
            ("linux", "x86_64") => Ok(Self::LINUX64),
            // Importers on Apple's own processors look in the same folder.
            ("macos", "x86_64" | "aarch64") => Ok(Self::DARWIN64),
            ("windows", "x86_64") => Ok(Self::WIN64),
            _ => bail!(
                "FMI 2.0 has no folder for binaries of {system} on {processor}; `cargo fmu build --portable` builds for linux64 \
                 and win64, which are x86-64"
            ),
        }
    }

    /// Path of the binary inside the archive.
    pub fn binary(&self, model_identifier: &str) -> String {
        format!("binaries/{}/{model_identifier}.{}", self.folder, self.extension)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_those_of_the_standard() {
        let linux = Platform::of("linux", "x86_64").unwrap();
        assert_eq!(linux.binary("Model"), "binaries/linux64/Model.so");
        assert_eq!(Platform::of("macos", "aarch64").unwrap().folder, "darwin64");
        assert_eq!(Platform::of("windows", "x86_64").unwrap().extension, "dll");
    }

    #[test]
    fn other_processors_are_refused_by_name() {
        for (system, processor) in [
            ("linux", "aarch64"),
            ("linux", "x86"),
            ("windows", "aarch64"),
            ("freebsd", "x86_64"),
        ] {
            let refused = Platform::of(system, processor).unwrap_err().to_string();
            assert!(refused.contains(&format!("{system} on {processor}")), "{refused}");
        }
    }
}
