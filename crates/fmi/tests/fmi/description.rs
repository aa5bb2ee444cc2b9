//! Model descriptions.

use pushbelt_fmi::Version::{Three, Two};
use pushbelt_fmi::model_description;

use crate::tank::Tank;

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
