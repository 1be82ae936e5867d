//! The tracking controller of Fig. 10: inverse model as feed-forward, PID as feedback, one command.
//!
//! ```text
//! reference ─┬─▶ (smoother) ─▶ inverse of the extended model ─▶ feed-forward ─┐
//!            └─▶ delay ─▶ PID (◀─ contraction) ─▶ feedback ──────────────────┴─▶ + transfer ─▶ slew ─▶ limits ─▶ command
//! ```
//!
//! # In two halves
//! The feed-forward needs the reference only, and what surrounds the muscle; the feedback needs the
//! contraction. So a sample is [`Tracking::prepare`], which a board does as soon as it knows the
//! reference of its next tick, and [`Tracking::act`], which is all that is left to do once the
//! contraction is measured. [`Tracking::step`] is one after the other.
//!
//! # Extensions
//! The feed-forward compensates them ([`crate::extension`]); without any it is the inverse of the
//! operator, bit for bit. Load and temperature can be measured. With a delay the reference is given
//! ahead: what is asked for at a tick is due a delay later, and the feedback compares with what was
//! asked for a delay ago. With a mass the inverse follows a smoothed reference, which is given
//! ahead by the smoother's lag too: [`ExtensionParameters::preview_s`] says by how much in all.
//! Drift and tone are left to the feedback unless the parameters say otherwise.
//!
//! # Disturbances
//! With an observer ([`crate::observer`]) the PID's gains grow where the muscle is flatter, in the
//! mode of both: what feedback alone is asked for needs no model.
//!
//! # Changes of mode
//! Every change is bumpless: at the first sample of a new [`Mode`] the difference to the last
//! command is put into a transfer term that fades with the back-calculation time constant, and the
//! PID is reset. That holds without integral gain too, where the usual preset of the integral
//! cannot work.
//!
//! # Limits
//! The slew limit and the command limits, the upper of which is the supply if that is lower, act on
//! the sum; what they cut off flows back into the integral. A compensated valve remembers the
//! feed-forward within the command limits. The inverse remembers the feed-forward that it asked
//! for, not the total command, as in the paper: the feedback is a correction of the plant's
//! deviation from the model. The feedback sees reference and contraction limited to the model's
//! output range and a tenth of it on either side: a wild sample moves the integral no more than a
//! real one could.

use crate::adaptation::{Adapted, Adapter, Lesson};
use crate::error::{Check, InputError, ParameterError, finite_input};
use crate::extension::output::reach;
use crate::extension::preview::{Preview, PreviewLine};
use crate::extension::smoother::{Smoothed, Smoother};
use crate::extension::{ExtendedInverse, ExtendedInverseState, ExtensionParameters, Surroundings};
use crate::hysteresis::InverseHysteresis;
use crate::model::{InverseModel, ModelParameters};
use crate::observer::{Observed, Observer, ObserverParameters};
use crate::pid::{Pid, PidParameters, PidState};
use crate::range::Range;
use crate::real::Real;

/// Which parts of the controller act.
///
/// ```
/// use model_core::Mode;
///
/// assert_eq!(Mode::default(), Mode::Both);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// Feed-forward and feedback.
    #[default]
    Both,
    /// The inverse model alone.
    FeedforwardOnly,
    /// The PID alone.
    FeedbackOnly,
    /// The last command is held.
    Hold,
}

/// Raw parameters of the controller.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct TrackingParameters<T, const N: usize, const M: usize> {
    /// The muscle's model, input in bar, output in mm.
    pub model: ModelParameters<T, N, M>,
    /// What it does beside hysteresis.
    pub extensions: ExtensionParameters<T>,
    /// The feedback.
    pub pid: PidParameters<T>,
    /// What makes it as quick on every slope.
    pub observer: ObserverParameters<T>,
    /// Lowest command, also the one at the start. Unit: bar.
    pub command_min: T,
    /// Highest command. Unit: bar.
    pub command_max: T,
    /// Largest rate of change of the command. Unit: bar/s, above 0.
    pub slew_bar_per_s: T,
    /// Time from sample to sample. Unit: s, above 0.
    pub period_s: T,
}

/// What is measured at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured<T> {
    /// Unit: mm.
    pub contraction: T,
    /// Load and temperature, as far as there are sensors.
    pub surroundings: Surroundings<T>,
}

impl<T> From<T> for Measured<T> {
    /// The contraction alone.
    fn from(contraction: T) -> Self {
        Self { contraction, surroundings: Surroundings { load: None, temperature: None } }
    }
}

/// How far beyond the model's output range feedback still sees, as a share of the range.
const MARGIN: f64 = 0.1;

