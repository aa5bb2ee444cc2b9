//! The model descriptions of a toy unit.

use pushbelt_fmi::Version::{self, Three, Two};
use pushbelt_fmi::{model_description, token};

use crate::tank::Tank;

fn assert_described(version: Version, parts: &[&str], others: &[&str]) {
    let xml = model_description::<Tank>(version, None);
    for part in parts.iter().chain([&&*token::<Tank>(version, None)]) {
        assert!(xml.contains(part), "{part} in {xml}");
    }
    assert!(others.iter().all(|part| !xml.contains(part)), "{xml}");
}

#[test]
fn the_description_of_fmi_2_lists_every_variable() {
    let parts = [
        "guid=\"",
        "<CoSimulation modelIdentifier=\"Tank\"",
        "canInterpolateInputs=\"true\" maxOutputDerivativeOrder=\"1\"",
        "<ScalarVariable name=\"inflow\" valueReference=\"3\" description=\"\" causality=\"input\" variability=\"continuous\">",
        "<Real unit=\"1\" min=\"-1000\" max=\"10\" start=\"1\"/>",
        "<Integer min=\"1\" max=\"9\" start=\"2\"/>",
        "<Boolean start=\"false\"/>",
        "<Enumeration declaredType=\"Shape\" start=\"1\"/>",
        "name=\"depth[3]\" valueReference=\"13\"",
        "<Unknown index=\"5\" dependencies=\"\" dependenciesKind=\"\"/>",
    ];
    assert_described(Two, &parts, &["Directional"]);
}

#[test]
fn the_description_of_fmi_3_has_arrays_and_the_time() {
    let parts = [
        "instantiationToken=\"",
        "<Float64 name=\"time\" valueReference=\"0\"",
        "<Float64 name=\"depth\" valueReference=\"11\"",
        "<Dimension start=\"3\"/>",
        "hasEventMode=\"true\" maxOutputDerivativeOrder=\"1\"",
        "<Int32 name=\"floors\"",
        "<Output valueReference=\"5\"",
    ];
    assert_described(Three, &parts, &["depth[2]", "Directional", "Adjoint"]);
    assert_ne!(token::<Tank>(Three, None), token::<Tank>(Two, None));
}
