//! A run of a case: means over milliseconds, fields along the belt, and a state from which it goes on.

use crate::case::{Case, Path};
use crate::machine::{Fault, Ledger, Machine};
use pushbelt::variator::settings::ParameterError;
use pushbelt_archive::Archive;
use std::fmt::Write as _;

/// Interval of the results, s.
const INTERVAL: f64 = 1.0e-3;
/// Steps between checks of the state and samples of fields and extremes.
const SAMPLE: u64 = 50;
/// Number of places of the fields.
pub const PLACES: usize = 72;
/// Fields at a place.
const FIELDS: [&str; 7] = [
    "pushForce",
    "gap",
    "ringTension",
    "ringContact",
    "normalForce",
    "slidingSpeed",
    "ringSliding",
];
/// Part of a run whose mean is its result.
const RESULT: f64 = 0.25;
/// Slip beyond which the belt slips through.
const THROUGH: f64 = 0.2;
/// Change of the thrust ratio, relative, or of the slip between the last two parts beyond which a state is not steady.
const STEADY: [f64; 2] = [0.01, 2.0e-3];

/// Sums over the steps of an interval.
const SUMS: usize = 8;
/// Numbers of a row: time, duration, means, works and losses, change of the stored energy, extremes of the push force, open gaps.
const ROW: usize = 2 + SUMS + Ledger::NAMES.len() + 4;

/// Means over an interval of time.
#[derive(Clone, Copy, Debug)]
pub struct Row([f64; ROW]);

/// Names of the columns of results.
pub const COLUMNS: [&str; 17] = [
    "time",
    "ratio",
    "thrustRatio",
    "slip",
    "efficiency",
    "secondary.axialForce",
    "primary.axialForce",
    "secondary.radius",
    "primary.radius",
    "secondary.speed",
    "primary.speed",
    "secondary.beltTorque",
    "primary.beltTorque",
    "pushForceMin",
    "pushForceMax",
    "openGaps",
    "residual",
];

impl Row {
    /// The end of its interval, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0[0]
    }

    fn means(&self) -> &[f64] {
        &self.0[2..2 + SUMS]
    }

    /// Energies added to the ledger, J.
    fn ledger(&self) -> Ledger {
        Ledger(std::array::from_fn(|k| self.0[2 + SUMS + k]))
    }

    /// r_S/r_P of the running mean radii.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.means()[2] / self.means()[3]
    }

    /// Axial force of the belt, primary over secondary.
    #[must_use]
    pub fn thrust_ratio(&self) -> f64 {
        self.means()[1] / self.means()[0]
    }

    /// 1 − (ω_S/ω_P)(r_S/r_P), with the running mean radii.
    #[must_use]
    pub fn slip(&self) -> f64 {
        1.0 - self.means()[4] / self.means()[5] * self.ratio()
    }

    /// Power of the belt on the driven pulley over that of the driving one; 0 where little flows.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        let [s, p] = [0, 1].map(|j| self.means()[6 + j] * self.means()[4 + j]);
        let (from, to) = (-s.min(p), s.max(p));
        if from > 1.0 && to > 0.0 { to / from } else { 0.0 }
    }

    /// Power of a loss by its name, W.
    #[must_use]
    pub fn power(&self, name: &str) -> f64 {
        let place = Ledger::NAMES.iter().position(|other| *other == name);
        place.map_or(f64::NAN, |place| self.ledger().0[place] / self.0[1])
    }

    /// Least and largest push force, N.
    #[must_use]
    pub fn push_force(&self) -> [f64; 2] {
        [self.0[ROW - 3], self.0[ROW - 2]]
    }

    /// Work less losses less the change of the stored energy, over the power that passes.
    #[must_use]
    pub fn residual(&self) -> f64 {
        let ledger = self.ledger();
        let passing = ledger.0[0].abs().max(ledger.0[1].abs());
        (ledger.work() - ledger.losses() - self.0[ROW - 4]) / passing
    }

    /// The same over the losses.
    #[must_use]
    pub fn residual_of_losses(&self) -> f64 {
        let ledger = self.ledger();
        (ledger.work() - ledger.losses() - self.0[ROW - 4]) / ledger.losses()
    }

    /// The mean of rows.
    #[must_use]
    pub fn mean(rows: &[Self]) -> Self {
        let mut mean = [0.0; ROW];
        (mean[ROW - 3], mean[ROW - 2]) = (f64::INFINITY, f64::NEG_INFINITY);
        for Self(row) in rows {
            mean[0] = mean[0].max(row[0]);
            mean[1] += row[1];
            for k in (2..2 + SUMS).chain([ROW - 1]) {
                mean[k] += row[k] / rows.len() as f64;
            }
            for k in 2 + SUMS..ROW - 3 {
                mean[k] += row[k];
            }
            mean[ROW - 3] = mean[ROW - 3].min(row[ROW - 3]);
            mean[ROW - 2] = mean[ROW - 2].max(row[ROW - 2]);
        }
        Self(mean)
    }

    /// The columns of [`header`], W for works and losses.
    #[must_use]
    pub fn line(&self) -> String {
        let m = self.means();
        let values = [
            self.time(),
            self.ratio(),
            self.thrust_ratio(),
            self.slip(),
            self.efficiency(),
        ];
        let more = [self.0[ROW - 3], self.0[ROW - 2], self.0[ROW - 1], self.residual()];
        let powers = self.ledger().0.map(|energy| energy / self.0[1]);
        let mut line = String::new();
        let all = values.iter().chain(m).chain(&more).chain(&powers);
        for (k, value) in all.enumerate() {
            let comma = if k > 0 { "," } else { "" };
            // Writing to a string doesn't fail.
            let _ = write!(line, "{comma}{}", short(*value));
        }
        line
    }
}

