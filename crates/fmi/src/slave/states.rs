//! Stored states of an instance.

use super::error::{CallError, Outcome};
use super::instance::Slave;
use crate::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::unit::Unit;

impl<U: Unit> Slave<U> {
    /// A copy of the state.
    pub fn save(&mut self) -> Result<Snapshot<U>, CallError> {
        self.allow(Call::Always)?;
        Ok(self.now.clone())
    }

    /// Goes back to a state, which may come from another instance. The stop time is the one of this instance.
    pub fn restore(&mut self, snapshot: &Snapshot<U>) -> Outcome {
        self.allow(Call::Always)?;
        let stop = self.now.experiment.stop;
        self.now = snapshot.clone();
        self.now.experiment.stop = stop;
        // The state may come from an instance whose master handles events.
        if self.now.state == State::Event && !self.master.events {
            self.now.state = State::StepComplete;
        }
        Ok(())
    }

    /// A state as bytes.
    pub fn serialize(&mut self, snapshot: &Snapshot<U>) -> Result<Vec<u8>, CallError> {
        self.allow(Call::Always)?;
        let sealed = snapshot.to_bytes(&self.table, self.guid());
        sealed.map_err(CallError::Refused)
    }

    /// The state in these bytes.
    pub fn deserialize(&mut self, sealed: &[u8]) -> Result<Snapshot<U>, CallError> {
        self.allow(Call::Always)?;
        let found = Snapshot::from_bytes(&self.table, self.guid(), sealed);
        found.map_err(CallError::Refused)
    }
}
