//! A row of values that is written once and read back in the same order.
//!
//! A structure that is stored writes its values to an [`Archive`] or reads them from one, by one
//! function for both directions. Numbers keep their bits. A structure is built before its values
//! are read, so an archive that does not fit is rejected.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

/// A row of values, being written or read.
#[derive(Debug)]
pub struct Archive<'a>(Mode<'a>);

#[derive(Debug)]
enum Mode<'a> {
    Write(Vec<u8>),
    /// What is left; `None` once something did not fit.
    Read(Option<&'a [u8]>),
}

/// The bytes don't hold what is read from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the bytes don't fit what is read from them")]
pub struct Mismatch;

impl<'a> Archive<'a> {
    /// An empty archive to write to.
    #[must_use]
    pub fn writer() -> Self {
        Self(Mode::Write(Vec::new()))
    }

    /// An empty archive in the memory of an earlier one.
    #[must_use]
    pub fn writer_in(mut memory: Vec<u8>) -> Self {
        memory.clear();
        Self(Mode::Write(memory))
    }

    /// An archive to read from.
    #[must_use]
    pub fn reader(bytes: &'a [u8]) -> Self {
        Self(Mode::Read(Some(bytes)))
    }

    /// Whether values are read.
    #[must_use]
    pub fn is_reading(&self) -> bool {
        matches!(self.0, Mode::Read(_))
    }

