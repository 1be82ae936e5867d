//! A model as a header and a source of C99: no allocation, no other file, `double` everywhere.
//!
//! # Design
//! The source says the model's equations in their plain form: every play keeps its own output, all
//! of them are looped over, the dead zones are a curve of straight lines. One state serves both
//! directions: the inverse moves it to the input that it answers with, as the muscle will be. It
//! solves for what drives the plays exactly: their sum over that is straight between the points
//! where a play begins to be driven, at most as many as there are plays.
//!
//! # Accuracy
//! The native model keeps the plays by their turning points, and takes `tanh` of `libm`: answers
//! differ by roundings, by less than 1e-12 of the range (`host/mgpi/tests/export.rs`).
//!
//! # Limits
//! Effects beside hysteresis are not written. Models of two envelopes (agpi, egpi) are written
//! forward only.

use std::fmt::Write;

use model_core::ExtensionParameters;
use model_core::dead_zone::{DeadZoneParameters, DeadZones};
use model_core::envelope::{EnvelopeParameters, PiecewiseLinearParameters, TanhParameters};
use model_core::play::PlayParameters;
use recording::model::{DEAD_ZONES, HostParameters};
use recording::model_file::ModelFile;
use thiserror::Error;

use crate::name::{self, NoName};

/// Why a model is not written.
#[derive(Debug, Error, PartialEq)]
pub enum NotExported {
    /// The name is not an identifier of C.
    #[error(transparent)]
    Name(#[from] NoName),
    /// The model is extended.
    #[error(
        "the model is extended by {0}, which C sources do not have; --operator-only writes its hysteresis alone"
    )]
    Extended(String),
}

/// A header and a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sources {
    /// `NAME.h`.
    pub header: String,
    /// `NAME.c`.
    pub source: String,
}

impl Sources {
    /// What they have.
    pub fn in_words(&self) -> &'static str {
        if self.header.contains("_inverse(") { "model and inverse" } else { "the model, without an inverse" }
    }
}

/// Writes a model in C under a name. `operator_only`: without what it is extended by.
///
/// # Errors
/// The name is not an identifier of C; the model is extended.
pub fn sources(model: &ModelFile, name: &str, operator_only: bool) -> Result<Sources, NotExported> {
    name::check(name)?;
    if model.acting() != ExtensionParameters::default() && !operator_only {
        return Err(NotExported::Extended(model.causes().join(", ")));
    }
    let text = Text { model, name, upper: name.to_uppercase() };
    Ok(Sources { header: text.header(), source: text.source() })
}

/// What both files are made of.
struct Text<'a> {
    model: &'a ModelFile,
    name: &'a str,
    upper: String,
}

