//! A run of a case: means over milliseconds, fields along the belt, and a state from which it goes
//! on.

use crate::belt::add;
use crate::case::{Case, Path, SHIFT, short};
use crate::{Fault, Ledger, Machine, tone};
use pushbelt::variator::settings::ParameterError;
use pushbelt_archive::Archive;

/// Interval of the results, s.
const INTERVAL: f64 = 1.0e-3;
/// Steps between checks of the state and samples of fields and extremes.
const SAMPLE: u64 = 50;
/// Number of places of the fields.
const PLACES: usize = 72;
/// Number of fields at a place.
const FIELDS: usize = 8;
/// Columns of the fields' file. The spread is a standard deviation.
const FIELD_COLUMNS: &str = "position,pushForce,pushForce.spread,gap,gap.spread,ringTension,\
    ringTension.spread,ringContact,ringContact.spread,normalForce,normalForce.spread,\
    slidingSpeed,slidingSpeed.spread,ringSliding,ringSliding.spread,pitch,pitch.spread";
/// Steps between samples of the tone.
const TONE: u64 = 4;
/// Part of a run whose mean is its result.
const RESULT: f64 = 0.25;
/// Slip beyond which the belt slips through.
const THROUGH: f64 = 0.2;
/// Change of the thrust ratio, relative, or of the slip between the last two parts beyond which a
/// state is not steady.
const STEADY: [f64; 2] = [0.01, 2.0e-3];
/// Share of the difference of the strands' push forces by which an idle arc ends, as in the FMU.
const IDLE_CHANGE: f64 = 0.1;
/// Extremes of nothing.
const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Means over an interval of time. Pairs are in the order secondary, primary.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    /// The end of its interval, s.
    pub time: f64,
    /// Its duration, s.
    pub duration: f64,
    /// Axial forces, N, radii, m, speeds, rad/s, torques of the belt, N·m, and idle arcs, rad: from
    /// the entry on, up to where the push force of the interval has changed by 10 % of its
    /// difference between the strands from that of the strand before.
    pub means: [[f64; 2]; 5],
    /// Energies added to the ledger, J.
    pub ledger: Ledger,
    /// Change of the stored energy, J.
    pub stored: f64,
    /// Least and largest push force, N.
    pub push_force: [f64; 2],
    /// Number of open gaps.
    pub open: f64,
    /// Least and largest slip of the intervals.
    pub slips: [f64; 2],
}

/// Names of the columns before those of the [`Ledger`], of which W are given.
const COLUMNS: &str = "time,ratio,thrustRatio,slip,efficiency,secondary.axialForce,\
    primary.axialForce,secondary.radius,primary.radius,secondary.speed,primary.speed,\
    secondary.beltTorque,primary.beltTorque,pushForceMin,pushForceMax,openGaps,residual";
/// Those behind them.
const LAST: &str = "secondary.idleArc,primary.idleArc,slipMin,slipMax";

impl Row {
    /// r_S/r_P of the running mean radii.
    pub fn ratio(&self) -> f64 {
        self.means[1][0] / self.means[1][1]
    }

    /// Axial force of the belt, primary over secondary.
    pub fn thrust_ratio(&self) -> f64 {
        self.means[0][1] / self.means[0][0]
    }

    /// 1 − (ω_S/ω_P)(r_S/r_P), with the running mean radii.
    pub fn slip(&self) -> f64 {
        1.0 - self.means[2][0] / self.means[2][1] * self.ratio()
    }

    /// Power of the belt on the driven pulley over that of the driving one; 0 where little flows.
    pub fn efficiency(&self) -> f64 {
        let [s, p] = [0, 1].map(|j| self.means[3][j] * self.means[2][j]);
        let (from, to) = (-s.min(p), s.max(p));
        if from > 1.0 && to > 0.0 { to / from } else { 0.0 }
    }

    /// Work less losses less the change of the stored energy, over the energy that passes.
    pub fn residual(&self) -> f64 {
        let surplus = self.ledger.work() - self.ledger.losses() - self.stored;
        surplus / self.ledger.0[0].abs().max(self.ledger.0[1].abs())
    }

    /// The row of an interval that begins.
    fn empty() -> Self {
        let (push_force, slips) = (NONE, NONE);
        Self {
            push_force,
            slips,
            ..Self::default()
        }
    }

    /// The mean of rows.
    pub fn mean(rows: &[Self]) -> Self {
        let (count, mut mean) = (rows.len() as f64, Self::empty());
        for row in rows {
            mean.time = mean.time.max(row.time);
            mean.duration += row.duration;
            mean.stored += row.stored;
            mean.open += row.open / count;
            let means = row.means.as_flattened().iter().map(|value| value / count);
            add(mean.means.as_flattened_mut(), means);
            add(&mut mean.ledger.0, row.ledger.0);
            widen(&mut mean.push_force, row.push_force);
            widen(&mut mean.slips, row.slips);
        }
        mean
    }

