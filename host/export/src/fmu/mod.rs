//! A model as a unit of FMI 3.0 for co-simulation: an archive that other simulators load.
//!
//! # Design
//! The archive holds the model file, what is asked of it, a description, and the library `fmu`,
//! which is the native model behind FMI's functions. So every extension is covered, and answers are
//! those of the command, bit for bit.
//!
//! | file of the archive | what it is |
//! |---|---|
//! | `modelDescription.xml` | names, units and start values of the variables ([`interface`]) |
//! | `binaries/PLATFORM/NAME.so` | the library |
//! | `resources/model.toml` | the model file |
//! | `resources/unit.toml` | [`Asked`] |
//!
//! A unit answers one question: what the muscle does with an input, or which input brings about
//! what is wanted ([`Direction`]).

mod description;
pub mod interface;

use std::io::{Cursor, Write};
use std::path::Path;

use recording::TOOL;
use recording::model_file::ModelFile;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::name::{self, NoName};

/// The model's file in the folder of resources.
const MODEL: &str = "model.toml";
/// What is asked of it, beside.
const ASKED: &str = "unit.toml";

/// What a unit answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// The output for an input.
    Forward,
    /// The input for an output that is wanted.
    Inverse {
        /// From sample to sample. Unit: s, above 0.
        period_s: f64,
    },
}

/// What is asked of a model, and of which version.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// The tool that made the unit: its library is of the same one.
    tool: String,
    direction: Direction,
}

/// Why there is no unit.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum NoUnit {
    #[error(transparent)]
    Name(#[from] NoName),
    #[error("--period-s {0} s: a time above 0 s is needed")]
    Period(f64),
    #[error("the model has no inverse: {0}")]
    Inverse(model_core::ParameterError),
    #[error("FMI has no name for this platform ({0})")]
    Platform(String),
    #[error("the unit cannot be packed: {0}")]
    Archive(#[from] zip::result::ZipError),
    #[error("{file}: {why}")]
    Resource { file: String, why: String },
    #[error("the unit was made by {made}, its library is that of {TOOL}")]
    Version { made: String },
}

/// A model, and what is asked of it.
#[derive(Clone, Debug)]
pub struct Unit {
    /// The model.
    pub model: ModelFile,
    /// What the unit answers.
    pub direction: Direction,
    /// What tells this unit from every other one: a hash of its resources.
    pub token: String,
}

impl Unit {
    /// # Errors
    /// A period that is no time; a model without an inverse where that is asked for.
    pub fn new(model: ModelFile, direction: Direction) -> Result<Self, NoUnit> {
        if let Direction::Inverse { period_s } = direction {
            if !(period_s.is_finite() && period_s > 0.0) {
                return Err(NoUnit::Period(period_s));
            }
            let (parameters, limits) = (&model.parameters, model.parameters.input());
            let inverse = model_core::ExtendedInverse::try_new(parameters, &model.acting(), period_s, limits);
            inverse.map_err(NoUnit::Inverse)?;
        }
        let texts = [model.to_toml(), asked(direction)?];
        Ok(Self { model, direction, token: token(&texts) })
    }

    /// Reads it from the folder of resources of an archive that was unpacked.
    ///
    /// # Errors
    /// A file cannot be read or is not what it should be; another version has made it.
    pub fn read(resources: &Path) -> Result<Self, NoUnit> {
        let text = |name: &str| {
            let file = resources.join(name);
            std::fs::read_to_string(&file).map_err(|error| NoUnit::Resource {
                file: file.display().to_string(),
                why: error.to_string(),
            })
        };
        let texts = [text(MODEL)?, text(ASKED)?];
        let refused = |name: &str, why: String| NoUnit::Resource { file: name.to_owned(), why };
        let Asked { tool, direction } =
            toml::from_str(&texts[1]).map_err(|error| refused(ASKED, error.to_string()))?;
        if tool != TOOL {
            return Err(NoUnit::Version { made: tool });
        }
        let model = ModelFile::parse(Path::new(MODEL), &texts[0])
            .map_err(|error| refused(MODEL, error.to_string()))?;
        Ok(Self { model, direction, token: token(&texts) })
    }

    /// The archive, under a name, with the library of this platform.
    ///
    /// # Errors
    /// The name is not an identifier of C; the archive cannot be packed.
    pub fn archive(&self, name: &str, library: &[u8]) -> Result<Vec<u8>, NoUnit> {
        name::check(name)?;
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let binary = format!("binaries/{}/{name}{}", platform()?, std::env::consts::DLL_SUFFIX);
        let (model, asked) = (self.model.to_toml(), asked(self.direction)?);
        let description = description::xml(self, name);
        for (file, content) in [
            ("modelDescription.xml", description.as_bytes()),
            (&binary, library),
            (&format!("resources/{MODEL}"), model.as_bytes()),
            (&format!("resources/{ASKED}"), asked.as_bytes()),
        ] {
            archive.start_file(file, SimpleFileOptions::default())?;
            archive.write_all(content).map_err(zip::result::ZipError::from)?;
        }
        Ok(archive.finish()?.into_inner())
    }
}

/// The text of what is asked.
fn asked(direction: Direction) -> Result<String, NoUnit> {
    toml::to_string(&Asked { tool: TOOL.to_owned(), direction })
        .map_err(|error| NoUnit::Resource { file: ASKED.to_owned(), why: error.to_string() })
}

fn token(texts: &[String; 2]) -> String {
    let mut hash = Sha256::new();
    texts.iter().for_each(|text| hash.update(text));
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// FMI's name of this platform.
fn platform() -> Result<String, NoUnit> {
    let (architecture, system) = (std::env::consts::ARCH, std::env::consts::OS);
    let system = match system {
        "linux" | "windows" => system,
        "macos" => "darwin",
        _ => return Err(NoUnit::Platform(format!("{architecture}, {system}"))),
    };
    Ok(format!("{architecture}-{system}"))
}
