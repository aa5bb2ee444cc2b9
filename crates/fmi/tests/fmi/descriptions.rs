//! The model descriptions of a toy unit.

use pushbelt_fmi::{fmi2, fmi3};

use crate::tank::Tank;

#[test]
fn the_description_of_fmi_2_lists_every_variable() {
    let xml = fmi2::model_description::<Tank>();
    for part in [
        &format!("guid=\"{}\"", fmi2::guid::<Tank>()),
        "<CoSimulation modelIdentifier=\"Tank\"",
        "canInterpolateInputs=\"true\" maxOutputDerivativeOrder=\"1\"",
        "<ScalarVariable name=\"inflow\" valueReference=\"3\" description=\"\" causality=\"input\" variability=\"continuous\">",
        "<Real unit=\"1\" min=\"-1000\" max=\"10\" start=\"1\"/>",
        "<Integer min=\"1\" max=\"9\" start=\"2\"/>",
        "<Boolean start=\"false\"/>",
        "<Enumeration declaredType=\"Shape\" start=\"1\"/>",
        "name=\"depth[3]\" valueReference=\"13\"",
        "<Unknown index=\"5\" dependencies=\"\" dependenciesKind=\"\"/>",
    ] {
        assert!(xml.contains(part), "{part} in {xml}");
    }
    assert!(!xml.contains("Directional"));
}

#[test]
fn the_description_of_fmi_3_has_arrays_and_the_time() {
    let xml = fmi3::model_description::<Tank>();
    for part in [
        &format!("instantiationToken=\"{}\"", fmi3::instantiation_token::<Tank>()),
        "<Float64 name=\"time\" valueReference=\"0\"",
        "<Float64 name=\"depth\" valueReference=\"11\"",
        "<Dimension start=\"3\"/>",
        "hasEventMode=\"true\" maxOutputDerivativeOrder=\"1\"",
        "<Int32 name=\"floors\"",
        "<Output valueReference=\"5\"",
    ] {
        assert!(xml.contains(part), "{part} in {xml}");
    }
    assert!(!xml.contains("depth[2]") && !xml.contains("Directional") && !xml.contains("Adjoint"));
    assert_ne!(fmi3::instantiation_token::<Tank>(), fmi2::guid::<Tank>());
}