    /// The columns of a file of rows.
    pub fn line(&self) -> String {
        let [means @ .., arcs] = &self.means;
        let mut values = vec![self.time, self.ratio(), self.thrust_ratio()];
        values.extend([self.slip(), self.efficiency()]);
        values.extend(means.as_flattened().iter().chain(&self.push_force));
        values.extend([self.open, self.residual()]);
        values.extend(self.ledger.0.map(|energy| energy / self.duration));
        values.extend(arcs.iter().chain(&self.slips));
        csv(&values)
    }
}

/// Extends limits to others.
fn widen(limits: &mut [f64; 2], [least, most]: [f64; 2]) {
    *limits = [limits[0].min(least), limits[1].max(most)];
}

/// Values of six digits with commas between.
pub fn csv(values: &[f64]) -> String {
    let words: Vec<_> = values.iter().map(|value| short(*value).to_string()).collect();
    words.join(",")
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
    /// The interval since the last row; of the means the integrals.
    now: Row,
    /// Ledger and stored energy at the last row.
    before: Ledger,
    energy: Option<f64>,
    /// Count, sums and sums of squares of the fields at each place.
    fields: [[f64; 1 + 2 * FIELDS]; PLACES],
    /// Count and sum of the push forces at each place since the last row.
    recent: [[f64; 2]; PLACES],
    /// Revolutions of the belt.
    revolutions: f64,
    /// Signals of the result, for its tone.
    pub tone: Vec<tone::Sample>,
}

impl Run {
    /// The start of a case.
    ///
    /// # Errors
    /// A value is out of its range.
    pub fn new(case: Case) -> Result<Self, ParameterError> {
        Ok(Self {
            machine: case.start()?,
            case,
            rows: Vec::new(),
            steps: 0,
            now: Row::empty(),
            before: Ledger::default(),
            energy: None,
            fields: [[0.0; 1 + 2 * FIELDS]; PLACES],
            recent: [[0.0; 2]; PLACES],
            revolutions: 0.0,
            tone: Vec::new(),
        })
    }