impl Text<'_> {
    fn plays(&self) -> &PlayParameters<f64, { recording::model::PLAYS }> {
        match &self.model.parameters {
            HostParameters::Cascade(cascade) => &cascade.plays,
            HostParameters::Agpi(agpi) => &agpi.plays,
            HostParameters::Egpi(egpi) => &egpi.agpi.plays,
        }
    }

    fn has_inverse(&self) -> bool {
        matches!(self.model.parameters, HostParameters::Cascade(_))
    }

    /// What it is and where it comes from, as a comment.
    fn about(&self) -> String {
        let ModelFile { input, output, parameters, identification, .. } = self.model;
        let mut about = format!(
            "/* {}: {} over {}, a model of kind {}, written by {}.\n",
            self.name,
            output.name,
            input.name,
            parameters.kind(),
            recording::TOOL
        );
        if let Some(identification) = identification {
            // A name of a file may hold what ends a comment.
            let file = identification.recording.file.replace("*/", "* /");
            let _ =
                writeln!(about, " * Identified from {file}, SHA-256 {}.", identification.recording.sha256);
        }
        about + " */\n"
    }

    fn header(&self) -> String {
        let Self { model, name, upper, .. } = self;
        let (low, high) = model.parameters.input();
        let (input, output) = (model.input.unit, model.output.unit);
        let count = self.plays().thresholds.len().max(1);
        let about = self.about();
        let two_envelopes = if self.has_inverse() {
            String::new()
        } else {
            "    double input; /* the last one */\n    double output; /* the last one, without what has no memory */\n"
                .to_owned()
        };
        let inverse = if self.has_inverse() {
            format!(
                "\n/* One sample of the inverse: the input ({input}), within the two above, that brings the output to `wanted`\n \
                 * ({output}), or as near as they allow; the muscle is then taken to be there. Not a number where `wanted` is\n \
                 * none; the state is then as it was. */\n\
                 double {name}_inverse({name}_state *state, double wanted);\n"
            )
        } else {
            String::new()
        };
        format!(
            "{about}#ifndef {upper}_H\n#define {upper}_H\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n\
             #define {upper}_PLAYS {count}\n\
             /* The inputs that the model is valid for. Unit: {input}. */\n\
             #define {upper}_INPUT_MIN {low:?}\n#define {upper}_INPUT_MAX {high:?}\n\n\
             /* What the muscle remembers. */\n\
             typedef struct {{\n    double plays[{upper}_PLAYS];\n{two_envelopes}}} {name}_state;\n\n\
             /* A muscle at rest at the lowest input. */\nvoid {name}_rest({name}_state *state);\n\n\
             /* One sample: the output ({output}) for an input ({input}). Inputs outside the two above are extrapolated, by at\n \
             * most their span. NaN for an input that is infinite or NaN; the state does not change then. */\n\
             double {name}_step({name}_state *state, double input);\n{inverse}\n\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
        )
    }

    fn source(&self) -> String {
        let Self { name, upper, .. } = self;
        let PlayParameters { q, thresholds, weights } = self.plays();
        let about = self.about();
        let mut source = format!(
            "{about}#include \"{name}.h\"\n\n#include <math.h>\n\n\
             static const double THRESHOLDS[{upper}_PLAYS] = {{{}}};\n\
             static const double WEIGHTS[{upper}_PLAYS] = {{{}}};\n\
             static const double Q = {q:?};\n\n",
            // A model without plays has one that adds nothing.
            list(if thresholds.is_empty() { &[1.0] } else { thresholds }),
            list(if weights.is_empty() { &[0.0] } else { weights }),
        );
        source += LIMIT;
        match &self.model.parameters {
            HostParameters::Cascade(cascade) => {
                let has_curve = matches!(cascade.envelope, EnvelopeParameters::PiecewiseLinear(_))
                    || cascade.dead_zones.thresholds.len() > 1;
                if has_curve {
                    source += CURVE;
                    source += CURVE_BACK;
                }
                source += &envelope("envelope", &cascade.envelope, true);
                source += &dead_zones(&cascade.dead_zones);
                source += &self.filled(CASCADE);
                let preconditioned = if cascade.preconditioned { PRECONDITIONED } else { "" };
                source += &self.filled(REST).replace("PRECONDITIONED", &self.filled(preconditioned));
                source += &self.filled(INVERSE);
            }
            HostParameters::Agpi(agpi) => {
                source += &self.two_envelopes((&agpi.rising, &agpi.falling), agpi.preconditioned);
                source += &self.filled(STEP).replace("ANSWER", "state->output");
            }
            HostParameters::Egpi(egpi) => {
                let agpi = &egpi.agpi;
                source += &self.two_envelopes((&agpi.rising, &agpi.falling), agpi.preconditioned);
                let [first, second, third] = egpi.memoryless.rises;
                let added = self.filled(ADDED).replace("FIRST", &format!("{first:?}"));
                source +=
                    &added.replace("SECOND", &format!("{second:?}")).replace("THIRD", &format!("{third:?}"));
                source += &self.filled(STEP).replace("ANSWER", "state->output + added(input)");
            }
        }
        source
    }

    fn two_envelopes(
        &self,
        (rising, falling): (&EnvelopeParameters<f64>, &EnvelopeParameters<f64>),
        preconditioned: bool,
    ) -> String {
        let (gain, offset) = match &self.model.parameters {
            HostParameters::Agpi(agpi) => (agpi.gain, agpi.offset),
            HostParameters::Egpi(egpi) => (egpi.agpi.gain, egpi.agpi.offset),
            HostParameters::Cascade(_) => (1.0, 0.0),
        };
        let is_bent =
            |envelope: &EnvelopeParameters<f64>| matches!(envelope, EnvelopeParameters::PiecewiseLinear(_));
        let curve = if is_bent(rising) || is_bent(falling) { CURVE } else { "" };
        let rest = if preconditioned { TWO_PRECONDITIONED } else { "" };
        let body = self.filled(TWO_ENVELOPES).replace("PRECONDITIONED", &self.filled(rest));
        let body = body.replace("GAIN", &format!("{gain:?}")).replace("OFFSET", &format!("{offset:?}"));
        [curve, &envelope("rising", rising, false), &envelope("falling", falling, false), &body].concat()
    }

    fn filled(&self, template: &str) -> String {
        template.replace("NAME", &self.upper).replace("name", self.name)
    }
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ")
}

