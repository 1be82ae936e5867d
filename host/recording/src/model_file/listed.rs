//! A board's model: in bar and mm, its plays listed, since a board knows no density; with its
//! extensions.

use model_core::ExtensionParameters;
use toml::Table;

use super::names::Names;
use super::section::Section;
use super::{Problem, extensions, parameters, read, write};
use crate::model::HostParameters;

/// The model as a table.
pub fn to_table(parameters: &HostParameters, extensions: &ExtensionParameters<f64>) -> Table {
    let mut table = Table::new();
    table.insert("kind".into(), parameters.kind().name().into());
    table.insert("validity".into(), write::validity(parameters, &Names::BOARD));
    parameters::write(parameters, None, &Names::BOARD, &mut table);
    extensions::write(extensions, &Names::BOARD, &mut table);
    table
}

/// The model of a table.
///
/// # Errors
/// A key that is missing, unknown or of another kind. Whether a controller can be made of the model
/// is left to the board.
pub fn of_section(mut section: Section) -> Result<(HostParameters, ExtensionParameters<f64>), Problem> {
    let kind = read::kind(&mut section)?;
    let (limits, preconditioned) = read::validity(section.section("validity")?, Names::BOARD.input)?;
    let (parameters, _) = parameters::read(kind, &mut section, &Names::BOARD, limits)?;
    let extensions = extensions::read(&mut section, &Names::BOARD)?;
    section.finish()?;
    Ok((parameters.with_preconditioned(preconditioned), extensions))
}

/// The causes that a board's model is extended by, by their names in files.
pub fn causes(extensions: &ExtensionParameters<f64>) -> Vec<String> {
    extensions::causes_of(extensions, &Names::BOARD)
}