/// Six digits.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 5 - value.abs().log10().floor() as i32;
    let digits = usize::try_from(digits.clamp(0, 12)).unwrap_or(0);
    let text = format!("{value:.digits$}");
    if digits == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Names of all columns.
#[must_use]
pub fn header() -> String {
    let all: Vec<_> = COLUMNS.iter().chain(&Ledger::NAMES).copied().collect();
    all.join(",")
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A value of the case.
    #[error(transparent)]
    Value(#[from] ParameterError),
    /// The state.
    #[error(transparent)]
    Fault(#[from] Fault),
}

/// A run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its case.
    pub case: Case,
    /// Its machine.
    pub machine: Machine,
    /// Rows so far.
    pub rows: Vec<Row>,
    /// Steps so far.
    pub steps: u64,
    sums: [f64; SUMS],
    count: f64,
    extremes: [f64; 2],
    before: Ledger,
    energy: f64,
    /// Count, sums and sums of squares of the fields at each place.
    fields: Vec<[f64; 1 + 2 * FIELDS.len()]>,
}

impl Run {
    /// The start of a case.
    ///
    /// # Errors
    /// A value is out of its range.
    pub fn new(case: Case) -> Result<Self, ParameterError> {
        let machine = case.start()?;
        Ok(Self {
            case,
            machine,
            rows: Vec::new(),
            steps: 0,
            sums: [0.0; SUMS],
            count: 0.0,
            extremes: [f64::MAX, f64::MIN],
            before: Ledger::default(),
            energy: f64::NAN,
            fields: vec![[0.0; 1 + 2 * FIELDS.len()]; PLACES],
        })
    }

    /// Whether its time is over.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.machine.time >= self.case.duration() - 0.5 * self.machine.dt
    }

    /// Advances by `steps`, or to its end.
    ///
    /// # Errors
    /// The state is not admissible; rows so far are kept.
    pub fn advance(&mut self, steps: u64) -> Result<(), Fault> {
        for _ in 0..steps {
            if self.is_done() {
                break;
            }
            let machine = &mut self.machine;
            self.case.drive(machine);
            machine.step();
            self.steps += 1;
            let loads = &machine.loads;
            let radius = |j: usize| loads[j].weight[1] / loads[j].weight[0].max(f64::MIN_POSITIVE);
            let [s, p] = machine.pulleys.map(|pulley| pulley.omega);
            let values = [
                loads[0].axial,
                loads[1].axial,
                radius(0),
                radius(1),
                s,
                p,
                loads[0].torque,
                loads[1].torque,
            ];
            for (sum, value) in self.sums.iter_mut().zip(values) {
                *sum += value;
            }
            self.count += 1.0;
            if self.steps.is_multiple_of(SAMPLE) {
                self.sample()?;
            }
            if self.machine.time >= (self.rows.len() + 1) as f64 * INTERVAL - 0.5 * self.machine.dt {
                self.close_row();
            }
        }
        Ok(())
    }

    fn close_row(&mut self) {
        let machine = &self.machine;
        let energy = machine.energies().iter().sum::<f64>();
        let ledger = machine.ledger.since(&self.before);
        let mut row = [0.0; ROW];
        row[0] = machine.time;
        row[1] = self.count * machine.dt;
        for (mean, sum) in row[2..].iter_mut().zip(self.sums) {
            *mean = sum / self.count;
        }
        row[2 + SUMS..ROW - 4].copy_from_slice(&ledger.0);
        let open = |length: &&f64| **length > machine.law.thickness + machine.law.oil.floor.min(1.0e-6);
        let gaps = &machine.chords.length[1..=machine.law.count];
        let rest = [
            energy - self.energy,
            self.extremes[0],
            self.extremes[1],
            gaps.iter().filter(open).count() as f64,
        ];
        row[ROW - 4..].copy_from_slice(&rest);
        // The first interval has no energy before it.
        if self.energy.is_nan() {
            row[ROW - 4] = ledger.work() - ledger.losses();
        }
        self.rows.push(Row(row));
        (self.before, self.energy) = (machine.ledger, energy);
        (self.sums, self.count, self.extremes) = ([0.0; SUMS], 0.0, [f64::MAX, f64::MIN]);
    }

    /// Checks the state, and adds to extremes and, in the part that is the result, to the fields.
    fn sample(&mut self) -> Result<(), Fault> {
        let machine = &self.machine;
        machine.check()?;
        for push in &machine.stack.push[1..=machine.law.count] {
            self.extremes = [self.extremes[0].min(*push), self.extremes[1].max(*push)];
        }
        if machine.time < (1.0 - RESULT) * self.case.duration() || self.rows.is_empty() {
            return Ok(());
        }
        let path = self.path();
        for i in 1..=machine.law.count {
            let xi = path.place([machine.x[i], machine.y[i]]);
            let place = (xi / path.length() * PLACES as f64).round() as usize % PLACES;
            let sum = &mut self.fields[place];
            let ring = &machine.ring;
            let omega = machine.frames.turn[i] / machine.dt;
            let values = [
                machine.stack.push[i],
                (machine.chords.length[i] - machine.law.thickness).max(0.0),
                ring.tension[i],
                ring.contact[i],
                machine.flanks.normal[i],
                machine.flanks.sliding[i],
                machine.w[i] - machine.v[i] - machine.law.ring.lever * omega,
            ];
            sum[0] += 1.0;
            for (k, value) in values.into_iter().enumerate() {
                sum[1 + 2 * k] += value;
                sum[2 + 2 * k] += value * value;
            }
        }
        Ok(())
    }

    /// The line on which elements are in the present interval of time, for their place along the belt.
    #[must_use]
    pub fn path(&self) -> Path {
        let last = self
            .rows
            .last()
            .map_or([f64::NAN; 2], |row| [row.means()[2], row.means()[3]]);
        Path::new(self.machine.law.axes[1], last)
    }

    /// The mean of the last part of the run.
    #[must_use]
    pub fn result(&self) -> Row {
        Row::mean(self.last(1))
    }

    /// The rows of a part, counted from the end, from 1 on.
    fn last(&self, part: usize) -> &[Row] {
        let count = ((self.rows.len() as f64 * RESULT).ceil() as usize).max(1);
        let end = self.rows.len().saturating_sub((part - 1) * count);
        &self.rows[end.saturating_sub(count)..end]
    }

    /// Whether the end is a steady state.
    ///
    /// # Errors
    /// The belt slips through, or thrust ratio or slip still change.
    pub fn check_steady(&self) -> Result<(), Fault> {
        if self.rows.len() < 8 {
            return Ok(());
        }
        let [now, before] = [1, 2].map(|part| Row::mean(self.last(part)));
        let thrust = now.thrust_ratio() / before.thrust_ratio() - 1.0;
        let slip = now.slip() - before.slip();
        let cause = if now.slip().abs() > THROUGH {
            format!(
                "no steady state: the belt slips through, at {:.1} %",
                100.0 * now.slip()
            )
        } else if thrust.abs() > STEADY[0] || slip.abs() > STEADY[1] {
            format!(
                "no steady state: the thrust ratio changes by {:.2} % and the slip by {:.3} points in the last quarter",
                100.0 * thrust,
                100.0 * slip
            )
        } else {
            return Ok(());
        };
        let fastest =
            |i: &usize, k: &usize| self.machine.flanks.sliding[*i].total_cmp(&self.machine.flanks.sliding[*k]);
        Err(Fault {
            element: (1..=self.machine.law.count).max_by(fastest).unwrap_or(1),
            time: self.machine.time,
            cause,
        })
    }

    /// Fields along the belt, CSV: place, m, and of each field mean and standard deviation over the elements that passed.
    #[must_use]
    pub fn fields_csv(&self) -> String {
        let mut text = "position".to_owned();
        for name in FIELDS {
            let _ = write!(text, ",{name},{name}.spread");
        }
        let length = self.path().length();
        for (k, sum) in self.fields.iter().enumerate() {
            let _ = write!(text, "\n{}", short(length * k as f64 / PLACES as f64));
            for field in 0..FIELDS.len() {
                let mean = sum[1 + 2 * field] / sum[0];
                let spread = (sum[2 + 2 * field] / sum[0] - mean * mean).max(0.0).sqrt();
                let _ = write!(text, ",{},{}", short(mean), short(spread));
            }
        }
        text.push('\n');
        text
    }

    /// The mean of a field at a place, by the field's name.
    #[must_use]
    pub fn field(&self, name: &str, place: usize) -> f64 {
        let field = FIELDS.iter().position(|other| *other == name);
        field.map_or(f64::NAN, |field| {
            self.fields[place][1 + 2 * field] / self.fields[place][0]
        })
    }

    /// The idle arcs of S and P, rad: from the entry on, up to where the push force has changed by 10 % of its difference between
    /// the strands from that of the strand before.
    #[must_use]
    pub fn idle_arcs(&self) -> [f64; 2] {
        let path = self.path();
        let per_place = path.length() / PLACES as f64;
        let (s, p) = (path.wraps()[0] * path.radii()[0], path.wraps()[1] * path.radii()[1]);
        let strand = path.length() - s - p;
        let push = |k: usize| self.field("pushForce", k % PLACES);
        let mean = |from: f64, to: f64| {
            let places = (from / per_place).ceil() as usize..=(to / per_place) as usize;
            let count = places.clone().count() as f64;
            places.map(push).sum::<f64>() / count
        };
        let upper = mean(0.5 * s, 0.5 * (s + strand));
        let lower = mean(0.5 * (s + strand) + p, 0.5 * s + strand + p);
        let limit = IDLE_CHANGE * (upper - lower).abs();
        [(0, lower, 0.5 * s + strand + p, s), (1, upper, 0.5 * (s + strand), p)].map(|(j, entry, from, arc)| {
            let first = (from / per_place).ceil();
            let mut before = 0.0;
            for k in 0..(arc / per_place) as usize {
                let change = (push(first as usize + k) - entry).abs();
                if change > limit {
                    let share = ((limit - before) / (change - before)).clamp(0.0, 1.0);
                    let place = (first + k as f64 - 1.0 + share) * per_place;
                    return ((place - from) / path.radii()[j]).max(0.0);
                }
                before = change;
            }
            path.wraps()[j]
        })
    }

    /// Rows so far, CSV.
    #[must_use]
    pub fn rows_csv(&self) -> String {
        let mut text = header();
        for row in &self.rows {
            text.push('\n');
            text.push_str(&row.line());
        }
        text.push('\n');
        text
    }

    /// Writes the run to an archive, or reads it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.machine.serialize(archive);
        archive.counter(&mut self.steps);
        archive.reals(&mut self.sums);
        for value in [&mut self.count, &mut self.energy] {
            archive.any_real(value);
        }
        archive.reals(&mut self.extremes);
        archive.reals(&mut self.before.0);
        for place in &mut self.fields {
            archive.reals(place);
        }
        let mut rows = self.rows.len() as u64;
        archive.counter(&mut rows);
        let rows = usize::try_from(rows).unwrap_or(0);
        if archive.is_reading() {
            self.rows.clear();
            // Not more than the duration has.
            let most = (self.case.duration() / INTERVAL) as usize + 1;
            self.rows.resize(rows.min(most), Row([0.0; ROW]));
        }
        for row in &mut self.rows {
            archive.reals(&mut row.0);
        }
    }
}

/// Share of the difference of the strands' push forces by which an idle arc ends, as in the FMU.
const IDLE_CHANGE: f64 = 0.1;
