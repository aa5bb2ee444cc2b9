//! `--report`: a page that plays a case.

use pushbelt_elements::{Fault, Ledger, Run};

const PAGE: &str = include_str!("../page/case.html");
const STYLE: &str = include_str!("../../python/pushbelt/report/style.css");
/// Frames of the page, and revolutions of the belt that they show.
const FRAMES: usize = 120;
const REVOLUTIONS: f64 = 2.0;
/// Names and units of the numbers of each element, which are whole.
const FIELDS: [(&str, f64); 4] = [("x", 1.0e-5), ("y", 1.0e-5), ("push", 1.0), ("gap", 1.0e-7)];

/// The page of two revolutions after the end of a run, with the run's `figures`.
///
/// # Errors
/// The state is no longer admissible.
pub fn page(mut run: Run, figures: &str) -> Result<String, Fault> {
    let (result, machine) = (run.quarter(1), &mut run.machine);
    let powers = Ledger::NAMES
        .split(',')
        .zip(result.ledger.0.map(|energy| energy / result.duration));
    let losses = powers.map(|(name, power)| format!("<tr><td>{}</td><td>{power:.1}</td></tr>", name.trim()));
    let (n, law) = (machine.law.count, machine.law.clone());
    let time = REVOLUTIONS * law.parameters.geometry.belt_length / machine.belt.v[1].re;
    let steps = (time / FRAMES as f64 / machine.dt).ceil() as usize;
    let mut fields = FIELDS.map(|_| Vec::with_capacity(FRAMES * n));
    for _ in 0..FRAMES {
        for _ in 0..steps {
            run.case.drive(machine);
            machine.step();
        }
        machine.check()?;
        for i in 1..=n {
            let (p, gap) = (machine.belt.p[i], machine.belt.length[i] - law.thickness);
            let values = [p.re, p.im, machine.stacks[0].push[i], gap.max(0.0)];
            for ((field, value), (_, unit)) in fields.iter_mut().zip(values).zip(FIELDS) {
                field.push((value / unit).round() as i32);
            }
        }
    }
    let fields = fields.iter().zip(FIELDS);
    let fields = fields.map(|(field, (name, unit))| format!("{name}: {{unit: {unit:e}, of: {field:?}}}, "));
    let (thickness, distance) = (law.thickness, law.axes[1]);
    let (pitch, step) = (law.parameters.belt.pitch_offset, steps as f64 * machine.dt);
    let [_, radii, speeds, ..] = result.means;
    let data = fields.collect::<String>()
        + &format!("count: {n}, thickness: {thickness}, pitch: {pitch}, distance: {distance}, ")
        + &format!("step: {step}, radii: {radii:?}, speeds: {speeds:?}");
    let losses = losses.collect::<String>();
    let parts = [("style", STYLE), ("case", &run.case.name), ("losses", &losses)];
    let parts = parts.into_iter().chain([("figures", figures), ("data", &data)]);
    Ok(parts.fold(PAGE.to_owned(), |page, (name, text)| {
        page.replace(&format!("{{{{{name}}}}}"), text)
    }))
}
