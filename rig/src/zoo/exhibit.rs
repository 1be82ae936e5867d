//! One plant of the zoo with its experiment, all by one seed: what it is, what is hidden in it, its
//! recording.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::{Value, json};

use super::clock::Clock;
use super::excitation::Excitation;
use super::family::Family;
use super::friction::Friction;
use super::law::Law;
use super::muscle::{Load, Muscle, Size};
use super::refit::Hysteresis;
use super::site::Sites;
use super::valve::ValveKind;
use super::visible::{Seen, Visible};
use crate::draw::{Draw, Stream};
use crate::effect::Effect;
use crate::effects::Effects;
use crate::plant::{Parts, Plant, SUBSTEP_S};
use crate::protocol::Protocol;
use crate::recording::Row;
use crate::scale::Scale;
use crate::sensor::{Resolution, Sensors};
use crate::truth::Truth;

/// The muscle that the sizes of the effects (`parameters.rs`) are meant for: its stroke, its force
/// by the data sheet, and the length of the protocol `rich`.
const RIG_STROKE_MM: f64 = 125.0;
const RIG_FORCE_N: f64 = 1500.0;
const RIG_DURATION_S: f64 = 120.0;

/// Which strengths are plainly visible, and which are just so.
const STRONG: (f64, f64) = (0.8, 1.25);
const WEAK: (f64, f64) = (0.25, 0.4);

/// Who draws what: each part of a plant has a stream of its own, so that hiding an effect changes
/// no other.
#[derive(Clone, Copy)]
enum Drawn {
    Family,
    Hidden,
    Valve,
    Size,
    Sites,
    Law,
    Excitation,
    Clock,
    Instants,
    Sensors,
    Channels,
}

impl Drawn {
    fn by(self, seed: u64) -> Draw {
        Draw::new(seed, Stream::Part(self as u64))
    }
}

/// Which columns are recorded beside time and contraction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Channels {
    /// The command.
    pub command: bool,
    /// The pressure.
    pub pressure: bool,
    /// The load.
    pub load: bool,
    /// The temperature.
    pub temperature: bool,
}

impl Channels {
    /// Both command and pressure in six of ten, the pressure alone in three, the command alone in
    /// one. What is hidden in load or temperature is recorded.
    fn drawn(draw: &mut Draw, hidden: &[Effect]) -> Self {
        let input = draw.index(10);
        let mut beside = |effect| draw.index(2) == 0 || hidden.contains(&effect);
        let (load, temperature) = (beside(Effect::Load), beside(Effect::Temperature));
        Self { command: input < 6 || input == 9, pressure: input < 9, load, temperature }
    }
}

/// A plant and its experiment.
#[derive(Debug, Clone)]
pub struct Exhibit {
    /// The seed that everything follows from.
    pub seed: u64,
    /// Law and friction.
    pub family: Family,
    /// What is hidden.
    pub hidden: Vec<Effect>,
    /// How strongly: near 1 is plainly visible, near 0.3 just so.
    pub strength: f64,
    /// The valve.
    pub valve: ValveKind,
    /// What pulls at the muscle.
    pub load: Load,
    /// What is commanded.
    pub excitation: Excitation,
    /// When rows are recorded.
    pub clock: Clock,
    /// What is recorded.
    pub channels: Channels,
}

/// A recording of an exhibit.
#[derive(Debug, Clone)]
pub struct Exhibited {
    /// The rows.
    pub rows: Vec<Row>,
    /// Which columns of them are handed on.
    pub channels: Channels,
}

/// What is true of a recording.
#[derive(Debug, Clone, Serialize)]
pub struct ExhibitTruth {
    /// The plant and its experiment, in words and numbers.
    pub plant: Value,
    /// What is hidden, with its parameters.
    pub hidden: Truth,
    /// How strongly.
    pub strength: f64,
    /// How much there is to see of each hidden effect.
    pub visible: Vec<Visible>,
    /// What the best rate-independent hysteresis leaves of the same plant without any effect, mm.
    pub misfit_mm: f64,
    /// What the sensor of the contraction is off by, mm.
    pub noise_mm: f64,
    /// What is true besides, and may be named: a sound regulator lags too, which a recording of its
    /// command can show.
    pub also_true: Vec<&'static str>,
}

impl Exhibit {
    /// The exhibit of a seed.
    pub fn of(seed: u64) -> Self {
        let mut draw = Drawn::Hidden.by(seed);
        let hidden = hidden(&mut draw);
        let (low, high) = [STRONG, WEAK][usize::from(hidden.len() == 1 && draw.index(2) == 1)];
        Self::with(seed, hidden, draw.log_uniform(low, high))
    }

    /// The exhibit of a seed with nothing hidden.
    pub fn sound(seed: u64) -> Self {
        Self::with(seed, Vec::new(), 1.0)
    }

