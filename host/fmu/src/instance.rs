//! A unit at work.

use export::fmu::interface::{ANSWER, DRIVE, LOAD, PRESSURE, TEMPERATURE, TIME};
use export::fmu::{Direction, Unit};
use model_core::extension::{ExtendedInverseState, ExtendedState, Sample};
use model_core::{ExtendedInverse, Surroundings};
use recording::model::{DEAD_ZONES, HostExtendedModel, PLAYS};
use recording::simulation::{SAME_STEP_S, same_step};
use serde::{Deserialize, Serialize};

/// The most periods of an inverse in one step of the simulation, so that a call ends: a quarter of
/// an hour at 1 kHz.
const STEPS: f64 = 1e6;

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    Instantiated,
    Initializing,
    Stepping,
    Terminated,
}

/// A unit at work.
pub struct Instance {
    /// What tells the unit from every other one.
    token: String,
    work: Work,
    /// What variables there are.
    references: Vec<u32>,
    begins: State,
    /// What changes.
    pub state: State,
}

/// What a unit does.
enum Work {
    Forward(Box<HostExtendedModel>),
    Inverse { inverse: Box<ExtendedInverse<f64, PLAYS, DEAD_ZONES>>, period_s: f64 },
}

/// What changes while it works.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub mode: Mode,
    time_s: f64,
    drive: f64,
    load: Option<f64>,
    temperature: Option<f64>,
    answer: f64,
    pressure: f64,
    memory: Memory,
}

/// What the model remembers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Memory {
    /// And its last step of time. Unit: s.
    Forward(Box<ExtendedState<f64, PLAYS>>, f64),
    Inverse(Box<ExtendedInverseState<f64, PLAYS>>),
}

impl Instance {
    /// # Errors
    /// None for a unit that was exported; else what its model lacks, in words.
    pub fn new(unit: &Unit) -> Result<Self, String> {
        let parameters = &unit.model.parameters;
        let (work, memory) = match unit.direction {
            Direction::Forward => {
                let model = Box::new(unit.model.extended().map_err(in_words)?);
                let memory = Memory::Forward(Box::new(model.rest_state()), 0.0);
                (Work::Forward(model), memory)
            }
            Direction::Inverse { period_s } => {
                let limits = parameters.input();
                let inverse = ExtendedInverse::try_new(parameters, &unit.model.acting(), period_s, limits);
                let inverse = Box::new(inverse.map_err(in_words)?);
                let memory = Memory::Inverse(Box::new(inverse.rest_state()));
                (Work::Inverse { inverse, period_s }, memory)
            }
        };
        let variables = unit.variables();
        let start = |reference| {
            variables.iter().find(|variable| variable.reference == reference).and_then(|found| found.start)
        };
        let state = State {
            mode: Mode::Instantiated,
            time_s: 0.0,
            drive: start(DRIVE).unwrap_or_default(),
            load: start(LOAD),
            temperature: start(TEMPERATURE),
            answer: 0.0,
            pressure: 0.0,
            memory,
        };
        let references = variables.iter().map(|variable| variable.reference).collect();
        Ok(Self { token: unit.token.clone(), work, references, begins: state.clone(), state })
    }

    /// As it was made.
    pub fn reset(&mut self) {
        self.state = self.begins.clone();
    }

    /// Begins at a time, s.
    pub fn begin(&mut self, time_s: f64) {
        (self.state.time_s, self.state.mode) = (time_s, Mode::Initializing);
    }

    /// The first sample.
    ///
    /// # Errors
    /// An input that is no number.
    pub fn initialize(&mut self) -> Result<(), String> {
        self.sample(0.0)?;
        self.state.mode = Mode::Stepping;
        Ok(())
    }

