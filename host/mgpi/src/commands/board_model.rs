//! A model for a board, for the commands that drive a valve by one: in the board's units, and what
//! it is worth.

use std::path::Path;

use serde_json::Value;
use wire::{BoardParameters, Configuration};

use crate::Error;
use board_client::pil::parts;
use recording::model_file::{ModelFile, listed};

/// Reads a model, brings it to the units of a board, and says what it is and what it is worth. One
/// that no board can take stays as it is.
///
/// # Errors
/// The file is no model.
pub fn read(file: &Path) -> Result<ModelFile, Error> {
    let read = ModelFile::read(file)?;
    let model = read.for_board().transpose()?.unwrap_or_else(|| read.clone());
    say!("{}: {}", file.display(), kind(model.parameters.kind().name(), &model.causes()));
    say!("{}: {}", file.display(), worth(&model));
    if model.names() != read.names() {
        say!("{}: converted from {} and {} to bar and mm", file.display(), read.input.unit, read.output.unit);
    }
    Ok(model)
}

/// What is known of what a model is worth.
pub fn worth(model: &ModelFile) -> String {
    model.worth().map_or_else(
        || "what it is worth is not known: its file holds no error on a recording".to_owned(),
        |worth| worth.to_string(),
    )
}

/// The same for programs; null where it is not known.
pub fn worth_json(model: Option<&ModelFile>) -> Value {
    model.and_then(ModelFile::worth).map(|worth| worth.to_json()).into()
}

/// A model that is off by too much is not for a valve, unless the user insists.
///
/// # Errors
/// It is, and `force` is not set.
pub fn demand_worth(file: &Path, model: &ModelFile, force: bool) -> Result<(), Error> {
    match model.worth() {
        Some(worth) if !worth.may_deploy() && !force => Err(Error::Usage(format!(
            "{}: {worth}\n  A model that is off by more than 10 % of stroke is no better than a straight line: it is not \
             deployed. --force deploys it all the same",
            file.display()
        ))),
        _ => Ok(()),
    }
}

/// Says what a board has installed, and what that is worth: a board holds no figures, so `model` is
/// what is known of them.
pub fn say_installed(installed: &Configuration, model: Option<&ModelFile>) {
    let model_words = words(&installed.tracking);
    let (its_model, its_extensions) = (&installed.tracking.model, &installed.tracking.extensions);
    match model.map(|model| parts(Path::new(""), model)) {
        None => say!(
            "the board has {model_words}; what it is worth is not known here: --model MODEL.toml, which was deployed, says so"
        ),
        Some(Ok((model, extensions)))
            if model == *its_model && extensions.with_times_of(its_extensions) == *its_extensions =>
        {
            say!("the board has this model");
        }
        Some(_) => say!("the board has another model: {model_words}"),
    }
}

/// A board's model in words: kind, number of plays, range, extensions.
pub fn words(parameters: &BoardParameters) -> String {
    let (lowest, highest) = parameters.model.input();
    // The host has room for all that a board has.
    let causes = parameters.extensions.convert().map_or_else(|_| Vec::new(), |all| listed::causes(&all));
    format!("{}, {lowest} to {highest} bar", kind(parameters.model.kind().name(), &causes))
}

fn kind(name: &str, causes: &[String]) -> String {
    let causes = if causes.is_empty() { "no extension".to_owned() } else { causes.join(", ") };
    format!("{name} with {causes}")
}