    /// The exhibit of a seed with this hidden in it.
    pub fn with(seed: u64, hidden: Vec<Effect>, strength: f64) -> Self {
        let mut family = Drawn::Family.by(seed);
        let mut valve = Drawn::Valve.by(seed);
        Self {
            seed,
            family: Family {
                law: Law::ALL[family.index(Law::ALL.len())],
                friction: Friction::ALL[family.index(Friction::ALL.len())],
            },
            valve: ValveKind::ALL[valve.index(3)],
            load: Load::ALL[Drawn::Size.by(seed).index(3)],
            excitation: Excitation::drawn(&mut Drawn::Excitation.by(seed)),
            clock: Clock::drawn(&mut Drawn::Clock.by(seed)),
            channels: Channels::drawn(&mut Drawn::Channels.by(seed), &hidden),
            hidden,
            strength,
        }
    }

    /// Whether what is hidden is plainly visible, where the experiment shows it at all.
    pub fn is_strong(&self) -> bool {
        self.strength > 0.6
    }

    /// Its recording.
    pub fn recording(&self) -> Exhibited {
        Exhibited { rows: self.rows(&self.hidden, true).0, channels: self.channels }
    }

    /// What is true of the recording.
    pub fn truth(&self) -> ExhibitTruth {
        let (with, plant) = self.rows(&self.hidden, false);
        let sound = if self.hidden.is_empty() { with.clone() } else { self.rows(&[], false).0 };
        let without = |effect: Effect| {
            let rest: Vec<_> = self.hidden.iter().copied().filter(|other| *other != effect).collect();
            if rest.is_empty() { sound.clone() } else { self.rows(&rest, false).0 }
        };
        let visible = self.hidden.iter().map(|effect| {
            let at_valve = is_valve(*effect) && self.channels.pressure;
            let seen = |rows: &[Row]| self.seen(rows, at_valve);
            let unit = if at_valve { "bar" } else { "mm" };
            let mut visible = Visible::of(*effect, unit, &seen(&with), &seen(&without(*effect)));
            // The valve is seen between its command and its pressure.
            visible.examinable &= !at_valve || self.channels.command;
            visible
        });
        let seen = self.seen(&sound, false);
        ExhibitTruth {
            plant: self.words(),
            hidden: plant.truth(),
            strength: self.strength,
            visible: visible.collect(),
            misfit_mm: Hysteresis::of(&seen.input).rest(&seen.output),
            noise_mm: seen.noise,
            also_true: if self.channels.command { vec![Effect::ValveLag.name()] } else { Vec::new() },
        }
    }

    /// What a model of the muscle, or of the valve, is made from and of.
    fn seen(&self, rows: &[Row], at_valve: bool) -> Seen {
        let column = |of: fn(&Row) -> f64| rows.iter().map(of).collect::<Vec<_>>();
        let (command, pressure) = (|row: &Row| row.command_bar, |row: &Row| row.measured.pressure_bar);
        let (of_pressure, of_contraction) = self.resolutions(self.muscle(&[]).0.stroke_mm());
        if at_valve {
            Seen { input: column(command), output: column(pressure), noise: of_pressure.deviation() }
        } else {
            let input = column(if self.channels.pressure { pressure } else { command });
            let output = column(|row| row.measured.contraction_mm);
            Seen { input, output, noise: of_contraction.deviation() }
        }
    }

    fn words(&self) -> Value {
        json!({
            "seed": self.seed,
            "law": self.family.law.name(),
            "friction": self.family.friction.name(),
            "part": self.family.part().name(),
            "valve": self.valve.name(),
            "load": self.load.name(),
            "excitation": self.excitation.name(),
            "rate_hz": self.clock.rate_hz,
            "duration_s": self.clock.duration_s,
            "jitter": self.clock.jitter,
            "lost": self.clock.lost,
            "stroke_mm": self.muscle(&[]).0.stroke_mm(),
        })
    }

    /// The muscle, and the effects that are hidden, in its size.
    fn muscle(&self, hidden: &[Effect]) -> (Muscle, Effects, Scale, Size) {
        let mut of_size = Drawn::Size.by(self.seed);
        of_size.index(3);
        let size = Size::drawn(&mut of_size, self.load);
        let sites = Sites::drawn(&mut Drawn::Sites.by(self.seed));
        let Family { law, friction } = self.family;
        let (mut effects, mut scale) = (Effects::default(), Scale::default());
        let muscle =
            Muscle::at_rest((law, friction), size, sites, &mut Drawn::Law.by(self.seed), |stroke_mm| {
                scale = Scale {
                    length: stroke_mm / RIG_STROKE_MM,
                    force: size.full_n / RIG_FORCE_N,
                    duration: self.clock.duration_s / RIG_DURATION_S,
                };
                effects = Effects::drawn(hidden, self.strength, self.seed).scaled(&scale);
                effects.clone()
            });
        (muscle, effects, scale, size)
    }

    /// Noise and steps of the sensors of pressure and contraction.
    fn resolutions(&self, stroke_mm: f64) -> (Resolution, Resolution) {
        let mut draw = Drawn::Sensors.by(self.seed);
        let mut resolution = |range: f64| {
            let noise = range * draw.log_uniform(5e-5, 1e-3);
            // A converter of 10 to 16 bit, or one that is finer than any noise.
            let bits = 10.0 + 2.0 * draw.index(5) as f64;
            Resolution { noise, step: if bits > 16.0 { 0.0 } else { range / bits.exp2() } }
        };
        (resolution(10.0), resolution(1.2 * stroke_mm))
    }