    /// What has been written; empty if the archive was read, or if there was no memory for it.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        match self.0 {
            Mode::Write(bytes) => bytes,
            Mode::Read(_) => Vec::new(),
        }
    }

    /// Ends reading.
    ///
    /// # Errors
    /// Something did not fit, or bytes are left over.
    pub fn finish(self) -> Result<(), Mismatch> {
        match self.0 {
            Mode::Write(_) | Mode::Read(Some(&[])) => Ok(()),
            Mode::Read(_) => Err(Mismatch),
        }
    }

    /// Marks what was read as unfit; values read from now on stay what they are.
    pub fn reject(&mut self) {
        if let Mode::Read(rest) = &mut self.0 {
            *rest = None;
        }
    }

    /// Writes `value`, or reads as many bytes; `value` itself if there are too few.
    fn word<const N: usize>(&mut self, value: [u8; N]) -> [u8; N] {
        match &mut self.0 {
            Mode::Write(bytes) => match bytes.try_reserve(N) {
                Ok(()) => bytes.extend_from_slice(&value),
                Err(_) => self.0 = Mode::Read(None),
            },
            Mode::Read(rest) => {
                if let Some((word, after)) = rest.and_then(|bytes| bytes.split_first_chunk::<N>()) {
                    *rest = Some(after);
                    return *word;
                }
                *rest = None;
            }
        }
        value
    }

    /// A real number. One that is read and not finite is rejected.
    pub fn real(&mut self, value: &mut f64) {
        self.bounded_real(value, f64::MIN, f64::MAX);
    }

    /// Any real number: a marker, or one that is not in use.
    pub fn any_real(&mut self, value: &mut f64) {
        *value = f64::from_le_bytes(self.word(value.to_le_bytes()));
    }

    /// A real number between limits, which may be infinite. One that is read and not between them
    /// is rejected.
    pub fn bounded_real(&mut self, value: &mut f64, min: f64, max: f64) {
        let found = f64::from_le_bytes(self.word(value.to_le_bytes()));
        if (min..=max).contains(&found) {
            *value = found;
        } else {
            self.reject();
        }
    }

    /// Real numbers, as many as there are.
    pub fn reals(&mut self, values: &mut [f64]) {
        self.length(values.len());
        if let Mode::Write(bytes) = &mut self.0
            && bytes.try_reserve(8 * values.len()).is_ok()
        {
            // All at once: a run stores its state at each communication step.
            let end = bytes.len();
            bytes.resize(end + 8 * values.len(), 0);
            let (words, _) = bytes[end..].as_chunks_mut::<8>();
            words
                .iter_mut()
                .zip(values)
                .for_each(|(word, value)| *word = value.to_le_bytes());
            return;
        }
        for value in values {
            self.real(value);
        }
    }

    /// A counter. One beyond 2⁵³, which no run reaches, is rejected: sums of counters don't
    /// overflow.
    pub fn counter(&mut self, value: &mut u64) {
        let found = u64::from_le_bytes(self.word(value.to_le_bytes()));
        if found <= 1 << 53 {
            *value = found;
        } else {
            self.reject();
        }
    }

    /// An integer.
    pub fn integer(&mut self, value: &mut i32) {
        *value = i32::from_le_bytes(self.word(value.to_le_bytes()));
    }

    /// A truth value.
    pub fn flag(&mut self, value: &mut bool) {
        match self.word([u8::from(*value)]) {
            [0] => *value = false,
            [1] => *value = true,
            _ => self.reject(),
        }
    }

    /// A real number that may be missing.
    pub fn option(&mut self, value: &mut Option<f64>) {
        let (mut present, mut number) = (value.is_some(), value.unwrap_or_default());
        self.flag(&mut present);
        self.real(&mut number);
        *value = present.then_some(number);
    }

    /// Indices below `end`, as many as there are.
    pub fn indices(&mut self, values: &mut [usize], end: usize) {
        self.length(values.len());
        for value in values {
            let mut index = *value as u64;
            self.counter(&mut index);
            match usize::try_from(index) {
                Ok(index) if index < end => *value = index,
                _ => self.reject(),
            }
        }
    }

    /// The length of a slice, which a reading archive must repeat.
    fn length(&mut self, length: usize) {
        let mut found = length as u64;
        self.counter(&mut found);
        if found != length as u64 {
            self.reject();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Archive, Mismatch};

    #[derive(Debug, Default, PartialEq)]
    struct Thing {
        numbers: [f64; 3],
        order: [usize; 2],
        flag: bool,
        option: Option<f64>,
    }

    impl Thing {
        fn serialize(&mut self, archive: &mut Archive<'_>) {
            archive.reals(&mut self.numbers);
            archive.indices(&mut self.order, 3);
            archive.flag(&mut self.flag);
            archive.option(&mut self.option);
        }
    }

    fn thing() -> Thing {
        Thing {
            numbers: [-0.0, f64::MIN_POSITIVE / 2.0, 1.0 / 3.0],
            order: [2, 0],
            flag: true,
            option: Some(-1.0),
        }
    }

    fn bytes() -> Vec<u8> {
        let mut archive = Archive::writer();
        thing().serialize(&mut archive);
        archive.into_bytes()
    }

    fn read(bytes: &[u8], into: &mut Thing) -> Result<(), Mismatch> {
        let mut archive = Archive::reader(bytes);
        into.serialize(&mut archive);
        archive.finish()
    }

    #[test]
    fn what_was_written_is_read() {
        let mut found = Thing::default();
        assert_eq!(read(&bytes(), &mut found), Ok(()));
        assert_eq!(found, thing());
        assert!(found.numbers[0].is_sign_negative());
    }

    #[test]
    fn a_number_that_is_not_finite_or_beyond_its_limits_is_rejected() {
        let read = |number: f64, limits: Option<[f64; 2]>| {
            let bytes = number.to_le_bytes();
            let mut archive = Archive::reader(&bytes);
            let mut found = 7.0;
            match limits {
                None => archive.real(&mut found),
                Some([min, max]) => archive.bounded_real(&mut found, min, max),
            }
            archive.finish().map(|()| found)
        };
        assert_eq!(read(f64::MAX, None), Ok(f64::MAX));
        for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(read(wild, None), Err(Mismatch), "{wild}");
        }
        let limits = Some([f64::NEG_INFINITY, 1.0]);
        assert_eq!(read(f64::NEG_INFINITY, limits), Ok(f64::NEG_INFINITY));
        assert_eq!(read(1.5, limits), Err(Mismatch));
        assert_eq!(read(f64::NAN, limits), Err(Mismatch));
    }

    #[test]
    fn a_byte_that_is_no_truth_value_is_rejected() {
        let mut archive = Archive::reader(&[2]);
        archive.flag(&mut true);
        assert_eq!(archive.finish(), Err(Mismatch));
    }

    #[test]
    fn any_real_keeps_its_bits_and_memory_is_used_again() {
        let marker = f64::from_bits(0x7ff8_0000_0000_0123);
        let mut archive = Archive::writer_in(vec![7; 100]);
        archive.any_real(&mut { marker });
        let (bytes, mut found) = (archive.into_bytes(), 0.0);
        assert_eq!((bytes.len(), bytes.capacity()), (8, 100));
        let mut archive = Archive::reader(&bytes);
        archive.any_real(&mut found);
        assert_eq!((found.to_bits(), archive.finish()), (marker.to_bits(), Ok(())));
    }

    #[test]
    fn a_counter_that_no_run_reaches_is_rejected() {
        for (count, expected) in [
            (1 << 53, Ok(())),
            ((1 << 53) + 1, Err(Mismatch)),
            (u64::MAX, Err(Mismatch)),
        ] {
            let bytes = count.to_le_bytes();
            let mut archive = Archive::reader(&bytes);
            let mut found = 7;
            archive.counter(&mut found);
            assert_eq!(found, if expected.is_ok() { count } else { 7 });
            assert_eq!(archive.finish(), expected);
        }
    }

    #[test]
    fn what_does_not_fit_is_found_out() {
        let bytes = bytes();
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end], &mut Thing::default()), Err(Mismatch), "{end} bytes");
        }
        assert_eq!(read(&[&bytes[..], &[0]].concat(), &mut Thing::default()), Err(Mismatch));
        let mut longer = Archive::reader(&bytes);
        longer.reals(&mut [0.0; 4]);
        assert_eq!(longer.finish(), Err(Mismatch));
        let mut three = Archive::writer();
        three.reals(&mut [0.0; 3]);
        let three = three.into_bytes();
        let mut shorter = Archive::reader(&three);
        shorter.reals(&mut [0.0; 2]);
        shorter.real(&mut 0.0);
        assert_eq!(shorter.finish(), Err(Mismatch));
        let mut out_of_range = thing();
        out_of_range.order[0] = 3;
        let mut archive = Archive::writer();
        out_of_range.serialize(&mut archive);
        assert_eq!(read(&archive.into_bytes(), &mut Thing::default()), Err(Mismatch));
    }
}
