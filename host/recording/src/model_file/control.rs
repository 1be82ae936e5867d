//! What a model file says for the control of its muscle: what the recording shows of time and noise
//! (`[recorded]`), and the feedback that was tuned from it (`[tuning]`).
//!
//! Both tables may be missing: files of earlier versions, and models from a paper, have none.

use model_core::extension::{TransportDelayParameters, ValveLagParameters};
use model_core::pid::PidParameters;
use model_core::{ExtensionParameters, ObserverParameters};
use toml::{Table, Value};

use super::names::Names;
use super::scale::Scale;
use super::section::{KeyError, Section};
use crate::valve_order::FLAT;

const RECORDED: &str = "recorded";
const SECOND: [&str; 2] = ["valve_second_order_least", "valve_second_order_most"];
const SPLIT: [&str; 2] = ["viscosity_least", "viscosity_late_s"];
const TUNING: &str = "tuning";

/// How much later than predicted something came, as a mean over its movements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Late {
    /// Unit: s; negative where it came earlier.
    pub mean_s: f64,
    /// Its standard error. Unit: s.
    pub error_s: f64,
}

/// What the recording of a model shows beside the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recorded {
    /// Median time from row to row. Unit: s.
    pub step_s: f64,
    /// Standard deviation of the output's noise. Output unit.
    pub noise: f64,
    /// How many times steeper or flatter than the model nineteen of twenty stretches of it are.
    pub steeper: f64,
    /// The output behind what the model answers.
    pub late: Late,
    /// How much of the model's viscosity may be a dead time; None where nothing of it may.
    pub split: Option<Split>,
    /// The valve; None where not both command and pressure were recorded.
    pub valve: Option<SeenValve>,
}

/// What of a viscosity a recording does not tell from a dead time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// The least share of the model's viscosity that is not excluded. Unit: 1.
    pub share: f64,
    /// The dead time that stands in the place of the rest. Unit: s.
    pub late_s: f64,
}

/// What a recording shows of a valve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenValve {
    /// The pressure behind what the model's valve answers to the command, or behind the command
    /// where the model has no lag.
    pub late: Late,
    /// Of which order it may be: the least and the largest share q of
    /// [`valve_order`](crate::valve_order).
    pub shares: (f64, f64),
}

/// The feedback that goes with a model, and what it promises.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// Proportional gain. Unit: input unit/output unit.
    pub kp: f64,
    /// Integral gain. Unit: input unit/(output unit s).
    pub ki: f64,
    /// Derivative gain. Unit: input unit s/output unit.
    pub kd: f64,
    /// Time constant of the derivative's filter. Unit: s.
    pub derivative_filter_s: f64,
    /// Time constant of the anti-windup. Unit: s.
    pub tracking_time_s: f64,
    /// How these gains grow where the muscle is flatter; None where they do not.
    pub observer: Option<Observer>,
    /// Largest rate of change of the command that the valve can follow; None where the valve is not
    /// known. Unit: input unit/s.
    pub slew_per_s: Option<f64>,
    /// Lag of the valve that the inverse leads, where the model has none. Unit: s.
    pub lag_s: f64,
    /// Dead time, beside that of the model, by which the reference is given ahead. Unit: s.
    pub delay_s: f64,
    /// Largest sensitivity over all slopes of the loop. Unit: 1.
    pub maximum_sensitivity: f64,
    /// The least gain margin over them. Unit: 1.
    pub gain_margin: f64,
    /// The least phase margin over them. Unit: degree.
    pub phase_margin_deg: f64,
    /// Up to where disturbances are lessened, at the least and at the most. Unit: Hz.
    pub bandwidth_hz: (f64, f64),
    /// Up to where repetitions may be learnt from. Unit: Hz.
    pub learning_hz: f64,
    /// What limits it, in a word.
    pub limited_by: String,
    /// Time from tick to tick that it was tuned for. Unit: s.
    pub period_s: f64,
}

/// The disturbance observer of a tuning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// The slope that the gains are for. Unit: output unit/input unit.
    pub slope: f64,
    /// How many times as large they may become. Unit: 1.
    pub reach: f64,
    /// Moves and errors within it are noise. Output unit.
    pub band: f64,
}

impl Recorded {
    pub(super) fn scaled(&self, scale: Scale) -> Self {
        Self { noise: self.noise * scale.output, ..*self }
    }

    pub(super) fn write(&self, names: &Names, top: &mut Table) {
        let mut table = Table::new();
        let mut put = |key: String, value: f64| table.insert(key, value.into());
        put("step_s".into(), self.step_s);
        put(format!("noise_{}", names.output.suffix()), self.noise);
        put("steeper".into(), self.steeper);
        for (name, late) in [("late", Some(self.late)), ("valve_late", self.valve.map(|valve| valve.late))] {
            if let Some(late) = late {
                put(format!("{name}_s"), late.mean_s);
                put(format!("{name}_error_s"), late.error_s);
            }
        }
        if let Some(Split { share, late_s }) = self.split {
            put(SPLIT[0].into(), share);
            put(SPLIT[1].into(), late_s);
        }
        if let Some(SeenValve { shares: (low, high), .. }) = self.valve {
            put(SECOND[0].into(), low);
            put(SECOND[1].into(), high);
        }
        top.insert(RECORDED.into(), Value::Table(table));
    }

