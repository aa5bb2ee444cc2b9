//! Stored states of an instance.

use super::instance::{Slave, Version};
use super::outcome::Trouble;
use crate::log::Status;
use crate::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::unit::Unit;

impl<U: Unit> Slave<U> {
    /// `fmi2GetFMUstate`: the state, or `None` with the status if the call failed.
    pub fn save(&mut self) -> (Status, Option<Snapshot<U>>) {
        let mut saved = None;
        let status = self.call("fmi2GetFMUstate", |slave| {
            slave.allow(Call::Always)?;
            saved = Some(slave.now.clone());
            Ok(())
        });
        (status, saved)
    }

    /// `fmi2SetFMUstate`. The state may come from another instance.
    pub fn restore(&mut self, snapshot: &Snapshot<U>) -> Status {
        self.call("fmi2SetFMUstate", |slave| {
            slave.allow(Call::Always)?;
            slave.now = snapshot.clone();
            // The state may come from an instance whose master handles events.
            if slave.now.state == State::Event && slave.version != (Version::Three { events: true }) {
                slave.now.state = State::StepComplete;
            }
            Ok(())
        })
    }

    /// `fmi2SerializeFMUstate`, and `fmi2SerializedFMUstateSize` by the length of what comes: the bytes, or `None` with
    /// the status if the call failed.
    pub fn serialize(&mut self, function: &'static str, snapshot: &Snapshot<U>) -> (Status, Option<Vec<u8>>) {
        let mut sealed = None;
        let status = self.call(function, |slave| {
            slave.allow(Call::Always)?;
            sealed = Some(
                snapshot
                    .to_bytes(&slave.table, slave.guid())
                    .map_err(Trouble::Refused)?,
            );
            Ok(())
        });
        (status, sealed)
    }

    /// `fmi2DeSerializeFMUstate`: the state, or `None` with the status if the bytes are not one.
    pub fn deserialize(&mut self, sealed: &[u8]) -> (Status, Option<Snapshot<U>>) {
        let mut found = None;
        let status = self.call("fmi2DeSerializeFMUstate", |slave| {
            slave.allow(Call::Always)?;
            found = Some(Snapshot::from_bytes(&slave.table, slave.guid(), sealed).map_err(Trouble::Refused)?);
            Ok(())
        });
        (status, found)
    }
}
