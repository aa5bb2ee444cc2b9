//! Questions to the unit beyond the standard, answered as text.

use super::instance::Slave;
use super::outcome::{Trouble, refused};
use crate::log::Status;
use crate::state::{Call, State};
use crate::unit::{Remark, Unit};

impl<U: Unit> Slave<U> {
    /// Asks the unit as it stands, from initialisation mode on; the unit stays as it is. What it remarks is logged, and a
    /// warning among that makes the status a warning. The answer, or `None` with the status if there is none.
    pub fn ask(
        &mut self,
        function: &'static str,
        question: impl FnOnce(&mut U, &U::Settings, &mut Vec<Remark>) -> Result<String, String>,
    ) -> (Status, Option<String>) {
        let (mut answer, mut warned) = (None, false);
        let status = self.call(function, |slave| {
            slave.allow(Call::Get)?;
            if slave.now.state == State::Initialisation {
                slave.start_unit()?;
            }
            let mut remarks = Vec::new();
            let found = match &mut slave.now.unit {
                Some(unit) => question(unit, &slave.now.settings, &mut remarks),
                None => return refused("there is no model to ask after a failed start"),
            };
            slave.log_remarks(&remarks);
            warned = remarks.iter().any(|remark| remark.warning);
            answer = Some(found.map_err(Trouble::Refused)?);
            Ok(())
        });
        match status {
            Status::Ok if warned => (Status::Warning, answer),
            _ => (status, answer),
        }
    }
}