    pub(super) fn read(top: &mut Section, names: &Names) -> Result<Option<Self>, KeyError> {
        let Some(mut section) = top.optional_section(RECORDED)? else { return Ok(None) };
        let late = |section: &mut Section, name: &str| -> Result<Late, KeyError> {
            Ok(Late {
                mean_s: section.number(&format!("{name}_s"))?,
                error_s: not_negative(section, &format!("{name}_error_s"))?,
            })
        };
        let recorded = Self {
            step_s: positive(&mut section, "step_s")?,
            noise: not_negative(&mut section, &format!("noise_{}", names.output.suffix()))?,
            steeper: positive(&mut section, "steeper")?,
            late: late(&mut section, "late")?,
            split: if section.has(SPLIT[0]) {
                let share = not_negative(&mut section, SPLIT[0])?;
                Some(Split { share, late_s: not_negative(&mut section, SPLIT[1])? })
            } else {
                None
            },
            valve: if section.has("valve_late_s") {
                let late = late(&mut section, "valve_late")?;
                // Files of earlier versions do not say it.
                let shares = if section.has(SECOND[0]) {
                    let least = not_negative(&mut section, SECOND[0])?;
                    let most = not_negative(&mut section, SECOND[1])?;
                    if most < least {
                        return Err(
                            section.error(SECOND[1], &format!("{most} is below {}, {least}", SECOND[0]))
                        );
                    }
                    (least, most)
                } else {
                    (0.0, FLAT)
                };
                Some(SeenValve { late, shares })
            } else {
                None
            },
        };
        section.finish()?;
        Ok(Some(recorded))
    }
}

/// A tuning is for another period where that differs by more than this share.
const SAME_PERIOD: f64 = 0.01;

impl Tuning {
    /// The gains as the board takes them.
    pub fn pid(&self) -> PidParameters<f32> {
        PidParameters {
            kp: self.kp as f32,
            ki: self.ki as f32,
            kd: self.kd as f32,
            derivative_filter_s: self.derivative_filter_s as f32,
            tracking_time_s: self.tracking_time_s as f32,
        }
    }

    /// The observer as the board takes it.
    pub fn observer(&self) -> ObserverParameters<f32> {
        self.observer.map_or_else(ObserverParameters::default, |Observer { slope, reach, band }| {
            ObserverParameters { slope: slope as f32, reach: reach as f32, band: band as f32 }
        })
    }

    /// Whether it is for a board of this period (s).
    pub fn is_for(&self, period_s: f64) -> bool {
        (self.period_s / period_s - 1.0).abs() < SAME_PERIOD
    }

    /// The extensions of a model as a controller of this tuning has them.
    #[must_use]
    pub fn extended(&self, extensions: &ExtensionParameters<f64>) -> ExtensionParameters<f64> {
        let mut all = extensions.clone();
        if self.lag_s > 0.0 && all.valve_lag.is_none() {
            all.valve_lag = Some(ValveLagParameters::new(self.lag_s));
        }
        if self.delay_s > 0.0 {
            let own_s = all.transport_delay.map_or(0.0, |delay| delay.delay_s);
            all.transport_delay = Some(TransportDelayParameters { delay_s: own_s + self.delay_s });
        }
        all
    }

    pub(super) fn scaled(&self, scale: Scale) -> Self {
        let per = scale.input / scale.output;
        Self {
            kp: self.kp * per,
            ki: self.ki * per,
            kd: self.kd * per,
            slew_per_s: self.slew_per_s.map(|slew| slew * scale.input),
            observer: self.observer.map(|Observer { slope, reach, band }| Observer {
                slope: slope / per,
                reach,
                band: band * scale.output,
            }),
            ..self.clone()
        }
    }

