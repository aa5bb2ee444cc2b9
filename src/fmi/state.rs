//! The state machine of a co-simulation slave: which call is allowed when (table 4.2.4 of the standard).

/// States of a slave. A step is finished when `fmi2DoStep` returns, so the states "step in progress" and "step
/// cancelled" never occur; neither does "fatal", since no instance can harm another.
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
    /// A call failed: only reset, a stored state or the end of the instance go on from here.
    Error,
}

impl State {
    /// All states, in the order of their numbers in stored states.
    pub const ALL: [Self; 6] = [
        Self::Instantiated,
        Self::Initialisation,
        Self::StepComplete,
        Self::StepFailed,
        Self::Terminated,
        Self::Error,
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
            Self::Error => "in the error state",
        }
    }
}

/// Groups of calls with the same entries in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// `fmi2SetupExperiment`.
    SetupExperiment,
    /// `fmi2EnterInitializationMode`.
    EnterInitializationMode,
    /// `fmi2ExitInitializationMode`.
    ExitInitializationMode,
    /// `fmi2Terminate`.
    Terminate,
    /// `fmi2Reset`, `fmi2SetDebugLogging` and the FMU state functions.
    Always,
    /// `fmi2GetReal`, `fmi2GetInteger`, `fmi2GetBoolean`, `fmi2GetString`, `fmi2GetDirectionalDerivative`.
    Get,
    /// `fmi2SetReal`, `fmi2SetInteger`, `fmi2SetBoolean`, `fmi2SetString`, `fmi2SetRealInputDerivatives`.
    Set,
    /// `fmi2GetRealOutputDerivatives`.
    GetOutputDerivatives,
    /// `fmi2DoStep`.
    DoStep,
    /// `fmi2GetStatus` and its kin.
    GetStatus,
    /// `fmi2CancelStep`.
    CancelStep,
}

impl Call {
    /// Whether the call is allowed in a state.
    #[must_use]
    pub fn allowed_in(self, state: State) -> bool {
        use State::{Error, Initialisation, Instantiated, StepComplete, StepFailed, Terminated};
        match self {
            Self::SetupExperiment | Self::EnterInitializationMode => state == Instantiated,
            Self::ExitInitializationMode => state == Initialisation,
            Self::Terminate => matches!(state, StepComplete | StepFailed),
            Self::Always => true,
            Self::Get => matches!(state, Initialisation | StepComplete | StepFailed | Terminated | Error),
            Self::GetOutputDerivatives => matches!(state, StepComplete | StepFailed | Terminated | Error),
            // After a discarded step the standard knows only rollback and the end. This slave stands at its last
            // successful time, so it also lets the master change inputs and go on from there.
            Self::Set => matches!(state, Instantiated | Initialisation | StepComplete | StepFailed),
            Self::DoStep => matches!(state, StepComplete | StepFailed),
            Self::GetStatus => matches!(state, StepComplete | StepFailed | Terminated),
            Self::CancelStep => false,
        }
    }
}
