//! Names of a binary in FMI and in the operating system.

use anyhow::bail;

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
    /// Folder below `binaries/` in FMI 2.0. From 2.0.4 on it is that of FMI 3.0 for platforms
    /// without an older name.
    folder: &'static str,
    /// Folder below `binaries/` in FMI 3.0: processor and system.
    pub tuple: &'static str,
    /// Extension of a shared library.
    pub extension: &'static str,
}

impl Platform {
    /// Linux on x86-64.
    pub const LINUX64: Self = Self {
        folder: "linux64",
        tuple: "x86_64-linux",
        extension: "so",
    };
    /// Windows on x86-64.
    pub const WIN64: Self = Self {
        folder: "win64",
        tuple: "x86_64-windows",
        extension: "dll",
    };
    /// Linux on 64-bit ARM.
    pub const LINUX_ARM: Self = Self {
        folder: "aarch64-linux",
        tuple: "aarch64-linux",
        extension: "so",
    };
    /// macOS on x86-64.
    pub const DARWIN64: Self = Self {
        folder: "darwin64",
        tuple: "x86_64-darwin",
        extension: "dylib",
    };
    /// macOS on Apple's own processors.
    pub const DARWIN_ARM: Self = Self {
        folder: "aarch64-darwin",
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
                "binaries for {processor}-{system} are not built; `cargo fmu build --portable` builds for x86_64-linux and \
                 x86_64-windows"
            ),
        }
    }

    /// Path of the binary inside the archive.
    pub fn binary(&self, version: Version, model_identifier: &str) -> String {
        let folder = match version {
            Version::Three => self.tuple,
            Version::Two => self.folder,
        };
        format!("binaries/{folder}/{model_identifier}.{}", self.extension)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_those_of_the_standard() {
        let path = |system, processor, version| {
            let platform = Platform::of(system, processor).unwrap();
            platform.binary(version, "Model")
        };
        for (system, processor, two, three) in [
            ("linux", "x86_64", "linux64/Model.so", "x86_64-linux/Model.so"),
            ("windows", "x86_64", "win64/Model.dll", "x86_64-windows/Model.dll"),
            ("macos", "x86_64", "darwin64/Model.dylib", "x86_64-darwin/Model.dylib"),
            (
                "macos",
                "aarch64",
                "aarch64-darwin/Model.dylib",
                "aarch64-darwin/Model.dylib",
            ),
            ("linux", "aarch64", "aarch64-linux/Model.so", "aarch64-linux/Model.so"),
        ] {
            assert_eq!(path(system, processor, Version::Two), format!("binaries/{two}"));
            assert_eq!(path(system, processor, Version::Three), format!("binaries/{three}"));
        }
    }

    #[test]
    fn other_processors_are_refused_by_name() {
        for (system, processor) in [("linux", "x86"), ("windows", "aarch64"), ("freebsd", "x86_64")] {
            let refused = Platform::of(system, processor).unwrap_err().to_string();
            assert!(refused.contains(&format!("{processor}-{system}")), "{refused}");
        }
    }
}