    /// A variable's value.
    ///
    /// # Errors
    /// The reference names no variable; or an input is not a number while the unit is initialised.
    pub fn get(&self, reference: u32) -> Result<f64, String> {
        let State { mode, time_s, drive, load, temperature, answer, pressure, .. } = &self.state;
        match reference {
            TIME => Ok(*time_s),
            _ if !self.references.contains(&reference) => Err(no_variable(reference)),
            ANSWER | PRESSURE if *mode == Mode::Initializing => {
                // What the first sample would answer.
                let mut first = self.state.clone();
                self.work.sample(&mut first, 0.0)?;
                Ok(if reference == ANSWER { first.answer } else { first.pressure })
            }
            DRIVE => Ok(*drive),
            ANSWER => Ok(*answer),
            PRESSURE => Ok(*pressure),
            LOAD => Ok(load.unwrap_or(f64::NAN)),
            _ => Ok(temperature.unwrap_or(f64::NAN)),
        }
    }

    /// Sets an input.
    ///
    /// # Errors
    /// There is no such variable, or it is no input; the value is no number.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), String> {
        if reference != TIME && !self.references.contains(&reference) {
            return Err(no_variable(reference));
        }
        if !value.is_finite() {
            return Err(format!("variable {reference}: {value} is no finite number"));
        }
        match reference {
            DRIVE => self.state.drive = value,
            LOAD => self.state.load = Some(value),
            TEMPERATURE => self.state.temperature = Some(value),
            _ => return Err(format!("variable {reference} is an output, which cannot be set")),
        }
        Ok(())
    }

    /// A step of time from a moment on, both s; the state is as it was where it is refused.
    ///
    /// # Errors
    /// The step does not begin at the last sample, is not a multiple of an inverse's period, or is
    /// too long; or a delay spans more samples than it can hold.
    pub fn step(&mut self, from_s: f64, step_s: f64) -> Result<(), String> {
        let steps = match self.work {
            Work::Forward(_) => 1.0,
            Work::Inverse { period_s, .. } => {
                let steps = (step_s / period_s).round();
                // A step that is no number is no multiple either.
                let is_multiple = (step_s - steps * period_s).abs() <= SAME_STEP_S;
                if !(is_multiple && (1.0..=STEPS).contains(&steps)) {
                    return Err(format!(
                        "a step of {step_s} s is no multiple of the inverse's period, {period_s} s"
                    ));
                }
                steps
            }
        };
        let mut next = self.state.clone();
        for _ in 0..steps as usize {
            self.work.sample(&mut next, step_s)?;
        }
        next.time_s = from_s + step_s;
        self.state = next;
        Ok(())
    }

    fn sample(&mut self, dt_s: f64) -> Result<(), String> {
        self.work.sample(&mut self.state, dt_s)
    }

    /// The time. Unit: s.
    pub fn time_s(&self) -> f64 {
        self.state.time_s
    }

    /// A state as bytes.
    ///
    /// # Errors
    /// None in practice.
    pub fn serialized(&self, state: &State) -> Result<Vec<u8>, String> {
        postcard::to_stdvec(&(&self.token, state)).map_err(|error| error.to_string())
    }

    /// A state from bytes.
    ///
    /// # Errors
    /// They are none, or of another unit.
    pub fn deserialized(&self, bytes: &[u8]) -> Result<State, String> {
        let refused = |error: postcard::Error| format!("the bytes are no state of a unit: {error}");
        let (token, rest) = postcard::take_from_bytes::<String>(bytes).map_err(refused)?;
        if token != self.token {
            return Err("the state is that of another unit".to_owned());
        }
        match postcard::take_from_bytes::<State>(rest).map_err(refused)? {
            (state, []) => Ok(state),
            (_, more) => Err(format!("the bytes are no state of a unit: {} too many", more.len())),
        }
    }
}

impl Work {
    /// One sample, a step of time after the one before. The state is as it was where it is refused.
    fn sample(&self, state: &mut State, dt_s: f64) -> Result<(), String> {
        let surroundings = Surroundings { load: state.load, temperature: state.temperature };
        match (self, &mut state.memory) {
            (Self::Forward(model), Memory::Forward(memory, step_s)) => {
                let dt_s = same_step(*step_s, dt_s);
                let sample = Sample { input: state.drive, surroundings, dt_s };
                let output = model.step(memory, &sample).map_err(in_words)?;
                *step_s = dt_s;
                (state.answer, state.pressure) = (output.contraction, output.pressure);
            }
            (Self::Inverse { inverse, .. }, Memory::Inverse(memory)) => {
                state.answer = inverse.step(memory, state.drive, &surroundings).map_err(in_words)?;
            }
            _ => return Err("the state is that of another unit".to_owned()),
        }
        Ok(())
    }
}