/// The functions of an envelope: what drives the plays at an input, and back.
fn envelope(of: &str, parameters: &EnvelopeParameters<f64>, back: bool) -> String {
    let back_text = |text: &str| if back { text.to_owned() } else { String::new() };
    match parameters {
        EnvelopeParameters::Identity => {
            format!("static double {of}(double x)\n{{\n    return x;\n}}\n\n")
                + &back_text("static double envelope_back(double v)\n{\n    return v;\n}\n\n")
        }
        EnvelopeParameters::Tanh(TanhParameters { c0, c1, c2, c3 }) => {
            // As far inside the ends of tanh as the native one is.
            let margin = 4.0 * f64::EPSILON * (c0 + c3.abs());
            let (low, high) = (c3 - c0 + margin, c3 + c0 - margin);
            format!(
                "static double {of}(double x)\n{{\n    \
                 return limited({c0:?} * tanh({c1:?} * x + {c2:?}) + {c3:?}, {low:?}, {high:?});\n}}\n\n"
            ) + &back_text(&format!(
                "static double envelope_back(double v)\n{{\n    const double t = limited(v, {low:?}, {high:?});\n    \
                 return (0.5 * log(({:?} + t) / ({:?} - t)) - {c2:?}) / {c1:?};\n}}\n\n",
                c0 - c3,
                c0 + c3
            ))
        }
        EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters { inputs, values }) => {
            let places = inputs.len() - 1;
            let pairs = inputs.windows(2).zip(values.windows(2));
            let slopes: Vec<f64> = pairs.map(|(x, v)| (v[1] - v[0]) / (x[1] - x[0])).collect();
            curve(of, (&inputs[..places], &values[..places], &slopes), back)
        }
    }
}

/// The functions of a curve of straight lines, which begin at points and go on beyond the last.
fn curve(of: &str, (x, y, slopes): (&[f64], &[f64], &[f64]), back: bool) -> String {
    let (upper, count) = (of.to_uppercase(), x.len());
    let tables = format!(
        "static const double {upper}_X[{count}] = {{{}}};\nstatic const double {upper}_Y[{count}] = {{{}}};\n\
         static const double {upper}_SLOPES[{count}] = {{{}}};\n\n",
        list(x),
        list(y),
        list(slopes)
    );
    let forward = format!(
        "static double {of}(double x)\n{{\n    return on_curve({count}, {upper}_X, {upper}_Y, {upper}_SLOPES, x);\n}}\n\n"
    );
    let backward = if back {
        format!(
            "static double {of}_back(double y)\n{{\n    return back_on_curve({count}, {upper}_X, {upper}_Y, {upper}_SLOPES, y);\n}}\n\n"
        )
    } else {
        String::new()
    };
    tables + &forward + &backward
}

