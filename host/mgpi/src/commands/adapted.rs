//! `mgpi adapted`: what a board has learnt of its muscle, as a model file.

use std::path::{Path, PathBuf};

use clap::Args;
use identification::Options;
use identification::adapted::{Followed, follow};
use model_core::adaptation::Change;
use recording::model_file::ModelFile;

use super::board_model;
use super::port::PortArguments;
use crate::Error;
use crate::output::Outputs;
use board_client::bus::adapted::Adapted;
use board_client::bus::{BoardError, upload};
use board_client::pil::configuration;

/// Keeps what a board has learnt of its muscle (`mgpi track --adapt`) as a model, to be tuned and
/// deployed.
///
/// The board, its model and what it has learnt stay as they are.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model that the board has
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    /// Where the model of the muscle as it is now goes
    #[arg(short = 'o', value_name = "ADAPTED.toml")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    port: PortArguments,
}

/// Keeps.
///
/// # Errors
/// The board does not answer, has another model or has learnt nothing; no model of the same
/// structure is nearer to what it has learnt; the file cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { model: file, output, force, port } = arguments;
    let mut outputs = Outputs::claim([output], &[file], *force)?;
    let model = board_model::read(file)?;
    let mut board = port.open()?;
    let installed = upload::fetch(&mut board)?;
    let rate_hz = f64::from(installed.tracking.period_s).recip();
    let meant = configuration(Path::new(""), &model, rate_hz)?.tracking;
    let has = &installed.tracking;
    if meant.model != has.model || meant.extensions != has.extensions {
        return Err(Error::Usage(format!(
            "{}: the board has another model: {}. What it has learnt is about that one",
            file.display(),
            board_model::words(has)
        )));
    }
    let learnt = Adapted::read(&mut board).map_err(BoardError::from)?;
    if learnt.steps == 0 {
        return Err(Error::Usage(
            "the board has learnt nothing of its muscle: `mgpi track --adapt` lets it, a stroke or more"
                .to_owned(),
        ));
    }
    let Adapted { offset_mm: offset, gain_mm: gain, bend_mm: bend, width_mm: width, flare_mm: flare, .. } =
        learnt;
    let change = Change { offset, gain, bend, width, flare };
    let refused = |why: &dyn std::fmt::Display| Error::Usage(format!("{}: {why}", file.display()));
    let followed = follow(&model.parameters, &model.density, change, Options::default())
        .map_err(|problem| refused(&problem))?;
    let Followed { fit, before, after, stroke } = followed;
    if after >= before {
        return Err(refused(&format!(
            "no model of its structure is nearer to what was learnt: {after:.3} mm off, itself {before:.3} mm"
        )));
    }
    // What was measured of the old muscle, and the feedback for it, is not known of this one.
    let adapted = ModelFile {
        density: fit.density,
        model: fit.model,
        parameters: fit.parameters,
        identification: None,
        tuning: None,
        ..model
    };
    outputs.stage(output, adapted.to_toml().as_bytes())?;
    outputs.commit()?;
    say!("learnt        {learnt}");
    say!(
        "{}: RMSE {after:.3} mm, {:.2} % of stroke, from the muscle as it was learnt; {} {before:.3} mm",
        output.display(),
        100.0 * after / stroke,
        file.display()
    );
    say!("its feedback is not tuned: `mgpi tune` does that");
    Ok(())
}