/// A validated tracking controller.
///
/// ```
/// use model_core::pid::PidParameters;
/// use model_core::{
///     ExtensionParameters, Hysteresis, Mgpi, Mode, ModelParameters, ObserverParameters, Tracking, TrackingParameters,
/// };
///
/// let parameters = model_core::paper::mgpi()?;
/// let muscle = Mgpi::try_new(&parameters)?;
/// let controller = Tracking::try_new(&TrackingParameters {
///     model: ModelParameters::Cascade(parameters),
///     extensions: ExtensionParameters::default(),
///     pid: PidParameters::paper(),
///     observer: ObserverParameters::default(),
///     command_min: 0.0,
///     command_max: 6.0,
///     slew_bar_per_s: 60.0,
///     period_s: 0.001,
/// })?;
/// let (mut state, mut plant) = (controller.rest_state(Mode::Both), muscle.rest_state());
/// let mut contraction = muscle.step(&mut plant, 0.0)?;
/// for _ in 0..200 {
///     let command = controller.step(&mut state, Mode::Both, 50.0, contraction)?.command;
///     contraction = muscle.step(&mut plant, command)?;
/// }
/// assert!((contraction - 50.0).abs() < 1.0); // mm
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking<T, const N: usize, const M: usize> {
    inverse: ExtendedInverse<T, N, M>,
    smoother: Option<Smoother<T>>,
    preview: Option<Preview<T>>,
    pid: Pid<T>,
    observer: Option<Observer<T>>,
    /// What the feedback sees of reference and contraction. Unit: mm.
    plausible: Range<T>,
    /// Largest change of the command in one period. Unit: bar.
    largest_change: T,
    /// What remains of the transfer term after one period. Unit: 1.
    transfer_decay: T,
}

/// What the controller remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingState<T, const N: usize> {
    inverse: ExtendedInverseState<T, N>,
    smoothed: Smoothed<T>,
    preview: PreviewLine<T>,
    pid: PidState<T>,
    /// None without an observer.
    observed: Option<Observed<T, N>>,
    /// What the observer multiplies the PID's gains by. Unit: 1.
    factor: T,
    /// Of the last sample. Unit: mm.
    contraction: T,
    /// That of the last sample; none before the first one.
    mode: Option<Mode>,
    /// That of the start.
    first_mode: Mode,
    /// Unit: bar.
    command: T,
    /// Unit: bar.
    transfer: T,
}

/// What a sample needs of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prepared<T> {
    /// What the inverse model asks for. Unit: bar.
    feedforward: T,
    /// What the feedback compares with. Unit: mm.
    due: T,
}

/// A sample's command and its parts. Unit: bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command<T> {
    /// To the valve, within the limits.
    pub command: T,
    /// What the inverse model asked for; 0 in a mode without feed-forward.
    pub feedforward: T,
    /// What the PID asked for; 0 in a mode without feedback.
    pub feedback: T,
    /// Whether a limit or the slew rate changed the command.
    pub limited: bool,
}

impl<T: Real, const N: usize, const M: usize> Tracking<T, N, M> {
    /// # Errors
    /// The first parameter that no controller can be made of.
    // Not inlined, like what it calls: what each needs of a board's stack is then not needed at
    // once.
    #[inline(never)]
    pub fn try_new(parameters: &TrackingParameters<T, N, M>) -> Result<Self, ParameterError> {
        let period = Check::new("period_s", "s").above(parameters.period_s, T::ZERO)?;
        let slew = Check::new("slew_bar_per_s", "bar/s").above(parameters.slew_bar_per_s, T::ZERO)?;
        let TrackingParameters { model, extensions, command_min, command_max, .. } = parameters;
        let inverse = ExtendedInverse::try_new(model, extensions, period, (*command_min, *command_max))?;
        let (low, high) = inverse.output_range();
        let margin = T::from_f64(MARGIN) * (high - low);
        Ok(Self {
            smoother: if extensions.has_mass() {
                Some(Smoother::new(period, reach((low, high))?))
            } else {
                None
            },
            preview: Preview::try_new(extensions.preview_s(period), period)?,
            inverse,
            plausible: Range::try_new(low - margin, high + margin, "output range", "mm")?,
            pid: Pid::try_new(&parameters.pid, period)?,
            observer: Observer::try_new(&parameters.observer, parameters.pid.ki, period, (low, high))?,
            largest_change: slew * period,
            transfer_decay: (-period / parameters.pid.tracking_time_s).exp(),
        })
    }