/// The functions of the dead zones: the output at what the plays come to, and back.
fn dead_zones(parameters: &DeadZoneParameters<f64, DEAD_ZONES>) -> String {
    let DeadZoneParameters { thresholds, weights, offset } = parameters;
    if let [gain] = weights[..] {
        return format!(
            "static double dead_zones(double u)\n{{\n    return {gain:?} * u + {offset:?};\n}}\n\n\
             static double dead_zones_back(double y)\n{{\n    return (y - {offset:?}) / {gain:?};\n}}\n\n"
        );
    }
    // Of the thresholds below 0 each ends a slope, of the others each begins one.
    let slope_at = |place: usize| -> f64 {
        let zero = thresholds.iter().position(|threshold| *threshold == 0.0).unwrap_or(0);
        match place < zero {
            true => weights[place + 1..=zero].iter().sum(),
            false => weights[zero..=place].iter().sum(),
        }
    };
    let stage = DeadZones::try_new(parameters);
    let value = |u: &f64| stage.as_ref().map_or(f64::NAN, |stage| stage.value(*u));
    let (mut x, mut y) = (thresholds.to_vec(), thresholds.iter().map(value).collect::<Vec<f64>>());
    let mut slopes: Vec<f64> = (0..thresholds.len()).map(slope_at).collect();
    if let Some(zero) = thresholds.iter().position(|threshold| *threshold == 0.0).filter(|zero| *zero > 0) {
        // The line below the lowest threshold has no beginning: a point of it stands for one.
        let below: f64 = weights[..=zero].iter().sum();
        x.insert(0, thresholds[0] - 1.0);
        y.insert(0, y[0] - below);
        slopes.insert(0, below);
    }
    curve("dead_zones", (&x, &y, &slopes), true)
}

const LIMIT: &str = "\
static double limited(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

";

const CURVE: &str = "\
/* A curve of straight lines: the value at x. */
static double on_curve(int count, const double *xs, const double *ys, const double *slopes, double x)
{
    int place = count - 1;
    while (place > 0 && x < xs[place]) {
        place--;
    }
    return ys[place] + slopes[place] * (x - xs[place]);
}

";

const CURVE_BACK: &str = "\
/* The same backward: where it has a value. */
static double back_on_curve(int count, const double *xs, const double *ys, const double *slopes, double y)
{
    int place = count - 1;
    while (place > 0 && y < ys[place]) {
        place--;
    }
    return xs[place] + (y - ys[place]) / slopes[place];
}

";

const CASCADE: &str = "\
/* Moves the plays to v; what they come to together. */
static double drive(name_state *state, double v)
{
    double u = Q * v;
    int i;
    for (i = 0; i < NAME_PLAYS; i++) {
        state->plays[i] = limited(state->plays[i], v - THRESHOLDS[i], v + THRESHOLDS[i]);
        u += WEIGHTS[i] * state->plays[i];
    }
    return u;
}

double name_step(name_state *state, double input)
{
    const double span = NAME_INPUT_MAX - NAME_INPUT_MIN;
    if (!isfinite(input)) {
        return NAN;
    }
    return dead_zones(drive(state, envelope(limited(input, NAME_INPUT_MIN - span, NAME_INPUT_MAX + span))));
}

";

const REST: &str = "\
void name_rest(name_state *state)
{
    int i;
    for (i = 0; i < NAME_PLAYS; i++) {
        state->plays[i] = 0.0;
    }
    drive(state, envelope(NAME_INPUT_MIN));
PRECONDITIONED}

";

const PRECONDITIONED: &str = "    drive(state, envelope(NAME_INPUT_MAX));
    drive(state, envelope(NAME_INPUT_MIN));
";

