//! The variables of a model description, and the tables generated from them.

use std::fmt::Write as _;

use anyhow::Context;
use roxmltree::{Document, Node};

/// A variable in the documentation.
#[derive(Debug, PartialEq, Eq)]
pub struct Variable {
    causality: String,
    /// Text below each of the [`HEADINGS`]; missing attributes are empty.
    cells: [String; HEADINGS.len()],
}

/// The parts of a model description that are in the documentation.
#[derive(Debug, PartialEq, Eq)]
pub struct Description {
    /// One sentence about the model.
    pub about: String,
    /// Version of the model.
    pub version: String,
    /// All variables, in the order of the table.
    pub variables: Vec<Variable>,
}

/// The same text with the attribute `generationDateAndTime`, which does not affect the GUID (the
/// instantiation token of FMI 3.0).
///
/// # Errors
/// The text is not XML, or its root has neither.
pub fn with_date(xml: &str, date: &str) -> anyhow::Result<String> {
    let document = Document::parse(xml).context("the model description is not XML")?;
    let root = document.root_element();
    let guid = root
        .attribute_node("guid")
        .or_else(|| root.attribute_node("instantiationToken"));
    let (before, after) = xml.split_at(guid.context("the model description has no GUID")?.range().start);
    Ok(format!("{before}generationDateAndTime=\"{date}\" {after}"))
}

/// Groups of variables in the order of their use.
const GROUPS: [(&str, &str); 4] = [
    ("input", "Inputs"),
    ("output", "Outputs"),
    ("parameter", "Parameters"),
    ("local", "Local variables"),
];

const HEADINGS: [&str; 7] = ["Variable", "Type", "Unit", "Start", "Min", "Max", "Meaning"];

impl Description {
    /// Reads the text of a `modelDescription.xml`.
    ///
    /// # Errors
    /// The text is not XML or has no variables.
    pub fn parse(xml: &str) -> anyhow::Result<Self> {
        let document = Document::parse(xml).context("the model description is not XML")?;
        let types = document.descendants().filter(|node| node.has_tag_name("SimpleType"));
        let enumerations: Vec<(&str, String)> = types
            .filter_map(|node| Some((node.attribute("name")?, items(node))))
            .collect();
        let variables = document
            .descendants()
            .find(|node| node.has_tag_name("ModelVariables"))
            .context("the model description has no variables")?
            .children()
            .filter(Node::is_element)
            .map(|node| variable(node, &enumerations))
            .collect::<anyhow::Result<Vec<_>>>()?;
        let root = document.root_element();
        Ok(Self {
            about: attribute(root, "description"),
            version: attribute(root, "version"),
            variables: collapse(variables),
        })
    }

    /// All variables as a page in Markdown.
    pub fn to_markdown(&self) -> String {
        let mut page = format!(
            "<!-- Written by `cargo fmu describe` from the variable table: don't edit. -->\n\n# Variables\n\n\
             {}. SI units; torques are positive in the direction of positive speed.\n",
            self.about.trim_end_matches('.')
        );
        for (causality, title) in GROUPS {
            let _ = write!(
                page,
                "\n## {title}\n\n| {} |\n|{}\n",
                HEADINGS.join(" | "),
                "---|".repeat(HEADINGS.len())
            );
            for variable in self.of(causality) {
                let [name, others @ ..] = variable.cells.each_ref().map(|cell| cell.replace('|', "\\|"));
                let _ = writeln!(page, "| `{name}` | {} |", others.join(" | "));
            }
        }
        page
    }

    /// All variables as tables in HTML.
    pub fn to_html(&self) -> String {
        let mut html = String::new();
        for (causality, title) in GROUPS {
            let _ = write!(html, "<h3>{title}</h3>\n<table>\n<tr>");
            for heading in HEADINGS {
                let _ = write!(html, "<th>{heading}</th>");
            }
            html.push_str("</tr>\n");
            for variable in self.of(causality) {
                html.push_str("<tr>");
                for cell in &variable.cells {
                    let _ = write!(html, "<td>{}</td>", escape(cell));
                }
                html.push_str("</tr>\n");
            }
            html.push_str("</table>\n");
        }
        html
    }

    fn of<'a>(&'a self, causality: &'a str) -> impl Iterator<Item = &'a Variable> {
        self.variables
            .iter()
            .filter(move |variable| variable.causality == causality)
    }
}