    pub(super) fn write(&self, names: &Names, top: &mut Table) {
        let (input, output) = (names.input.suffix(), names.output.suffix());
        let numbers = [
            (format!("kp_{input}_per_{output}"), self.kp),
            (format!("ki_{input}_per_{output}_s"), self.ki),
            (format!("kd_{input}_s_per_{output}"), self.kd),
            ("derivative_filter_s".into(), self.derivative_filter_s),
            ("tracking_time_s".into(), self.tracking_time_s),
            ("lag_s".into(), self.lag_s),
            ("delay_s".into(), self.delay_s),
            ("maximum_sensitivity".into(), self.maximum_sensitivity),
            ("gain_margin".into(), self.gain_margin),
            ("phase_margin_deg".into(), self.phase_margin_deg),
            ("bandwidth_least_hz".into(), self.bandwidth_hz.0),
            ("bandwidth_most_hz".into(), self.bandwidth_hz.1),
            ("learning_hz".into(), self.learning_hz),
            ("period_s".into(), self.period_s),
        ];
        let mut table: Table = numbers.map(|(key, value)| (key, value.into())).into_iter().collect();
        if let Some(slew) = self.slew_per_s {
            table.insert(format!("slew_{input}_per_s"), slew.into());
        }
        if let Some(Observer { slope, reach, band }) = self.observer {
            table.insert(format!("observer_slope_{output}_per_{input}"), slope.into());
            table.insert("observer_reach".into(), reach.into());
            table.insert(format!("observer_band_{output}"), band.into());
        }
        table.insert("limited_by".into(), self.limited_by.as_str().into());
        top.insert(TUNING.into(), Value::Table(table));
    }

    pub(super) fn read(top: &mut Section, names: &Names) -> Result<Option<Self>, KeyError> {
        let Some(mut section) = top.optional_section(TUNING)? else { return Ok(None) };
        let (input, output) = (names.input.suffix(), names.output.suffix());
        let of = &mut section;
        let tuning = Self {
            kp: not_negative(of, &format!("kp_{input}_per_{output}"))?,
            ki: not_negative(of, &format!("ki_{input}_per_{output}_s"))?,
            kd: not_negative(of, &format!("kd_{input}_s_per_{output}"))?,
            derivative_filter_s: not_negative(of, "derivative_filter_s")?,
            tracking_time_s: positive(of, "tracking_time_s")?,
            observer: {
                let key = format!("observer_slope_{output}_per_{input}");
                let observer = |of: &mut Section| -> Result<Observer, KeyError> {
                    Ok(Observer {
                        slope: positive(of, &key)?,
                        reach: positive(of, "observer_reach")?,
                        band: not_negative(of, &format!("observer_band_{output}"))?,
                    })
                };
                if of.has(&key) { Some(observer(of)?) } else { None }
            },
            slew_per_s: {
                let key = format!("slew_{input}_per_s");
                if of.has(&key) { Some(positive(of, &key)?) } else { None }
            },
            lag_s: not_negative(of, "lag_s")?,
            delay_s: not_negative(of, "delay_s")?,
            maximum_sensitivity: positive(of, "maximum_sensitivity")?,
            gain_margin: positive(of, "gain_margin")?,
            phase_margin_deg: positive(of, "phase_margin_deg")?,
            bandwidth_hz: (not_negative(of, "bandwidth_least_hz")?, not_negative(of, "bandwidth_most_hz")?),
            learning_hz: not_negative(of, "learning_hz")?,
            limited_by: of.text("limited_by")?,
            period_s: positive(of, "period_s")?,
        };
        section.finish()?;
        Ok(Some(tuning))
    }
}

fn not_negative(section: &mut Section, key: &str) -> Result<f64, KeyError> {
    let number = section.number(key)?;
    if number < 0.0 {
        return Err(section.error(key, &format!("{number} is below 0")));
    }
    Ok(number)
}

fn positive(section: &mut Section, key: &str) -> Result<f64, KeyError> {
    let number = section.number(key)?;
    if number <= 0.0 {
        return Err(section.error(key, &format!("{number} is not above 0")));
    }
    Ok(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::Unit;

    #[test]
    fn a_valve_whose_orders_are_the_wrong_way_round_is_refused_with_both() {
        let names = Names { input: Unit::BAR, output: Unit::MM };
        let read = |orders: &str| {
            let text = format!(
                "[recorded]\nstep_s = 0.01\nnoise_mm = 0.0\nsteeper = 1.0\nlate_s = 0.0\nlate_error_s = 0.0\n\
                 valve_late_s = 0.05\nvalve_late_error_s = 0.001\n{orders}"
            );
            Recorded::read(&mut Section::top(text.parse().expect("TOML")), &names)
                .map_err(|error| error.to_string())
        };
        let shares = |orders: &str| {
            let recorded = read(orders).expect("valid").expect("a section");
            recorded.valve.expect("a valve").shares
        };
        let of = |least: f64, most: f64| {
            format!("valve_second_order_least = {least:?}\nvalve_second_order_most = {most:?}\n")
        };
        assert_eq!(shares(&of(0.0, 0.25)), (0.0, 0.25));
        assert_eq!(shares(""), (0.0, FLAT), "a file of an earlier version");
        let refused = read(&of(0.5, 0.1)).expect_err("the wrong way round");
        assert!(refused.contains("0.1 is below valve_second_order_least, 0.5"), "{refused}");
        assert!(read("valve_second_order_least = 0.1\n").is_err(), "one of them alone");
    }
}
