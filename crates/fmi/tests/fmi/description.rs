//! Model descriptions.

use pushbelt_fmi::Version::{Three, Two};
use pushbelt_fmi::{model_description, token};

use crate::tank::Tank;

/// A copy with other data has the token with the data's hash in it, so that a tool can calculate
/// it.
#[test]
fn a_token_has_the_hash_of_the_data_in_it() {
    for version in [Two, Three] {
        let [none, some] = [None, Some(0xabc << 100 | 0x123)].map(|data| {
            let digits = token::<Tank>(version, data).replace(['{', '-', '}'], "");
            u128::from_str_radix(&digits, 16).expect("hexadecimal")
        });
        assert_eq!(none ^ some, 0xabc << 100 | 0x123);
    }
}

#[test]
fn a_description_has_what_the_table_and_the_unit_declare() {
    let of_two = [
        r#"<fmiModelDescription fmiVersion="2.0" modelName="Tank" guid="{"#,
        r#"<CoSimulation modelIdentifier="Tank" canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true" maxOutputDerivativeOrder="1" canNotUseMemoryManagementFunctions="true" canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>"#,
        r#"<Category name="logStatusDiscard" description="Why a value was not taken"#,
        r#"<ScalarVariable name="gain" valueReference="2" description="" causality="parameter" variability="tunable" initial="exact">
      <Real unit="1" min="-1000" max="10" nominal="2e6" start="1"/>"#,
        r#"<Integer min="1" max="9" start="2"/>"#,
        r#"<Enumeration declaredType="Shape" start="1"/>"#,
        r#"<ScalarVariable name="depth[3]" valueReference="13" description="" causality="local" variability="continuous" initial="calculated">"#,
    ];
    let of_three = [
        r#"<fmiModelDescription fmiVersion="3.0" modelName="Tank" instantiationToken="{"#,
        r#"<CoSimulation modelIdentifier="Tank" canGetAndSetFMUState="true" canSerializeFMUState="true" canHandleVariableCommunicationStepSize="true" providesIntermediateUpdate="true" mightReturnEarlyFromDoStep="true" canReturnEarlyAfterIntermediateUpdate="true" hasEventMode="true" maxOutputDerivativeOrder="1"/>"#,
        r#"<Float64 name="time" valueReference="0" description="Time of the simulation" causality="independent" variability="continuous" unit="s"/>"#,
        r#"<Float64 name="inflow" valueReference="3" description="" causality="input" variability="continuous" intermediateUpdate="true" unit="1" min="-1000" start="2"/>"#,
        r#"<Int32 name="floors" valueReference="7" description="" causality="parameter" variability="fixed" initial="exact" min="1" max="9" start="2"/>"#,
        r#"<Float64 name="depth" valueReference="11" description="" causality="local" variability="continuous" initial="calculated" unit="1" min="-1000">
      <Dimension start="3"/>"#,
        r#"<Boolean name="locked" valueReference="19" description="" causality="parameter" variability="fixed" initial="exact" start="false"/>"#,
    ];
    let of_both = [
        r#"<Unit name="1">
      <BaseUnit/>
      <DisplayUnit name="%" factor="100"/>"#,
        r#"<Item name="Square" value="2" description="A box"/>"#,
        r#"<DefaultExperiment startTime="0" stopTime="1" tolerance="0.0001" stepSize="0.001"/>"#,
    ];
    for (version, parts) in [(Two, of_two), (Three, of_three)] {
        let text = model_description::<Tank>(version, None);
        for part in parts.iter().chain(&of_both) {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}

/// FMI 2.0 counts variables from 1, FMI 3.0 has their value references.
#[test]
fn outputs_have_their_dependencies() {
    let of_two = r#"
    <Outputs>
      <Unknown index="5" dependencies="" dependenciesKind=""/>
      <Unknown index="10" dependencies="" dependenciesKind=""/>
    </Outputs>
    <InitialUnknowns>
      <Unknown index="5"/>
      <Unknown index="10" dependencies="1 9" dependenciesKind="dependent dependent"/>
    </InitialUnknowns>
  </ModelStructure>"#;
    let of_three = r#"
    <Output valueReference="5" dependencies="" dependenciesKind=""/>
    <Output valueReference="20" dependencies="" dependenciesKind=""/>
    <InitialUnknown valueReference="5"/>
    <InitialUnknown valueReference="20" dependencies="1 19" dependenciesKind="dependent dependent"/>
  </ModelStructure>"#;
    for (version, structure) in [(Two, of_two), (Three, of_three)] {
        let text = model_description::<Tank>(version, None);
        assert!(text.contains(structure), "{text}");
    }
}