fn variable(node: Node, enumerations: &[(&str, String)]) -> anyhow::Result<Variable> {
    let name = attribute(node, "name");
    let typed = node
        .children()
        .find(Node::is_element)
        .with_context(|| format!("{name} has no type"))?;
    let choices = typed
        .attribute("declaredType")
        .and_then(|declared| enumerations.iter().find(|(name, _)| *name == declared))
        .map(|(_, items)| items.as_str());
    let mut kind = typed.tag_name().name().to_owned();
    if node.attribute("variability") == Some("tunable") {
        kind += ", tunable";
    }
    let [unit, start, min, max] = ["unit", "start", "min", "max"].map(|name| attribute(typed, name));
    let mut description = attribute(node, "description");
    if let Some(choices) = choices {
        description += &format!(" ({choices})");
    }
    Ok(Variable {
        causality: attribute(node, "causality"),
        cells: [name, kind, unit, start, min, max, description],
    })
}

/// The values of an enumeration in words.
fn items(node: Node) -> String {
    node.descendants()
        .filter(|item| item.has_tag_name("Item"))
        .map(|item| format!("{} {}", attribute(item, "value"), attribute(item, "name")))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Elements of an array that differ in their index only become one line `name[1…n]`.
fn collapse(variables: Vec<Variable>) -> Vec<Variable> {
    let mut collapsed: Vec<Variable> = Vec::new();
    let mut open: Option<(String, u32)> = None;
    for mut variable in variables {
        let [name, .., description] = &mut variable.cells;
        let element = name
            .strip_suffix(']')
            .and_then(|name| name.rsplit_once('['))
            .and_then(|(array, index)| Some((array.to_owned(), index.parse().ok()?)));
        match (element, &mut open, collapsed.last_mut()) {
            (Some((array, index)), Some((current, last)), Some(line))
                if array == *current && index == *last + 1 =>
            {
                *last = index;
                line.cells[0] = format!("{array}[1…{index}]");
            }
            (element, ..) => {
                // The description of the first element, with its index `0/n`, applies to all.
                if let Some(before) = element.as_ref().and_then(|(_, index)| index.checked_sub(1)) {
                    *description = description.replace(&format!(" {before}/"), " (k−1)/");
                }
                open = element;
                collapsed.push(variable);
            }
        }
    }
    collapsed
}

fn attribute(node: Node, name: &str) -> String {
    node.attribute(name).unwrap_or_default().to_owned()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_is_an_attribute_of_the_root() {
        let xml = r#"<?xml version="1.0"?><a name="b" guid="{c}"><d guid="e"/></a>"#;
        let dated = with_date(xml, "2026-01-02T03:04:05Z").unwrap();
        let document = Document::parse(&dated).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("generationDateAndTime"), Some("2026-01-02T03:04:05Z"));
        assert_eq!(root.attribute("guid"), Some("{c}"));
        let dated = with_date(r#"<a instantiationToken="{c}"/>"#, "today").unwrap();
        assert_eq!(dated, r#"<a generationDateAndTime="today" instantiationToken="{c}"/>"#);
        assert!(with_date("<a/>", "").is_err());
    }

    const XML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription description="A model" version="1.2.3">
  <TypeDefinitions>
    <SimpleType name="Drive"><Enumeration>
      <Item name="Torque" value="1"/><Item name="Speed" value="2"/>
    </Enumeration></SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="torque" causality="input" variability="continuous" description="a|b">
      <Real unit="N.m" start="50"/>
    </ScalarVariable>
    <ScalarVariable name="drive" causality="parameter" variability="fixed" description="Drive">
      <Enumeration declaredType="Drive" start="1"/>
    </ScalarVariable>
    <ScalarVariable name="x[1]" causality="local" description="Field at 0/2"><Real unit="m"/></ScalarVariable>
    <ScalarVariable name="x[2]" causality="local" description="Field"><Real unit="m"/></ScalarVariable>
    <ScalarVariable name="y[1]" causality="local" description="Other"><Real unit="m"/></ScalarVariable>
  </ModelVariables>
</fmiModelDescription>"#;

    #[test]
    fn variables_are_read_with_unit_start_and_choices() {
        let description = Description::parse(XML).unwrap();
        assert_eq!(description.about, "A model");
        assert_eq!(description.variables[0].cells[2], "N.m");
        assert_eq!(description.variables[1].cells[6], "Drive (1 Torque, 2 Speed)");
    }

    #[test]
    fn arrays_take_one_line() {
        let description = Description::parse(XML).unwrap();
        let names: Vec<_> = description.of("local").map(|v| v.cells[0].as_str()).collect();
        assert_eq!(names, ["x[1…2]", "y[1]"]);
        let field = description.of("local").next().unwrap();
        assert_eq!(field.cells[6], "Field at (k−1)/2");
    }

    #[test]
    fn tables_hold_every_variable_and_escape_what_would_break_them() {
        let description = Description::parse(XML).unwrap();
        let markdown = description.to_markdown();
        assert!(markdown.contains("| `torque` | Real | N.m | 50 |  |  | a\\|b |"));
        assert!(markdown.contains("`x[1…2]`"));
        assert!(description.to_html().contains("<td>drive</td>"));
    }
}