    /// The model's inverse.
    pub fn inverse(&self) -> &InverseModel<T, N, M> {
        self.inverse.operator()
    }

    /// What adapts its feed-forward: a few operations, made each time.
    pub fn adapter(&self) -> Adapter<T> {
        let inputs = self.inverse.input_range();
        Adapter::new(self.inverse.output_range(), (inputs.min(), inputs.max()))
    }

    /// What the inverse is to be asked for in the place of a reference (mm), by what was learnt
    /// ([`Adapter::asked`]). Unit: mm.
    pub fn asked(&self, adapted: &mut Adapted<T>, reference: T) -> T {
        self.adapter().asked(adapted, reference)
    }

    /// Learns from a sample that has just been acted on, and what was prepared for it.
    /// `is_trusted`: whether no limit has changed the command, and valve and sensors did what they
    /// were told, as far as the caller knows.
    pub fn learn(
        &self,
        state: &TrackingState<T, N>,
        prepared: &Prepared<T>,
        is_trusted: bool,
        adapted: &mut Adapted<T>,
    ) {
        let has_feedforward = matches!(state.mode, Some(Mode::Both | Mode::FeedforwardOnly));
        let (stands, inputs) =
            (self.inverse.stands(&state.inverse, prepared.feedforward), self.inverse.input_range());
        // At its ends the inverse answers less than it was asked for.
        let is_inside = stands.0 > inputs.min() && stands.0 < inputs.max();
        let lesson = Lesson {
            due: prepared.due,
            contraction: state.contraction,
            // What fades in after a change of mode is missing beside the feed-forward too.
            feedback: state.command - prepared.feedforward,
            stands,
            is_trusted: is_trusted && has_feedforward && is_inside,
        };
        self.adapter().learn(adapted, &lesson);
    }

    /// The state of a controller whose muscle is at rest, the valve at the lowest command.
    pub fn rest_state(&self, mode: Mode) -> TrackingState<T, N> {
        TrackingState {
            inverse: self.inverse.rest_state(),
            smoothed: Smoothed::default(),
            preview: PreviewLine::new(),
            pid: PidState::starting_at(T::ZERO),
            observed: self.observer.map(|_| Observed::resting(self.inverse().rest_state())),
            factor: T::ONE,
            contraction: T::ZERO,
            mode: None,
            first_mode: mode,
            command: self.inverse.limits().min(),
            transfer: T::ZERO,
        }
    }

    /// One sample: [`prepare`](Self::prepare), then [`act`](Self::act). `reference`, that is due
    /// after the delay: mm. `measured`, now: [`Measured`], or the contraction alone.
    ///
    /// # Errors
    /// A value that is not finite; the state, and so the last command, is then as it was.
    #[inline(always)]
    pub fn step(
        &self,
        state: &mut TrackingState<T, N>,
        mode: Mode,
        reference: T,
        measured: impl Into<Measured<T>>,
    ) -> Result<Command<T>, InputError> {
        let Measured { contraction, surroundings } = measured.into();
        let contraction = finite_input(contraction)?;
        let prepared = self.prepare(state, reference, &surroundings)?;
        self.act(state, mode, prepared, contraction)
    }

    /// The first half of a sample, once for each. `reference`, that is due after the delay: mm.
    ///
    /// # Errors
    /// A value that is not finite; the state is then as it was.
    #[inline(always)]
    pub fn prepare(
        &self,
        state: &mut TrackingState<T, N>,
        reference: T,
        surroundings: &Surroundings<T>,
    ) -> Result<Prepared<T>, InputError> {
        self.prepare_asked(state, (reference, reference), surroundings)
    }

    /// The same where the inverse is asked for something else than the reference, as
    /// [`Tracking::asked`] tells: what it is asked for, and the reference. Unit: mm.
    ///
    /// # Errors
    /// A value that is not finite; the state is then as it was.
    #[inline(always)]
    pub fn prepare_asked(
        &self,
        state: &mut TrackingState<T, N>,
        (asked, reference): (T, T),
        surroundings: &Surroundings<T>,
    ) -> Result<Prepared<T>, InputError> {
        // The inverse follows the reference in every mode, so that its memory is right when it is
        // needed.
        let feedforward = match &self.smoother {
            None => self.inverse.step(&mut state.inverse, asked, surroundings)?,
            Some(smoother) => self.smoothly(smoother, state, asked, surroundings)?,
        };
        let due = match &self.preview {
            Some(preview) => preview.due(&mut state.preview, reference),
            None => reference,
        };
        let due = self.plausible.limit(due);
        if let Some(observer) = &self.observer {
            self.observe(observer, state, due);
        }
        Ok(Prepared { feedforward, due })
    }

