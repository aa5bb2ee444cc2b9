//! Creation of an instance, its start values, its log.

use std::ffi::{CStr, CString};
use std::fs;
use std::path::PathBuf;

use pushbelt_fmi::Version::{self, Three, Two};
use pushbelt_fmi::log::Status::{Discard, Error, Ok};
use pushbelt_fmi::start_file::FILE;

use crate::importer::{Arguments, BOTH, Message, experiment, token};
use crate::tank::*;

fn assert_refused(version: Version, arguments: &Arguments<'_>, why: &str) {
    let importer = Importer::with(version, arguments);
    assert!(importer.c.is_null(), "{why}");
    importer.assert_logged(why);
    importer.assert_logged(match version {
        Two => "fmi2Instantiate: ",
        Three => "fmi3InstantiateCoSimulation: ",
    });
}

#[test]
fn an_instance_needs_a_name_the_right_token_and_kind() {
    let name = Some(c"tank");
    for version in BOTH {
        let right = token::<Tank>(version);
        for (name, token, why) in [
            (None, Some(&*right), "the instance name is missing"),
            (Some(c""), Some(&right), "the instance name is missing"),
            (name, None, " is missing"),
            (name, Some(c"{0}"), " {0} is not that of this binary"),
            // What is not UTF-8 in a text is replaced.
            (name, Some(c"a\xffb"), "a\u{fffd}b is not that"),
        ] {
            assert_refused(version, &Arguments::new([name, token, None]), why);
        }
        let importer = Importer::with(version, &Arguments::new([name, Some(&right), None]));
        assert!(!importer.c.is_null() && importer.last().is_empty());
    }
    let [two, three] = BOTH.map(token::<Tank>);
    let mut exchange = Arguments::new([name, Some(&two), None]);
    exchange.kind = 0;
    assert_refused(Two, &exchange, "for co-simulation only");
    let mut of_three = Arguments::new([name, Some(&three), None]);
    of_three.handles.required = &[LEVEL, NONE];
    assert_refused(Three, &of_three, "no variable has the value reference 99");
    let blank = Arguments::new([Some(c" "), Some(&three), None]);
    assert_refused(Three, &blank, "the instance name is missing");
}

/// A text is copied only up to a length, so a host's mistake takes no memory.
#[test]
fn a_text_without_end_is_refused() {
    let long = CString::new("x".repeat((1 << 20) + 1)).expect("no zero inside");
    let longest = CStr::from_bytes_with_nul(&long.as_bytes_with_nul()[1..]).expect("a zero at the end");
    for version in BOTH {
        let right = token::<Tank>(version);
        for which in 0..3 {
            let mut texts = [Some(c"instance"), Some(&right), None];
            texts[which] = Some(&long);
            assert_refused(version, &Arguments::new(texts), "a text has more than 1048576 bytes");
        }
        let importer = Importer::with(version, &Arguments::new([Some(longest), Some(&right), None]));
        assert!(!importer.c.is_null(), "{}", importer.last());
        importer.assert(importer.log(true, &[&long]), Error, "1048576 bytes");
        importer.assert(importer.log(true, &[c"logEvents", longest]), Error, "no log category");
        importer.start();
    }
}

/// A folder of resources, removed at the end.
struct Resources(PathBuf);

