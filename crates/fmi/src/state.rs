//! The state machine of a co-simulation instance: which call is allowed when (table 4.2.4 of FMI
//! 2.0, sections 2.3 and 4.2 of FMI 3.0). The step mode of FMI 3.0 is [`State::StepComplete`] and,
//! after a discarded step, [`State::StepFailed`].

/// States of an instance. The states "step in progress" and "step cancelled" never occur; neither
/// does "fatal", since an error in one instance does not affect others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Instantiated: set-up and start values.
    Instantiated,
    /// Initialisation mode: inputs and start values are set, outputs are read.
    Initialisation,
    /// Step complete: ready for the next step.
    StepComplete,
    /// The last step was discarded.
    StepFailed,
    /// Terminated: last values can be read.
    Terminated,
    /// A call failed: only reset, a stored state or the end of the instance lead out of this state.
    Error,
    /// Event mode, of FMI 3.0 only: the importer handles an event at this time.
    Event,
    /// Intermediate update mode, of FMI 3.0 only: within `fmi3DoStep`, until the importer's
    /// callback returns.
    IntermediateUpdate,
}

impl State {
    /// The states that can be stored, in the order of their numbers there.
    pub const STORED: [Self; 7] = [
        Self::Instantiated,
        Self::Initialisation,
        Self::StepComplete,
        Self::StepFailed,
        Self::Terminated,
        Self::Error,
        Self::Event,
    ];

    /// Name for messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated",
            Self::Initialisation => "in initialization mode",
            Self::StepComplete => "in step mode",
            Self::StepFailed => "after a discarded step",
            Self::Terminated => "terminated",
            Self::Error => "in the error state; reset it or restore a stored state",
            Self::Event => "in event mode",
            Self::IntermediateUpdate => "in intermediate update mode",
        }
    }

    /// Whether a run has started and not ended.
    #[must_use]
    pub fn is_running(self) -> bool {
        matches!(
            self,
            Self::StepComplete | Self::StepFailed | Self::Event | Self::IntermediateUpdate
        )
    }
}

/// Groups of calls with the same entries in the table, by their first function.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    /// Reset, choice of log categories, end of the instance, stored states: always but in
    /// intermediate update mode.
    Always,
    Get,
    /// Of variables and of derivatives of inputs.
    Set,
    GetOutputDerivatives,
    DoStep,
    GetStatus,
    CancelStep,
    EnterEventMode,
    /// `fmi3UpdateDiscreteStates` and `fmi3EnterStepMode`.
    HandleEvent,
}

impl Call {
    pub(crate) fn allowed_in(self, state: State) -> bool {
        use State::{
            Error, Event, Initialisation, Instantiated, IntermediateUpdate, StepComplete, StepFailed,
            Terminated,
        };
        match self {
            Self::SetupExperiment | Self::EnterInitializationMode => state == Instantiated,
            Self::ExitInitializationMode => state == Initialisation,
            Self::Terminate => state.is_running() && state != IntermediateUpdate,
            Self::Always => state != IntermediateUpdate,
            Self::Get => state.is_running() || matches!(state, Initialisation | Terminated | Error),
            Self::GetOutputDerivatives => state.is_running() || matches!(state, Terminated | Error),
            // After a discarded step FMI 2.0 allows only rollback and the end. This instance is in
            // the state before the step, as in FMI 3.0, so the importer may also repeat it.
            Self::Set => state.is_running() || matches!(state, Instantiated | Initialisation),
            Self::DoStep | Self::EnterEventMode => matches!(state, StepComplete | StepFailed),
            Self::GetStatus => matches!(state, StepComplete | StepFailed | Terminated),
            Self::CancelStep => false,
            Self::HandleEvent => state == Event,
        }
    }
}
