//! Parameters, inputs and variables: their ranges, and the model descriptions.

mod gradient;
mod initial_unknowns;
mod model_description;
mod validation;