    /// The feed-forward to a smoothed reference. Not inlined, to avoid register spills where there
    /// is no mass.
    #[inline(never)]
    fn smoothly(
        &self,
        smoother: &Smoother<T>,
        state: &mut TrackingState<T, N>,
        reference: T,
        surroundings: &Surroundings<T>,
    ) -> Result<T, InputError> {
        let mut smoothed = state.smoothed;
        let wanted = smoother.step(&mut smoothed, finite_input(reference)?);
        let feedforward = self.inverse.step(&mut state.inverse, wanted, surroundings)?;
        state.smoothed = smoothed;
        Ok(feedforward)
    }

    /// Closes the observer's period. Not inlined, to avoid register spills where there is none.
    #[inline(never)]
    fn observe(&self, observer: &Observer<T>, state: &mut TrackingState<T, N>, due: T) {
        // Before the first sample there is nothing to be observed.
        if let (Some(observed), Some(_)) = (&mut state.observed, state.mode) {
            state.factor = observer.factor(observed, self.inverse.operator(), state.contraction, due);
        }
    }

    /// The second half of a sample. `prepared`: of this sample. `contraction`, now: mm.
    ///
    /// # Errors
    /// The contraction is not finite; the last command is then as it was.
    #[inline(always)]
    pub fn act(
        &self,
        state: &mut TrackingState<T, N>,
        mode: Mode,
        prepared: Prepared<T>,
        contraction: T,
    ) -> Result<Command<T>, InputError> {
        let Prepared { feedforward, due } = prepared;
        // What no muscle of this model does is no error to be integrated.
        let contraction = self.plausible.limit(finite_input(contraction)?);
        state.contraction = contraction;
        let seen = (due - contraction, contraction);
        Ok(if state.mode == Some(mode) {
            self.command(state, mode, feedforward, seen, |state, _| state.transfer * self.transfer_decay)
        } else {
            self.change_to(state, mode, feedforward, seen)
        })
    }

    /// The first sample of a mode.
    #[inline(always)]
    fn change_to(
        &self,
        state: &mut TrackingState<T, N>,
        mode: Mode,
        inverse: T,
        (error, contraction): (T, T),
    ) -> Command<T> {
        let starts = state.mode.unwrap_or(state.first_mode) == mode;
        state.mode = Some(mode);
        state.pid = PidState::starting_at(contraction);
        self.command(state, mode, inverse, (error, contraction), |state, sum| {
            if starts { T::ZERO } else { state.command - sum }
        })
    }

    /// What a mode does with the inverse's answer (bar), and error and contraction (mm).
    /// `transfer`: the transfer term, given the sum of feed-forward and feedback.
    #[inline(always)]
    fn command(
        &self,
        state: &mut TrackingState<T, N>,
        mode: Mode,
        inverse: T,
        seen: (T, T),
        transfer: impl Fn(&TrackingState<T, N>, T) -> T,
    ) -> Command<T> {
        match mode {
            Mode::Both => self.add_up::<true>(state, inverse, (state.factor, seen), transfer),
            Mode::FeedforwardOnly => self.add_up::<false>(state, inverse, (T::ONE, seen), transfer),
            Mode::FeedbackOnly => self.add_up::<true>(state, T::ZERO, (T::ONE, seen), transfer),
            Mode::Hold => {
                state.transfer = T::ZERO;
                Command { command: state.command, feedforward: T::ZERO, feedback: T::ZERO, limited: false }
            }
        }
    }

    /// The command from its parts, within slew and limits. `FEEDBACK`: whether the PID acts, its
    /// gains times the factor.
    #[inline(always)]
    fn add_up<const FEEDBACK: bool>(
        &self,
        state: &mut TrackingState<T, N>,
        feedforward: T,
        (factor, (error, contraction)): (T, (T, T)),
        transfer: impl Fn(&TrackingState<T, N>, T) -> T,
    ) -> Command<T> {
        let error = factor * error;
        let feedback = if FEEDBACK {
            self.pid.scaled_output(&mut state.pid, factor, error, contraction)
        } else {
            T::ZERO
        };
        let sum = feedforward + feedback;
        state.transfer = transfer(state, sum);
        let asked = sum + state.transfer;
        let command = self.inverse.limits().step_toward(state.command, asked, self.largest_change);
        state.command = command;
        let excess = command - asked;
        if FEEDBACK {
            self.pid.settle(&mut state.pid, error, excess);
        }
        Command { command, feedforward, feedback, limited: excess != T::ZERO }
    }
}