    /// Whether its time is over.
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
            let values = [
                loads.map(|load| load.axial),
                loads.map(|load| load.weight[1] / load.weight[0].max(f64::MIN_POSITIVE)),
                machine.pulleys.map(|pulley| pulley.omega),
                loads.map(|load| load.torque),
            ];
            let parts = values.as_flattened().iter().map(|value| value * machine.dt);
            add(self.now.means.as_flattened_mut(), parts);
            self.now.duration += machine.dt;
            if self.steps.is_multiple_of(SAMPLE) {
                self.sample()?;
            }
            self.listen();
            if self.machine.time >= (self.rows.len() + 1) as f64 * INTERVAL - 0.5 * self.machine.dt {
                self.close_row();
            }
        }
        Ok(())
    }

    /// Whether the run is in the part that is its result.
    fn is_result(&self) -> bool {
        self.machine.time >= (1.0 - RESULT) * self.case.duration()
    }

    /// Adds the signals of the tone.
    fn listen(&mut self) {
        if !self.case.options.tone || self.rows.is_empty() {
            return;
        }
        self.revolutions += tone::revolutions(&self.machine);
        if self.is_result() && self.steps.is_multiple_of(TONE) {
            let (machine, [s, p]) = (&self.machine, &self.machine.loads);
            let (flank, place) = (machine.flanks.of[1], self.path().place(machine.belt.p[1]));
            self.tone.push([
                self.revolutions,
                s.axial,
                p.axial,
                s.torque,
                p.torque,
                place,
                machine.belt.pitch[1],
                flank.normal,
                flank.sliding,
            ]);
        }
    }

    fn close_row(&mut self) {
        let (machine, mut row) = (&self.machine, std::mem::replace(&mut self.now, Row::empty()));
        let energy = machine.energy();
        row.ledger = Ledger(std::array::from_fn(|k| machine.ledger.0[k] - self.before.0[k]));
        // The first interval has no energy before it.
        let surplus = row.ledger.work() - row.ledger.losses();
        row.stored = self.energy.map_or(surplus, |before| energy - before);
        (row.time, self.before, self.energy) = (machine.time, machine.ledger, Some(energy));
        row.means = row.means.map(|pair| pair.map(|sum| sum / row.duration));
        row.slips = [row.slip(); 2];
        let wide = machine.law.thickness + machine.law.oil.floor.min(1.0e-6);
        let gaps = &machine.belt.length[1..=machine.law.count];
        row.open = gaps.iter().filter(|length| **length > wide).count() as f64;
        if self.recent.iter().all(|sum| sum[0] > 0.0) {
            row.means[4] = idle_arcs(&Path::new(machine.law.axes[1], row.means[1]), &self.recent);
        }
        self.rows.push(row);
        self.recent = [[0.0; 2]; PLACES];
    }

    /// Checks the state, and adds to extremes and, in the part that is the result, to the fields.
    fn sample(&mut self) -> Result<(), Fault> {
        let machine = &self.machine;
        machine.check()?;
        for push in &machine.stacks[0].push[1..=machine.law.count] {
            widen(&mut self.now.push_force, [*push; 2]);
        }
        if self.rows.is_empty() {
            return Ok(());
        }
        let is_result = self.is_result();
        let (path, belt) = (self.path(), &machine.belt);
        for i in 1..=machine.law.count {
            let xi = path.place(belt.p[i]);
            let place = (xi / path.length() * PLACES as f64).round() as usize % PLACES;
            let sum = &mut self.fields[place];
            let values: [f64; FIELDS] = [
                machine.stacks[0].push[i],
                (belt.length[i] - machine.law.thickness).max(0.0),
                machine.ring.tension[i],
                machine.ring.contact[i],
                machine.flanks.of[i].normal,
                machine.flanks.of[i].sliding,
                belt.w[i] - belt.v[i].re - machine.law.lever * belt.spin[i],
                belt.pitch[i],
            ];
            let recent = &mut self.recent[place];
            *recent = [recent[0] + 1.0, recent[1] + values[0]];
            sum[0] += f64::from(u8::from(is_result));
            for (k, value) in values.into_iter().enumerate().filter(|_| is_result) {
                sum[1 + 2 * k] += value;
                sum[2 + 2 * k] += value * value;
            }
        }
        Ok(())
    }

    /// The line on which elements are in the present interval of time, for their place along the
    /// belt.
    pub fn path(&self) -> Path {
        let radii = self.rows.last().map_or([f64::NAN; 2], |row| row.means[1]);
        Path::new(self.machine.law.axes[1], radii)
    }

    /// The mean of a quarter of the run, counted from the end: 1 is the result.
    pub fn quarter(&self, part: usize) -> Row {
        let count = ((self.rows.len() as f64 * RESULT).ceil() as usize).max(1);
        let end = self.rows.len().saturating_sub((part - 1) * count);
        Row::mean(&self.rows[end.saturating_sub(count)..end])
    }

    /// The run that goes on from the end of this one with a step of ln F_P.
    pub fn shifted(mut self, step: f64) -> Self {
        self.case.primary_force = Some(self.quarter(1).means[0][1] * step.exp());
        self
    }

    /// Mean of ds/dt over the second half of a shift, 1/s, s = r_P/r_S.
    pub fn shift_rate(&self) -> f64 {
        let (last, count) = (self.rows.len() - 1, (0.5 * SHIFT / INTERVAL).round());
        let rise = self.rows[last].ratio().recip() - self.rows[last - count as usize].ratio().recip();
        rise / (count * INTERVAL)
    }

    /// Whether the end is a steady state.
    ///
    /// # Errors
    /// The belt slips through, or thrust ratio or slip still change.
    pub fn check_steady(&self) -> Result<(), Fault> {
        if self.rows.len() < 8 {
            return Ok(());
        }
        let [now, before] = [1, 2].map(|part| self.quarter(part));
        let thrust = now.thrust_ratio() / before.thrust_ratio() - 1.0;
        let slip = now.slip() - before.slip();
        let cause = if now.slip().abs() > THROUGH {
            format!("the belt slips through, at {:.1} %", 100.0 * now.slip())
        } else if thrust.abs() > STEADY[0] || slip.abs() > STEADY[1] {
            let (thrust, slip) = (100.0 * thrust, 100.0 * slip);
            let quarter = "points in the last quarter";
            format!("the thrust ratio changes by {thrust:.2} % and the slip by {slip:.3} {quarter}")
        } else {
            return Ok(());
        };
        let of = &self.machine.flanks.of;
        let fastest = (1..of.len()).max_by(|i, k| of[*i].sliding.total_cmp(&of[*k].sliding));
        Err(Fault {
            element: fastest.unwrap_or(1),
            time: self.machine.time,
            cause: format!("no steady state: {cause}"),
        })
    }

    /// Fields along the belt, CSV: place, m, and of each field mean and standard deviation over the
    /// elements that passed.
    pub fn fields_csv(&self) -> String {
        let length = self.path().length();
        let lines = self.fields.iter().enumerate().map(|(k, sum)| {
            let mut values = vec![length * k as f64 / PLACES as f64];
            for pair in sum[1..].chunks(2) {
                let mean = pair[0] / sum[0];
                values.extend([mean, (pair[1] / sum[0] - mean * mean).max(0.0).sqrt()]);
            }
            csv(&values)
        });
        file(FIELD_COLUMNS, lines)
    }

    /// Names of the columns of [`line`](Self::line).
    pub fn header(&self) -> String {
        if self.case.options.tone {
            return tone::COLUMNS.to_owned();
        }
        columns()
    }

    /// The result, or its tone.
    pub fn line(&self) -> String {
        let result = self.quarter(1);
        if !self.case.options.tone {
            return result.line();
        }
        let state = [result.ratio(), result.thrust_ratio(), result.slip()];
        let [forces, _, speeds, torques, _] = result.means;
        let means = [forces, speeds, torques];
        let amplitudes = tone::amplitudes(&self.tone, self.machine.law.count);
        csv(&[&state[..], means.as_flattened(), &amplitudes].concat())
    }

    /// Signals of the result, CSV.
    pub fn tone_csv(&self) -> String {
        file(tone::SIGNALS, self.tone.iter().map(|sample| csv(sample)))
    }

    /// Rows so far, CSV.
    pub fn rows_csv(&self) -> String {
        file(&columns(), self.rows.iter().map(Row::line))
    }

    /// Writes the run to an archive, or reads it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.machine.serialize(archive);
        archive.counter(&mut self.steps);
        archive.option(&mut self.energy);
        archive.reals(&mut self.before.0);
        archive.reals(self.fields.as_flattened_mut());
        archive.reals(self.recent.as_flattened_mut());
        archive.real(&mut self.revolutions);
        let mut length = |now: usize, most: usize| {
            let mut count = now as u64;
            archive.counter(&mut count);
            most.min(count as usize)
        };
        // Not more than the duration has, and than the steps give.
        let rows = length(self.rows.len(), (self.case.duration() / INTERVAL) as usize + 1);
        self.rows.resize(rows, Row::default());
        self.tone
            .resize(length(self.tone.len(), self.steps as usize), Default::default());
        archive.reals(self.tone.as_flattened_mut());
        for row in self.rows.iter_mut().chain([&mut self.now]) {
            let numbers = [&mut row.time, &mut row.duration, &mut row.stored, &mut row.open];
            numbers.into_iter().for_each(|value| archive.real(value));
            archive.reals(row.means.as_flattened_mut());
            archive.reals(&mut row.ledger.0);
            // Of an interval that has just begun they are infinite.
            let limits = row.push_force.iter_mut().chain(&mut row.slips);
            limits.for_each(|value| archive.any_real(value));
        }
    }
}

