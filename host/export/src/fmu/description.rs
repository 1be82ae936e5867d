//! `modelDescription.xml`.

use std::fmt::Write;

use recording::TOOL;

use super::interface::Variable;
use super::{Direction, Unit};

/// The text of a unit's description, under a name.
pub fn xml(unit: &Unit, name: &str) -> String {
    let variables = unit.variables();
    let (input, output, kind) = (&unit.model.input, &unit.model.output, unit.model.parameters.kind());
    let (about, step) = match unit.direction {
        Direction::Forward => (
            format!("{} over {}, a model of kind {kind}", output.words(), input.words()),
            "canHandleVariableCommunicationStepSize=\"true\"".to_owned(),
        ),
        Direction::Inverse { period_s } => (
            format!("{} for a wanted {}, by a model of kind {kind}", input.words(), output.words()),
            format!(
                "canHandleVariableCommunicationStepSize=\"false\" fixedInternalStepSize=\"{period_s:?}\""
            ),
        ),
    };
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" instantiationToken=\"{}\" \
         description=\"{}\" generationTool=\"{}\" variableNamingConvention=\"flat\">\n  \
         <CoSimulation modelIdentifier=\"{name}\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" {step}/>\n  \
         <UnitDefinitions>\n",
        unit.token,
        escaped(&about),
        escaped(TOOL)
    );
    let mut symbols: Vec<&str> = variables.iter().map(|variable| variable.unit.symbol()).collect();
    symbols.push("s");
    symbols.sort_unstable();
    symbols.dedup();
    for symbol in symbols {
        let _ = writeln!(text, "    <Unit name=\"{}\"/>", escaped(symbol));
    }
    text += "  </UnitDefinitions>\n  <ModelVariables>\n    \
             <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\" unit=\"s\"/>\n";
    for Variable { reference, name, unit, start, about } in &variables {
        let role = match start {
            Some(start) => format!("causality=\"input\" start=\"{start:?}\""),
            None => "causality=\"output\"".to_owned(),
        };
        let _ = writeln!(
            text,
            "    <Float64 name=\"{}\" valueReference=\"{reference}\" {role} variability=\"continuous\" unit=\"{}\" description=\"{}\"/>",
            escaped(name),
            escaped(unit.symbol()),
            escaped(about)
        );
    }
    text += "  </ModelVariables>\n  <ModelStructure>\n";
    for element in ["Output", "InitialUnknown"] {
        for output in variables.iter().filter(|variable| variable.start.is_none()) {
            let _ = writeln!(text, "    <{element} valueReference=\"{}\"/>", output.reference);
        }
    }
    text + "  </ModelStructure>\n</fmiModelDescription>\n"
}

/// A text as a value of an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_xml_keeps_for_itself_is_escaped() {
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
