//! Inputs that wait in real time while a step stays open and the run is behind the clock: no impulse of them is lost.

use crate::archive::Archive;
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::run::tuning::REAL_TIME;
use crate::variator::settings::signals::Inputs;

const PENDING: usize = REAL_TIME.pending;

/// Inputs between two times, s.
#[derive(Clone, Copy, Debug)]
struct Piece {
    span: [f64; 2],
    profile: InputProfile,
}

impl Piece {
    /// Its part between two times, s; none if that is too short.
    fn part(&self, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let part = [self.span[0].max(from), self.span[1].min(to)];
        (part[1] - part[0] > SHORTEST_STEP).then_some(part)
    }
}

/// Inputs between the time of the state and that of the clock, the oldest first.
#[derive(Debug)]
pub(super) struct PendingInputs {
    pieces: Vec<Piece>,
}

impl Clone for PendingInputs {
    /// A copy has as much memory: it doesn't allocate in a step either.
    fn clone(&self) -> Self {
        let mut copy = Self::new();
        copy.pieces.extend_from_slice(&self.pieces);
        copy
    }
}

impl PendingInputs {
    pub fn new() -> Self {
        Self {
            pieces: Vec::with_capacity(PENDING),
        }
    }

    /// Adds the inputs of a profile between two times, s.
    pub fn add(&mut self, profile: &InputProfile, span: [f64; 2]) {
        if self.pieces.len() == PENDING {
            self.level(self.pieces[0].span[0]);
        }
        let profile = *profile;
        self.pieces.push(Piece { span, profile });
    }

    /// Forgets what lies before a time, s.
    pub fn forget(&mut self, before: f64) {
        self.pieces.retain(|piece| piece.span[1] > before + SHORTEST_STEP);
    }

    /// Replaces the inputs from a time on, s, by their mean.
    pub fn level(&mut self, from: f64) {
        let Some(last) = self.pieces.last() else { return };
        let span = [from, last.span[1]];
        if span[1] - span[0] > SHORTEST_STEP {
            let profile = InputProfile::constant(&self.mean(span));
            self.pieces.clear();
            self.pieces.push(Piece { span, profile });
        }
    }

    /// Mean of the inputs from one time to another, s.
    pub fn mean(&self, span: [f64; 2]) -> Inputs {
        let length = span[1] - span[0];
        let mut mean = Inputs::ZERO;
        for piece in &self.pieces {
            let Some([from, to]) = piece.part(span) else { continue };
            let kink = piece.profile.kink.clamp(from, to);
            for [from, to] in [[from, kink], [kink, to]] {
                mean = mean.after((to - from) / length, &piece.profile.at(0.5 * (from + to)));
            }
        }
        mean
    }

    /// The straight line from the inputs at one time to those at another, s, moved so that its mean is theirs.
    pub fn line(&self, span: [f64; 2]) -> InputProfile {
        let [from, to] = span;
        let length = to - from;
        let mean = self.mean(span);
        let mut within = self.pieces.iter().filter(|piece| piece.part(span).is_some());
        let Some(first) = within.next() else {
            return InputProfile::constant(&mean);
        };
        let last = within.next_back().unwrap_or(first);
        let rates = Inputs::blend([
            (1.0 / length, last.profile.at(to)),
            (-1.0 / length, first.profile.at(from)),
        ]);
        InputProfile {
            kink: from,
            inputs: mean.after(-0.5 * length, &rates),
            rates: [rates; 2],
        }
    }

    /// Writes to an archive, or reads from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let mut count = self.pieces.len() as u64;
        archive.counter(&mut count);
        if count > PENDING as u64 {
            archive.reject();
            return;
        }
        let none = Piece {
            span: [0.0; 2],
            profile: InputProfile::constant(&Inputs::ZERO),
        };
        self.pieces.resize(count as usize, none);
        for piece in &mut self.pieces {
            piece.span.iter_mut().for_each(|time| archive.real(time));
            piece.profile.serialize(archive);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variator::pulleys::loads::tests::torque;

    fn mean(pending: &PendingInputs, span: [f64; 2]) -> f64 {
        pending.mean(span).primary.torque
    }

    /// Torques at the start, in the middle and at the end of the line over a time.
    fn line(pending: &PendingInputs, [from, to]: [f64; 2]) -> [f64; 3] {
        let line = pending.line([from, to]);
        [from, 0.5 * (from + to), to].map(|time| line.at(time).primary.torque)
    }

    /// Inputs of 1 ms each: a ramp of 0.5 ms to a torque, N·m.
    fn pending(torques: &[f64]) -> PendingInputs {
        let mut pending = PendingInputs::new();
        let mut present = 0.0;
        for (k, &given) in torques.iter().enumerate() {
            let span = [k, k + 1].map(|k| 1e-3 * k as f64);
            let profile = InputProfile::new(0.5e-3, span, &torque(present), &torque(given), &Inputs::ZERO);
            pending.add(&profile, span);
            present = given;
        }
        pending
    }

    #[test]
    fn no_impulse_is_lost_until_the_run_has_caught_up() {
        let mut pending = pending(&[50.0, 50.0, -50.0]);
        let impulse = 37.5e-3 + 50e-3 - 25e-3;
        for (level_from, expected) in [(None, impulse), (Some(0.25e-3), impulse - 0.125e-3 * 25.0)] {
            if let Some(from) = level_from {
                pending.level(from);
            }
            let spans = [[0.0, 0.25e-3], [0.25e-3, 1.75e-3], [1.75e-3, 3e-3]];
            let found: f64 = spans
                .map(|span| (span[1] - span[0]) * line(&pending, span)[1])
                .iter()
                .sum();
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
        pending.forget(3e-3);
        assert!(pending.pieces.is_empty());
    }

    #[test]
    fn a_line_reaches_over_several_profiles() {
        let pending = pending(&[50.0, -30.0]);
        for (span, change) in [
            ([0.25e-3, 1e-3], 25.0),
            ([0.75e-3, 1.25e-3], -40.0),
            ([0.0, 2e-3], -30.0),
        ] {
            let [start, middle, end] = line(&pending, span);
            assert!((middle - mean(&pending, span)).abs() < 1e-9);
            assert!((end - start - change).abs() < 1e-9, "{span:?}: {start} to {end}");
        }
    }

    #[test]
    fn it_never_holds_more_than_there_is_memory_for() {
        let mut pending = pending(&[10.0; 100]);
        assert!(pending.pieces.len() <= PENDING && pending.pieces.capacity() == PENDING);
        assert_eq!(pending.clone().pieces.capacity(), PENDING);
        for _ in 0..2 {
            assert!((mean(&pending, [0.0, 0.1]) - (10.0 - 2.5e-3 / 0.1)).abs() < 1e-9);
            pending.level(0.0);
        }
        assert_eq!(pending.pieces.len(), 1);
    }

    #[test]
    fn more_segments_than_there_is_memory_for_are_not_read() {
        let bytes = [255; 8];
        let mut archive = Archive::reader(&bytes);
        PendingInputs::new().serialize(&mut archive);
        assert!(archive.finish().is_err());
    }
}
