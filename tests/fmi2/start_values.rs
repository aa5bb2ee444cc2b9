//! Start values of a user's own, from a file in the resources.

use std::ffi::CString;
use std::fs;
use std::path::PathBuf;

use pushbelt::fmi::log::Status::Ok;
use pushbelt::fmi::start_values::FILE;
use pushbelt::unit::exports::c_abi::*;

use pushbelt_lab::shared_library::{Library, OK};
use pushbelt_lab::shared_library3::Watches;

use crate::importer::*;

/// A folder of resources, removed at the end.
struct Resources(PathBuf);

impl Resources {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pushbelt start {name} {}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        Self(folder)
    }

    /// An instance with these bytes as start values.
    fn with(&self, content: &[u8]) -> Importer {
        fs::write(self.0.join(FILE), content).expect("a file");
        self.importer()
    }

    fn importer(&self) -> Importer {
        let path = self.0.to_str().expect("text").replace('\\', "/").replace(' ', "%20");
        let location = CString::new(format!("file:///{}", path.trim_start_matches('/'))).expect("no zero inside");
        Importer::with_resources(c"own", &location)
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn values_of_the_file_apply_at_the_start_and_after_a_reset() {
    let resources = Resources::new("good");
    let text = "# a comment\r\nfriction.pulley = 0.085\n\n  mesh.strand=4\nmesh.primaryArc = 4\nmesh.secondaryArc = 4\n\
                ring.model = 1\ninitial.steady = false\nprimary.clampingForce = 14e3\n";
    let importer = resources.with(text.as_bytes());
    assert!(!importer.c.is_null(), "{:?}", importer.record);
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi2SetReal(importer.c, &reference("friction.pulley"), 1, &0.08), Ok);
        assert_eq!(fmi2Reset(importer.c), Ok);
    }
    importer.start();
    assert_eq!(importer.real("friction.pulley"), 0.085);
    assert_eq!(importer.real("friction.ring"), 0.05, "the default");
    assert_eq!(importer.real("primary.clampingForce"), 14_000.0);
    assert_eq!(
        (importer.integer("ring.model"), importer.boolean("initial.steady")),
        (1, 0)
    );
    let set = Importer::new(c"set");
    set.make_cheap();
    assert_eq!(set.set_real("friction.pulley", 0.085), Ok);
    assert_eq!(set.set_real("primary.clampingForce", 14e3), Ok);
    set.start();
    assert_eq!(importer.run(), set.run(), "as if they had been set");
}

#[test]
fn set_values_take_precedence_over_the_file() {
    let resources = Resources::new("set");
    let importer = resources.with(b"friction.pulley = 0.085");
    importer.make_cheap();
    assert_eq!(importer.set_real("friction.pulley", 0.08), Ok);
    importer.start();
    assert_eq!(importer.real("friction.pulley"), 0.08);
}

#[test]
fn an_unusable_file_is_an_error_that_names_it() {
    let resources = Resources::new("bad");
    let large = [b'#'; (1 << 20) + 1];
    for (content, words) in [
        (
            &b"friction.pulley 0.085"[..],
            "line 1: \"friction.pulley 0.085\" is not of the form name = value",
        ),
        (
            b"\nfriction.pully = 0.085",
            "line 2: there is no variable \"friction.pully\"",
        ),
        (
            b"mesh.aligned = true",
            "line 1: mesh.aligned (value reference 1075) was removed: the FMU of the comparison",
        ),
        (b"friction.pulley = high", "friction.pulley = \"high\" is not a number"),
        (b"friction.pulley = nan", "friction.pulley = NaN is not a finite number"),
        (b"friction.pulley = 3", "friction.pulley = 3 is out of range: 0 to 1"),
        (b"ring.model = ALE", "ring.model = \"ALE\" is not a whole number"),
        (b"ring.model = 7", "ring.model = 7 is out of range: 1 ALE0"),
        (b"mesh.strand = 4.5", "mesh.strand = \"4.5\" is not a whole number"),
        (b"initial.steady = 0", "initial.steady = \"0\" is not a truth value"),
        (b"slip = 0.1", "slip is calculated"),
        (
            b"friction.ring = 0.1\nfriction.ring = 0.1",
            "line 2: friction.ring is set twice",
        ),
        (b"\xff\xfe", "not text in UTF-8"),
        (&large, "more than 1048576 bytes"),
    ] {
        let importer = resources.with(content);
        assert!(importer.c.is_null(), "{words}");
        let message = importer.last();
        assert!(message.contains(FILE) && message.contains(words), "{message}");
    }
    fs::remove_file(resources.0.join(FILE)).expect("there");
    assert!(!resources.importer().c.is_null(), "without the file the defaults hold");
    fs::create_dir(resources.0.join(FILE)).expect("a folder");
    let importer = resources.importer();
    assert!(
        importer.c.is_null() && importer.last().contains("not a file"),
        "{:?}",
        importer.record
    );
}

/// The importer passes no location: the library looks beside itself.
#[test]
fn a_library_finds_the_file_beside_the_folder_of_binaries() {
    let unpacked = Resources::new("unpacked");
    let folder = |name: &str| {
        let folder = unpacked.0.join(name);
        fs::create_dir_all(&folder).expect("a folder");
        folder
    };
    let binary = folder("binaries/linux64").join("PushbeltVariator.so");
    fs::copy(pushbelt_lab::shared_library::path(), &binary).expect("a copy");
    fs::write(folder("resources").join(FILE), "friction.pulley = 0.085").expect("a file");
    let library = Library::load_from(&binary);
    let (f, f3) = (&library.functions, &library.functions3);
    let (c, c3) = (f.instantiate(), f3.instantiate(Watches::default()));
    let (friction, mut values) = (reference("friction.pulley"), [0.0; 2]);
    // SAFETY: instances, and places for values.
    unsafe {
        f.make_cheap(c);
        assert_eq!((f.fmi2EnterInitializationMode)(c), OK);
        assert_eq!((f.fmi2GetReal)(c, &friction, 1, &raw mut values[0]), OK);
        (f.fmi2FreeInstance)(c);
        assert_eq!((f3.fmi3GetFloat64)(c3, &friction, 1, &raw mut values[1], 1), OK);
        (f3.fmi3FreeInstance)(c3);
    }
    assert_eq!(values, [0.085; 2]);
}
