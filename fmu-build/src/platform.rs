//! Names of a binary in FMI and in the operating system.

use anyhow::{Context, bail};

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// A platform that a binary is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder below `binaries/` in FMI 2.0, which names few platforms.
    folder: Option<&'static str>,
    /// Folder below `binaries/` in FMI 3.0: processor and system.
    pub tuple: &'static str,
    /// Extension of a shared library.
    pub extension: &'static str,
}

impl Platform {
    /// Linux on x86-64.
    pub const LINUX64: Self = Self {
        folder: Some("linux64"),
        tuple: "x86_64-linux",
        extension: "so",
    };
    /// Windows on x86-64.
    pub const WIN64: Self = Self {
        folder: Some("win64"),
        tuple: "x86_64-windows",
        extension: "dll",
    };
    /// Linux on 64-bit ARM.
    pub const LINUX_ARM: Self = Self {
        folder: None,
        tuple: "aarch64-linux",
        extension: "so",
    };
    /// macOS on x86-64.
    pub const DARWIN64: Self = Self {
        folder: Some("darwin64"),
        tuple: "x86_64-darwin",
        extension: "dylib",
    };
    /// macOS on Apple's own processors. Importers of FMI 2.0 look in the same folder as on x86-64.
    pub const DARWIN_ARM: Self = Self {
        folder: Some("darwin64"),
        tuple: "aarch64-darwin",
        extension: "dylib",
    };

    /// The platform that this tool runs on.
    ///
    /// # Errors
    /// Binaries for it have no name.
    pub fn host() -> anyhow::Result<Self> {
        Self::of(std::env::consts::OS, std::env::consts::ARCH)
    }

    fn of(system: &str, processor: &str) -> anyhow::Result<Self> {
        match (system, processor) {
            ("linux", "x86_64") => Ok(Self::LINUX64),
            ("linux", "aarch64") => Ok(Self::LINUX_ARM),
            ("macos", "x86_64") => Ok(Self::DARWIN64),
            ("macos", "aarch64") => Ok(Self::DARWIN_ARM),
            ("windows", "x86_64") => Ok(Self::WIN64),
            _ => bail!(
                "binaries for {system} on {processor} are not built; `cargo fmu build --portable` builds for linux64 \
                 and win64, which are x86-64"
            ),
        }
    }

    /// Path of the binary inside the archive.
    ///
    /// # Errors
    /// The version names no folder for the platform.
    pub fn binary(&self, version: Version, model_identifier: &str) -> anyhow::Result<String> {
        let folder = match version {
            Version::Three => self.tuple,
            Version::Two => self.folder.with_context(|| {
                format!(
                    "FMI 2.0 has no folder for binaries of {}; FMI 3.0 has one (`cargo fmu build --fmi3`), and \
                     `cargo fmu build --portable` builds for linux64 and win64, which are x86-64",
                    self.tuple
                )
            })?,
        };
        Ok(format!("binaries/{folder}/{model_identifier}.{}", self.extension))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_those_of_the_standard() {
        let path = |system, processor, version| {
            let platform = Platform::of(system, processor).unwrap();
            platform.binary(version, "Model").unwrap()
        };
        for (system, processor, two, three) in [
            ("linux", "x86_64", "linux64/Model.so", "x86_64-linux/Model.so"),
            ("windows", "x86_64", "win64/Model.dll", "x86_64-windows/Model.dll"),
            ("macos", "x86_64", "darwin64/Model.dylib", "x86_64-darwin/Model.dylib"),
            ("macos", "aarch64", "darwin64/Model.dylib", "aarch64-darwin/Model.dylib"),
        ] {
            assert_eq!(path(system, processor, Version::Two), format!("binaries/{two}"));
            assert_eq!(path(system, processor, Version::Three), format!("binaries/{three}"));
        }
        let arm = path("linux", "aarch64", Version::Three);
        assert_eq!(arm, "binaries/aarch64-linux/Model.so");
    }

    #[test]
    fn other_processors_are_refused_by_name() {
        for (system, processor) in [("linux", "x86"), ("windows", "aarch64"), ("freebsd", "x86_64")] {
            let refused = Platform::of(system, processor).unwrap_err().to_string();
            assert!(refused.contains(&format!("{system} on {processor}")), "{refused}");
        }
        let refused = Platform::LINUX_ARM.binary(Version::Two, "Model").unwrap_err();
        assert!(refused.to_string().contains("aarch64-linux"), "{refused}");
    }
}