/// Names of the columns of [`Row::line`].
fn columns() -> String {
    format!("{COLUMNS},{},{LAST}", Ledger::NAMES)
}

/// A file of lines under their names.
fn file(names: &str, lines: impl Iterator<Item = String>) -> String {
    [names.to_owned()]
        .into_iter()
        .chain(lines)
        .map(|line| line + "\n")
        .collect()
}

/// Those of the [`Row`], from count and sum of push forces at places along the path.
fn idle_arcs(path: &Path, pushes: &[[f64; 2]; PLACES]) -> [f64; 2] {
    let per_place = path.length() / PLACES as f64;
    let [s, p] = [0, 1].map(|j| path.wraps()[j] * path.radii[j]);
    let strand = path.length() - s - p;
    let push = |k: usize| pushes[k % PLACES][1] / pushes[k % PLACES][0];
    let mean = |from: f64, to: f64| {
        let places = (from / per_place).ceil() as usize..=(to / per_place) as usize;
        let count = places.clone().count() as f64;
        places.map(push).sum::<f64>() / count
    };
    let [entry_s, entry_p] = [0.5 * s + strand + p, 0.5 * (s + strand)];
    let (upper, lower) = (mean(0.5 * s, entry_p), mean(entry_p + p, entry_s));
    let limit = IDLE_CHANGE * (upper - lower).abs();
    let idle = |radius: f64, arc: f64, from: f64, entry: f64| {
        let first = (from / per_place).ceil();
        let change = |k: usize| (push(first as usize + k) - entry).abs();
        let mut places = 0..(arc / per_place) as usize;
        let Some(k) = places.find(|k| change(*k) > limit) else {
            return arc / radius;
        };
        let before = if k > 0 { change(k - 1) } else { 0.0 };
        let fraction = ((limit - before) / (change(k) - before)).clamp(0.0, 1.0);
        let place = (first + k as f64 - 1.0 + fraction) * per_place;
        ((place - from) / radius).max(0.0)
    };
    let [radius_s, radius_p] = path.radii;
    [idle(radius_s, s, entry_s, lower), idle(radius_p, p, entry_p, upper)]
}