const INVERSE: &str = "\
/* What the plays come to at v, from where they are. */
static double driven(const name_state *state, double v)
{
    double u = Q * v;
    int i;
    for (i = 0; i < NAME_PLAYS; i++) {
        u += WEIGHTS[i] * limited(state->plays[i], v - THRESHOLDS[i], v + THRESHOLDS[i]);
    }
    return u;
}

/* The input of the plays, between two ends, for which their sum is u; the nearer end if u is out of reach. */
static double solved(const name_state *state, double u, double low, double high)
{
    double u_low = driven(state, low);
    double u_high = driven(state, high);
    int i;
    int side;
    if (u <= u_low) {
        return low;
    }
    if (u >= u_high) {
        return high;
    }
    /* Their sum is straight between the points where one of them begins or ceases to be driven: the two that u lies
       between. */
    for (side = -1; side <= 1; side += 2) {
        for (i = 0; i < NAME_PLAYS; i++) {
            const double bend = state->plays[i] + side * THRESHOLDS[i];
            if (bend > low && bend < high) {
                const double at = driven(state, bend);
                if (at <= u) {
                    low = bend;
                    u_low = at;
                } else {
                    high = bend;
                    u_high = at;
                }
            }
        }
    }
    return low + (u - u_low) * (high - low) / (u_high - u_low);
}

double name_inverse(name_state *state, double wanted)
{
    const double low = envelope(NAME_INPUT_MIN);
    const double high = envelope(NAME_INPUT_MAX);
    double v;
    if (!isfinite(wanted)) {
        return NAN;
    }
    v = solved(state, dead_zones_back(wanted), low, high);
    drive(state, v);
    if (v <= low) {
        return NAME_INPUT_MIN;
    }
    if (v >= high) {
        return NAME_INPUT_MAX;
    }
    return limited(envelope_back(v), NAME_INPUT_MIN, NAME_INPUT_MAX);
}
";

const TWO_ENVELOPES: &str = "\
/* Moves the plays up or down to v; the output. */
static double drive(name_state *state, double v, int rises)
{
    double u = Q * v;
    int i;
    for (i = 0; i < NAME_PLAYS; i++) {
        const double pushed = rises ? v - THRESHOLDS[i] : v + THRESHOLDS[i];
        if (rises ? pushed > state->plays[i] : pushed < state->plays[i]) {
            state->plays[i] = pushed;
        }
        u += WEIGHTS[i] * state->plays[i];
    }
    return GAIN * u + OFFSET;
}

void name_rest(name_state *state)
{
    int i;
    for (i = 0; i < NAME_PLAYS; i++) {
        state->plays[i] = 0.0;
    }
    state->input = NAME_INPUT_MIN;
    drive(state, falling(NAME_INPUT_MIN), 0);
    state->output = drive(state, rising(NAME_INPUT_MIN), 1);
PRECONDITIONED}

";

const TWO_PRECONDITIONED: &str = "    drive(state, rising(NAME_INPUT_MAX), 1);
    state->output = drive(state, falling(NAME_INPUT_MIN), 0);
";

/// A step; ANSWER is its output.
const STEP: &str = "\
double name_step(name_state *state, double input)
{
    if (!isfinite(input)) {
        return NAN;
    }
    if (input != state->input) {
        const int rises = input > state->input;
        state->output = drive(state, rises ? rising(input) : falling(input), rises);
        state->input = input;
    }
    return ANSWER;
}
";

const ADDED: &str = "\
/* What depends on the input alone. */
static double added(double input)
{
    const double t = limited((input - NAME_INPUT_MIN) / (NAME_INPUT_MAX - NAME_INPUT_MIN), 0.0, 1.0);
    const double left = 1.0 - t;
    const double last = t * t * t;
    const double middle = 3.0 * t * t * left;
    return FIRST * (last + middle + 3.0 * t * left * left) + SECOND * (last + middle) + THIRD * last;
}

";