    /// The plant itself, at rest, with what is hidden in it: to be driven by somebody else.
    pub fn plant(&self, noise: bool) -> Plant {
        self.plant_with(&self.hidden, noise)
    }

    /// Contraction at 6 bar without friction, beyond that at 0 bar, mm.
    pub fn stroke_mm(&self) -> f64 {
        self.muscle(&[]).0.stroke_mm()
    }

    /// Force at 6 bar and no contraction, N.
    pub fn blocked_n(&self) -> f64 {
        self.muscle(&[]).3.full_n
    }

    /// The plant with this hidden.
    fn plant_with(&self, hidden: &[Effect], noise: bool) -> Plant {
        let (muscle, effects, scale, size) = self.muscle(hidden);
        let (pressure, contraction) = self.resolutions(muscle.stroke_mm());
        let mut of_valve = Drawn::Valve.by(self.seed);
        of_valve.index(3);
        Plant::assembled(Parts {
            valve: self.valve.drawn(&mut of_valve, &effects),
            effects,
            seed: self.seed,
            dead_load_n: size.weight_n,
            body: Box::new(muscle),
            sensors: if noise { Sensors::with(pressure, contraction, self.seed) } else { Sensors::ideal() },
            scale,
            volume_per_mm: 3.0 / size.length_mm,
            is_timed: true,
        })
    }

    /// The rows with this hidden, and the plant behind them.
    fn rows(&self, hidden: &[Effect], noise: bool) -> (Vec<Row>, Plant) {
        let mut plant = self.plant_with(hidden, noise);
        let mut draw = Drawn::Excitation.by(self.seed);
        let excitation = Excitation::drawn(&mut draw);
        let range_bar = draw.uniform(5.2, 6.0);
        let protocol = excitation.protocol(&mut draw, range_bar, self.clock.duration_s);
        let instants_s = self.clock.instants_s(&mut Drawn::Instants.by(self.seed));
        (
            instants_s
                .iter()
                .scan(0.0, |at_s, time_s| Some(row(&mut plant, &protocol, at_s, *time_s)))
                .collect(),
            plant,
        )
    }
}

/// Runs a plant to `time_s`, its command renewed at every step inside.
fn row(plant: &mut Plant, protocol: &Protocol, at_s: &mut f64, time_s: f64) -> Row {
    let steps = ((time_s - *at_s) / SUBSTEP_S).ceil().max(1.0);
    let (from_s, dt_s) = (*at_s, (time_s - *at_s) / steps);
    for step in 1..=steps as u64 {
        plant.run(protocol.command_bar(from_s + step as f64 * dt_s), dt_s);
    }
    *at_s = time_s;
    Row { time_s, command_bar: protocol.command_bar(time_s), measured: plant.measure() }.rounded()
}

/// Nothing in one of seven, one cause in half, two causes in a fifth, an outsider in the rest.
fn hidden(draw: &mut Draw) -> Vec<Effect> {
    let mut causes = Effect::causes().to_vec();
    let mut fast: Vec<_> = causes.iter().copied().filter(|cause| cause.is_fast()).collect();
    draw.shuffle(&mut causes);
    draw.shuffle(&mut fast);
    let mut hidden = match draw.index(28) {
        0..4 => Vec::new(),
        4..17 => vec![causes[0]],
        17..21 => {
            let second = causes[1..].iter().find(|second| !(second.is_fast() && causes[0].is_fast()));
            [causes[0]].into_iter().chain(second.copied()).collect()
        }
        21..23 => vec![fast[0], fast[1]],
        _ => vec![Effect::outsiders()[draw.index(Effect::outsiders().len())]],
    };
    hidden.sort();
    hidden
}

/// Whether it is seen between command and pressure.
fn is_valve(effect: Effect) -> bool {
    matches!(effect, Effect::ValveLag | Effect::ValveDeadband | Effect::SupplySaturation)
}

impl Exhibited {
    /// Writes the recording as CSV, with the columns that are recorded.
    ///
    /// # Errors
    /// `out` refuses.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let Channels { command, pressure, load, temperature } = self.channels;
        type Column = (&'static str, bool, fn(&Row) -> f64);
        let columns: [Column; 6] = [
            ("time_s", true, |row| row.time_s),
            ("command_bar", command, |row| row.command_bar),
            ("pressure_bar", pressure, |row| row.measured.pressure_bar),
            ("contraction_mm", true, |row| row.measured.contraction_mm),
            ("load_n", load, |row| row.measured.load_n),
            ("temperature_c", temperature, |row| row.measured.temperature_c),
        ];
        let recorded: Vec<_> = columns.into_iter().filter(|column| column.1).collect();
        let names: Vec<_> = recorded.iter().map(|column| column.0).collect();
        writeln!(out, "{}", names.join(","))?;
        for row in &self.rows {
            let fields: Vec<_> = recorded.iter().map(|column| (column.2)(row).to_string()).collect();
            writeln!(out, "{}", fields.join(","))?;
        }
        Ok(())
    }
}