fn in_words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn no_variable(reference: u32) -> String {
    format!("there is no variable {reference}")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use model_core::play::PlayParameters;
    use recording::model::{HostModel, HostParameters};
    use recording::model_file::ModelFile;
    use recording::simulation::Rows;

    const PAPER: &str = include_str!("../../../examples/paper-tables-1-2.toml");
    const EXTENSIONS: &str = include_str!("../../mgpi/tests/common/every_extension.toml");
    const PERIOD_S: f64 = 0.01;

    /// The paper's muscle from the command on.
    fn model(extensions: &str) -> ModelFile {
        let text = PAPER.replace("column = \"pressure_bar\"", "column = \"command_bar\"");
        ModelFile::parse(Path::new("m.toml"), &format!("{text}\n{extensions}")).expect("a model")
    }

    /// The same with so many plays that they are kept by turning points.
    fn with_many_plays(extensions: &str) -> ModelFile {
        let mut file = model(extensions);
        let HostParameters::Cascade(cascade) = &mut file.parameters else {
            panic!("the paper's is a cascade")
        };
        cascade.plays = PlayParameters::exponential(30, 0.3, 0.2, 5.0, 0.03).expect("plays");
        // Which few plays alone can have.
        file.extensions.rate_dependent_thresholds = None;
        file.model = HostModel::try_new(&file.parameters).expect("a model");
        file
    }

    fn instance_of(model: ModelFile, direction: Direction) -> Instance {
        Instance::new(&Unit::new(model, direction).expect("a unit")).expect("an instance")
    }

    fn instance(extensions: &str, direction: Direction) -> Instance {
        instance_of(model(extensions), direction)
    }

    /// Swings that decay, so that turning points are kept, at unequal steps. Units: s, bar.
    fn rows() -> (Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> =
            (0..600).map(|row| 0.01 * f64::from(row) + 0.004 * f64::from(row % 3)).collect();
        let swing = |t: &f64| 3.0 + 3.0 * (-0.2 * t).exp() * (5.0 * t - 1.5).sin();
        let drive = time_s.iter().map(swing).collect();
        (time_s, drive)
    }

    /// The answers to some rows, `from` on; the instance has done those before.
    fn go(instance: &mut Instance, (time_s, drive): (&[f64], &[f64]), from: usize) -> Vec<f64> {
        let mut answers = Vec::new();
        for (row, drive) in drive.iter().enumerate().skip(from) {
            instance.set(DRIVE, *drive).expect("an input");
            match row {
                0 => {
                    instance.begin(time_s[0]);
                    instance.initialize().expect("a first sample");
                }
                row => instance.step(time_s[row - 1], time_s[row] - time_s[row - 1]).expect("a step"),
            }
            answers.push(instance.get(ANSWER).expect("an answer"));
        }
        answers
    }

    #[test]
    fn a_unit_answers_every_row_as_the_native_model() {
        let (time_s, input) = rows();
        for extensions in ["", EXTENSIONS] {
            let rows = Rows { time_s: &time_s, input: &input, load: None, temperature: None };
            let native = rows.answer(&model(extensions).extended().expect("a model")).expect("finite");
            assert_eq!(go(&mut instance(extensions, Direction::Forward), (&time_s, &input), 0), native);
        }
    }

    #[test]
    fn an_inverse_answers_every_period_as_the_native_one() {
        let (time_s, wanted): (Vec<f64>, Vec<f64>) = (0..300)
            .map(|row| (PERIOD_S * f64::from(row), 60.0 + 40.0 * (0.05 * f64::from(row)).sin()))
            .unzip();
        let file = model(EXTENSIONS);
        let limits = file.parameters.input();
        let inverse: ExtendedInverse<f64, PLAYS, DEAD_ZONES> =
            ExtendedInverse::try_new(&file.parameters, &file.acting(), PERIOD_S, limits).expect("an inverse");
        let mut state = inverse.rest_state();
        let step =
            |wanted: &f64| inverse.step(&mut state, *wanted, &Surroundings::default()).expect("finite");
        let native: Vec<f64> = wanted.iter().map(step).collect();
        let direction = Direction::Inverse { period_s: PERIOD_S };
        let mut unit = instance(EXTENSIONS, direction);
        assert_eq!(go(&mut unit, (&time_s, &wanted), 0), native);
        let before = unit.state.clone();
        let message = unit.step(3.0, 0.015).expect_err("refused");
        assert!(message.contains("no multiple of the inverse's period, 0.01 s"), "{message}");
        assert_eq!(unit.state, before);
        // Two periods are two samples of what is wanted.
        let mut twin = instance(EXTENSIONS, direction);
        twin.state = before;
        unit.step(3.0, 2.0 * PERIOD_S).expect("a step");
        twin.step(3.0, PERIOD_S).expect("a step");
        twin.step(3.0 + PERIOD_S, PERIOD_S).expect("a step");
        assert_eq!(unit.get(ANSWER), twin.get(ANSWER));
    }

    #[test]
    fn a_state_that_went_through_bytes_goes_on_bit_for_bit() {
        let (time_s, input) = rows();
        for direction in [Direction::Forward, Direction::Inverse { period_s: PERIOD_S }] {
            let equal: Vec<f64> = (0..600).map(|row| PERIOD_S * f64::from(row)).collect();
            let time_s = if direction == Direction::Forward { &time_s } else { &equal };
            let wanted: Vec<f64> = input.iter().map(|bar| 18.0 * bar).collect();
            let drive = if direction == Direction::Forward { &input } else { &wanted };
            for file in [model(""), model(EXTENSIONS), with_many_plays(""), with_many_plays(EXTENSIONS)] {
                let mut whole = instance_of(file.clone(), direction);
                let answers = go(&mut whole, (time_s, drive), 0);
                let mut first = instance_of(file.clone(), direction);
                go(&mut first, (&time_s[..300], &drive[..300]), 0);
                let bytes = first.serialized(&first.state).expect("bytes");
                let mut second = instance_of(file.clone(), direction);
                second.state = second.deserialized(&bytes).expect("a state");
                assert_eq!(second.state, first.state);
                assert_eq!(go(&mut second, (time_s, drive), 300), answers[300..]);
                assert_eq!(second.state, whole.state);
                // Of another unit, cut off, or with more than a state.
                let other = instance("[extensions.transport_delay]\ndelay_s = 0.02\n", direction);
                assert!(other.deserialized(&bytes).expect_err("refused").contains("another unit"));
                assert!(first.deserialized(&bytes[..bytes.len() - 1]).is_err());
                let more = [&bytes[..], &[0]].concat();
                assert!(first.deserialized(&more).expect_err("refused").contains("1 too many"));
            }
        }
    }

    #[test]
    fn what_is_no_input_and_no_number_is_refused() {
        let mut unit = instance(EXTENSIONS, Direction::Forward);
        assert!(unit.set(ANSWER, 1.0).expect_err("refused").contains("is an output"));
        assert!(unit.set(DRIVE, f64::NAN).expect_err("refused").contains("no finite number"));
        assert!(unit.set(9, 1.0).expect_err("refused").contains("no variable 9"));
        assert_eq!(unit.get(LOAD), Ok(20.0)); // N: the reference
        unit.begin(0.0);
        unit.initialize().expect("a first sample");
        let before = unit.state.clone();
        for step_s in [0.0, -1.0, f64::NAN, 1e-10] {
            unit.step(0.0, step_s).expect_err("refused");
            assert_eq!(unit.state, before, "{step_s}");
        }
    }
}