impl Resources {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pushbelt-fmi {name} {}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        Self(folder)
    }

    /// An instance with this token in which the resources are a URI in FMI 2.0 and a path in FMI
    /// 3.0.
    fn instance(&self, version: Version, token: &CStr) -> Importer {
        let path = self.0.to_str().expect("UTF-8");
        let location = match version {
            Two => format!("file://{}", path.replace(' ', "%20")),
            Three => path.to_owned(),
        };
        let location = CString::new(location).expect("no zero inside");
        Importer::with(
            version,
            &Arguments::new([Some(c"instance"), Some(token), Some(&location)]),
        )
    }

    fn write(&self, content: impl AsRef<[u8]>) {
        fs::write(self.0.join(FILE), content).expect("a file");
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn start_values_come_from_the_resources() {
    let resources = Resources::new("good");
    resources.write("\u{feff}# a comment\r\nstart = 3\nfloors=4\nlocked = true\n\n  shape = 2\ngain = 2e0");
    // In FMI 2.0 the URI may also mean a folder with percent signs, which comes second.
    let second = resources.0.to_str().expect("UTF-8").replace(' ', "%20");
    let second = Resources(second.into());
    fs::create_dir_all(&second.0).expect("a folder");
    second.write("start = 9");
    for version in BOTH {
        let importer = resources.instance(version, &token::<Tank>(version));
        assert!(!importer.c.is_null(), "{}", importer.last());
        assert_eq!(importer.set(GAIN, 4.0), Ok);
        for gain in [4.0, 2.0] {
            assert_eq!(importer.enter(experiment(0.0, None)), Ok);
            assert_eq!(importer.reals(&[LEVEL, GAIN], 2), Result::Ok(vec![3.0, gain]), "{gain}");
            let numbers = [FLOORS, SHAPE, LOCKED].map(|of| importer.number(of));
            assert_eq!(numbers, [4, 2, 1].map(Result::Ok));
            assert_eq!(importer.reset(), Ok, "and again after a reset");
        }
    }
}

#[test]
fn an_unusable_file_is_an_error_that_names_it() {
    let resources = Resources::new("bad");
    let token = token::<Tank>(Two);
    let large = [b'#'; (1 << 20) + 1];
    for (content, why) in [
        (&b"start"[..], "line 1: \"start\" is not of the form name = value"),
        (b"start = 1\nstart = 1", "line 2: start is set twice"),
        (b"level = 1", "level is calculated"),
        (b"\nsleep = 1", "line 2: there is no variable \"sleep\""),
        (b"old = 1", "old (value reference 98) was removed: use start"),
        (b"start = x", "start = \"x\" is not a number"),
        (b"start = -2000", "start = -2000 is out of range: at least -1000"),
        (b"floors = 1.5", "floors = \"1.5\" is not a whole number"),
        (b"locked = 1", "locked = \"1\" is not a truth value"),
        (b"\xff\xfe", "not text in UTF-8"),
        (&large, "more than 1048576 bytes"),
    ] {
        resources.write(content);
        let importer = resources.instance(Two, &token);
        assert!(importer.c.is_null(), "{why}");
        importer.assert_logged(why);
        importer.assert_logged(FILE);
    }
    resources.write(&large[1..]);
    assert!(!resources.instance(Two, &token).c.is_null(), "the largest file");
    fs::remove_file(resources.0.join(FILE)).expect("there");
    let importer = resources.instance(Two, &token);
    assert!(!importer.c.is_null(), "without the file the defaults hold");
    fs::create_dir(resources.0.join(FILE)).expect("a folder");
    let importer = resources.instance(Two, &token);
    assert!(importer.c.is_null());
    importer.assert_logged("not a file");
}

#[test]
fn data_come_from_the_first_folder_that_has_them() {
    let token = token::<Tank>(Two);
    let at = |location| Arguments::new([Some(c"instance"), Some(&*token), Some(location)]);
    assert_refused(Two, &at(c"file:///a/none"), "there are no data");
    // It may be percent-encoded or not.
    assert!(!Importer::with(Two, &at(c"file:///a/non%65")).c.is_null());
}

#[test]
fn a_copy_with_start_values_needs_its_file() {
    for version in BOTH {
        let token = token::<Tank>(version).into_string().expect("UTF-8");
        let text = |text: String| CString::new(text).expect("no zero inside");
        let copy = text(format!("{}0123-0123456789ab}}", &token[..20]));
        let resources = Resources::new("copy");
        resources.write("start = 3");
        let importer = resources.instance(version, &copy);
        assert!(!importer.c.is_null(), "{}", importer.last());
        importer.start();
        assert_eq!(importer.real(LEVEL), 3.0);
        let changed = if token.starts_with("{0") { '1' } else { '0' };
        let other = text(format!("{{{changed}{}", &token[2..]));
        assert!(resources.instance(version, &other).c.is_null());
        fs::remove_file(resources.0.join(FILE)).expect("there");
        let importer = resources.instance(version, &copy);
        assert!(importer.c.is_null());
        importer.assert_logged(resources.0.to_str().expect("UTF-8"));
        let long = text(format!("file:///tmp/{}", "x".repeat(5000)));
        for (location, why) in [(c"", ""), (c"http://a/b", "is not a file: URI"), (&long, "")] {
            let mut arguments = Arguments::new([Some(c"instance"), Some(&copy), Some(location)]);
            assert_refused(version, &arguments, "this copy of the FMU has start values of its own");
            let original = text(token.clone());
            (arguments.texts[1], arguments.debug) = (Some(&*original), true);
            let importer = Importer::with(version, &arguments);
            assert!(!importer.c.is_null(), "a location that cannot be searched is skipped");
            importer.assert_logged(why);
        }
    }
}

#[test]
fn all_but_events_is_logged_without_a_request() {
    for version in BOTH {
        let arguments = [Some(c"instance"), Some(&*token::<Tank>(version)), None];
        let importer = Importer::with(version, &Arguments::new(arguments));
        let taken = || std::mem::take(&mut *importer.record.messages.borrow_mut());
        assert_eq!(importer.set(START, 6.0), Ok);
        importer.start();
        let warning = Message {
            status: 1,
            category: "logStatusWarning".into(),
            text: "filled to 100%s 6".into(),
        };
        assert_eq!(taken(), [warning]);
        assert_eq!(importer.set(GAIN, 99.0), Discard);
        assert_eq!(taken().len(), 1);
        importer.assert(importer.step(9.0, 1.0).status, Error, "DoStep: the step starts at 9 s");
        let errors = taken();
        assert_eq!(
            (errors.len(), errors[0].status, &*errors[0].category),
            (1, 3, "logStatusError")
        );
        for (categories, events) in [
            (&[][..], true),
            (&[c"logEvents"], true),
            (&[c"logStatusError", c"logAll"], true),
            (&[c"logStatusDiscard"], false),
        ] {
            assert_eq!(importer.reset(), Ok);
            assert_eq!(importer.log(true, categories), Ok);
            importer.start();
            assert_eq!(taken().len(), usize::from(events), "{categories:?}");
            assert_eq!(importer.exit(), Error);
            assert_eq!(taken().len(), 1, "errors in any case");
        }
        assert_eq!(importer.log(true, &[]), Ok);
        assert_eq!(importer.reset(), Ok);
        importer.start();
        assert_eq!(taken(), [], "logged is what was at the creation");
        assert_eq!(importer.log(false, &[]), Ok);
        assert_eq!(importer.log(true, &[c"noise #1"]), Error);
        importer.assert_logged(if version == Two { "noise #1" } else { "noise ##1" });
        assert!(version == Three || *importer.record.instance.borrow() == "instance");
    }
}
