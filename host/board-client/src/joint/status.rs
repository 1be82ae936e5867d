//! What a board at its link says of itself: state, fault, measurements, what its ticks take, and
//! what it has been told.

use serde_json::{Map, Value, json};
use wire::fault::table::TABLE;
use wire::joint::fault::Advice;
use wire::joint::settings::LIMITS;
use wire::joint::{
    BoardJointControl, BoardJointParameters, JointBoardState, JointCalibration, JointFault, JointHello,
    JointRequest, JointSettings, JointStatus, JointTiming,
};
use wire::{Line, Protection, fingerprint};

use super::error::JointBoardError;
use super::link::JointLink;
use super::settings::{limit, line_in_words};

/// The sensors with a line, in the order of the file of settings, and what their lines are in.
const SENSORS: [(&str, &str); 3] = [("pressure a", "bar"), ("pressure b", "bar"), ("angle", "rad")];

/// A board of a joint at a moment.
#[derive(Clone, Debug)]
pub struct Status {
    hello: JointHello,
    now: JointStatus,
    joint: Joint,
    settings: JointSettings,
}

/// The joint that a board has.
#[derive(Clone, Debug)]
enum Joint {
    None,
    Known(Box<BoardJointParameters>),
    /// What the board has kept is not what it runs.
    NotReadBack,
}

/// What is measured and put out, by names with their units.
struct Signals {
    pressures_bar: [f32; 2],
    angle_deg: f32,
    commands_bar: [f32; 2],
}

impl Status {
    /// Asks a board, in whatever state it is; nothing is changed.
    ///
    /// # Errors
    /// It does not answer.
    pub fn read(link: &mut JointLink) -> Result<Self, JointBoardError> {
        let settings = link.settings(&JointRequest::Settings(None))?;
        let joint = match link.control() {
            Ok(None) => Joint::None,
            Ok(Some(control)) => Joint::Known(Box::new(control)),
            Err(JointBoardError::NotReadBack) => Joint::NotReadBack,
            Err(error) => return Err(error),
        };
        let now = link.status()?;
        Ok(Self { hello: link.hello().clone(), now, joint, settings })
    }

    /// The board's state.
    pub fn state(&self) -> JointBoardState {
        self.now.report.tick.state
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<JointFault> {
        self.now.report.tick.fault
    }

    fn signals(&self) -> Signals {
        let JointHello { pressures: [a, b], angle, command, .. } = &self.hello;
        let report = &self.now.report;
        let [code_a, code_b] = report.pressure_codes;
        Signals {
            pressures_bar: [a.value(code_a), b.value(code_b)],
            angle_deg: angle.value(report.angle_code).to_degrees(),
            commands_bar: report.tick.dac_codes.map(|code| command.value(code)),
        }
    }

    /// Lines of the sensors, in the order of [`SENSORS`].
    fn lines(&self) -> [Option<Line>; 3] {
        let JointCalibration { pressures: [a, b], angle } = self.settings.calibration;
        [a, b, angle]
    }

    /// For people: a screen.
    pub fn in_words(&self) -> String {
        let JointHello { version, firmware: [major, minor, patch], .. } = &self.hello;
        let JointStatus { report, supply_bar, temperature_c, outputs_v, converters_supply_v, timing, resets } =
            &self.now;
        let mut lines = vec![
            format!("state       {:?}", self.state()),
            format!("board       of a joint, firmware {major}.{minor}.{patch}, messages {version}"),
        ];
        lines.extend(match &self.joint {
            Joint::None => vec!["joint       none".to_owned()],
            Joint::NotReadBack => {
                vec!["joint       not read back: what is kept is not what runs; deploy it again".to_owned()]
            }
            Joint::Known(control) => joint_in_words(control),
        });
        let others = LIMITS.into_iter().filter_map(|id| {
            let (value, standard) =
                (limit(&self.settings.protection, id)?, limit(&Protection::STANDARD, id)?);
            (value != standard).then(|| format!("{} {value} (standard {standard})", id.register().name))
        });
        let others: Vec<String> = others.collect();
        let others = if others.is_empty() { "standard".to_owned() } else { others.join(", ") };
        lines.push(format!("limits      {others}"));
        let sensors = SENSORS
            .into_iter()
            .zip(self.lines())
            .map(|((name, unit), line)| format!("{name} {}", line_in_words(line, unit)));
        lines.push(format!("sensors     {}", sensors.collect::<Vec<_>>().join(", ")));
        match self.fault() {
            None => lines.push("fault       none".to_owned()),
            Some(fault) => {
                let Advice { cause, cure } = fault.advice();
                lines.push(format!("fault       {fault}"));
                lines.extend([format!("  cause     {cause}"), format!("  cure      {cure}")]);
            }
        }
        let noted = report.noted.and_then(|fault| TABLE.iter().find(|row| row.fault == fault));
        lines.extend(noted.map(|row| format!("noted       {} {}", row.fault.code(), row.title)));
        let Signals { pressures_bar: [a, b], angle_deg, commands_bar: [command_a, command_b] } =
            self.signals();
        lines.push(format!(
            "measured    pressure a {a:.2} bar, pressure b {b:.2} bar, angle {angle_deg:.2} degrees, supply {supply_bar:.2} bar, \
             temperature {temperature_c:.1} °C"
        ));
        lines.push(format!("commands    a {command_a:.2} bar, b {command_b:.2} bar"));
        if self.state() == JointBoardState::Tracking {
            let due_deg = report.tick.due_rad.to_degrees();
            let (stiffness, torque) = (report.tick.stiffness, report.tick.feedback_nm);
            lines.push(format!(
                "due         {due_deg:.2} degrees, {stiffness:.1} N m/rad; torque of the feedback {torque:.2} N m"
            ));
        }
        let outputs = outputs_v.map(|[a, b]| format!("output a {a:.3} V, output b {b:.3} V"));
        let supply = converters_supply_v.map(|volts| format!("converters supply {volts:.3} V"));
        let own: Vec<String> = outputs.into_iter().chain(supply).collect();
        if !own.is_empty() {
            lines.push(format!("itself      {}", own.join(", ")));
        }
        let mut counted =
            format!("counted     ticks {}, late ticks {}, resets {resets}", report.ticks, report.late_ticks);
        if let Some(JointTiming { worst_cycles, mean_cycles, deadline_cycles, overruns }) = timing {
            counted += &format!(
                "\n            worst tick cycles {worst_cycles}, mean tick cycles {mean_cycles}, deadline cycles \
                 {deadline_cycles}, overruns {overruns}"
            );
        }
        lines.push(counted);
        lines.join("\n")
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let JointHello { version, firmware: [major, minor, patch], .. } = &self.hello;
        let JointStatus { report, supply_bar, temperature_c, outputs_v, converters_supply_v, timing, resets } =
            &self.now;
        let Signals { pressures_bar: [a, b], angle_deg, commands_bar: [command_a, command_b] } =
            self.signals();
        let limits = LIMITS.into_iter().filter_map(|id| {
            let value = limit(&self.settings.protection, id)?;
            Some((id.register().name.to_owned(), number(value)))
        });
        let calibration = SENSORS.into_iter().zip(self.lines()).map(|((name, unit), line)| {
            let line = line.map(|Line { zero_code, codes_per_unit }| {
                json!({"zero_code": number(zero_code), format!("codes_per_{unit}"): number(codes_per_unit)})
            });
            (name.replace(' ', "_"), line.into())
        });
        json!({
            "kind": "joint",
            "state": format!("{:?}", self.state()),
            "versions": {"messages": version, "release": format!("{major}.{minor}.{patch}")},
            "joint": match &self.joint {
                Joint::None => Value::Null,
                Joint::NotReadBack => json!({"is_read_back": false}),
                Joint::Known(control) => joint_to_json(control),
            },
            "limits": limits.collect::<Map<_, _>>(),
            "calibration": calibration.collect::<Map<String, Value>>(),
            "fault": self.fault().map(|fault| {
                let Advice { cause, cure } = fault.advice();
                json!({"number": fault.code(), "title": fault.to_string(), "cause": cause, "cure": cure})
            }),
            "noted": report.noted.map(|fault| json!({"number": fault.code(), "name": format!("{fault:?}")})),
            "pressure_a_bar": number(a),
            "pressure_b_bar": number(b),
            "angle_deg": number(angle_deg),
            "supply_bar": number(*supply_bar),
            "temperature_c": number(*temperature_c),
            "command_a_bar": number(command_a),
            "command_b_bar": number(command_b),
            "due_deg": number(report.tick.due_rad.to_degrees()),
            "stiffness_nm_per_rad": number(report.tick.stiffness),
            "feedback_nm": number(report.tick.feedback_nm),
            "output_a_v": outputs_v.map(|[a, _]| number(a)),
            "output_b_v": outputs_v.map(|[_, b]| number(b)),
            "converters_supply_v": converters_supply_v.map(number),
            "ticks": report.ticks,
            "late_ticks": report.late_ticks,
            "resets": resets,
            "worst_tick_cycles": timing.map(|timing| timing.worst_cycles),
            "mean_tick_cycles": timing.map(|timing| timing.mean_cycles),
            "deadline_cycles": timing.map(|timing| timing.deadline_cycles),
            "overruns": timing.map(|timing| timing.overruns),
        })
    }
}

/// A number of single precision in its shortest form.
fn number(value: f32) -> Value {
    crate::backup::shortest(value).into()
}

/// The least and the largest stiffness in the middle of the angles (N m/rad); none of a joint that
/// is not valid, which no board has.
fn stiffness_range(control: &BoardJointParameters) -> Option<(f32, f32)> {
    let (lowest, highest) = control.joint.angles;
    let valid = BoardJointControl::try_new(control).ok()?;
    Some(valid.joint().stiffness_range(0.5 * (lowest + highest)))
}

fn joint_in_words(control: &BoardJointParameters) -> Vec<String> {
    let BoardJointParameters { joint, pid, .. } = control;
    let (lowest, highest) = joint.angles;
    let stiffness = stiffness_range(control)
        .map_or(String::new(), |(soft, stiff)| format!(", {soft:.1} to {stiff:.1} N m/rad in the middle"));
    vec![
        format!(
            "joint       {:.2} to {:.2} degrees{stiffness}, {} stops, checksum {:08x}",
            lowest.to_degrees(),
            highest.to_degrees(),
            joint.reaches.len(),
            fingerprint(control)
        ),
        format!(
            "gains       kp {}, ki {} 1/s, kd {} s, a tick each {} us",
            pid.kp,
            pid.ki,
            pid.kd,
            (1e6 * f64::from(control.period_s)).round()
        ),
    ]
}

fn joint_to_json(control: &BoardJointParameters) -> Value {
    let BoardJointParameters { joint, pid, turn_rad_per_s, stiffen_per_s, slew_bar_per_s, period_s } =
        control;
    let (lowest, highest) = joint.angles;
    let range = stiffness_range(control);
    json!({
        "is_read_back": true,
        "checksum": format!("{:08x}", fingerprint(control)),
        "angle_min_deg": number(lowest.to_degrees()),
        "angle_max_deg": number(highest.to_degrees()),
        "stiffness_min_nm_per_rad": range.map(|(soft, _)| number(soft)),
        "stiffness_max_nm_per_rad": range.map(|(_, stiff)| number(stiff)),
        "stops": joint.reaches.len(),
        "kp": number(pid.kp),
        "ki_per_s": number(pid.ki),
        "kd_s": number(pid.kd),
        "turn_rad_per_s": number(*turn_rad_per_s),
        "stiffen_nm_per_rad_s": number(*stiffen_per_s),
        "slew_bar_per_s": number(*slew_bar_per_s),
        "period_s": number(*period_s),
    })
}

#[cfg(test)]
mod tests {
    use wire::Scaling;
    use wire::joint::{JointReport, JointTickReply};

    use super::*;

    /// Every number is another one.
    fn status() -> Status {
        let scaling =
            |zero_code, codes_per_unit| Scaling { zero_code, codes_per_unit, code_min: 0, code_max: 4095 };
        let tick = JointTickReply {
            dac_codes: [800, 1200],
            state: JointBoardState::Tracking,
            fault: None,
            due_rad: 0.25,
            stiffness: 55.0,
            feedback_nm: -0.5,
            is_limited: false,
            is_as_stiff: true,
        };
        let report = JointReport {
            ticks: 70_000,
            pressure_codes: [1000, 1300],
            angle_code: 2500,
            supply_code: 3000,
            late_ticks: 3,
            noted: None,
            tick,
        };
        let now = JointStatus {
            report,
            supply_bar: 7.5,
            temperature_c: 41.0,
            outputs_v: Some([0.65, 0.97]),
            converters_supply_v: Some(3.25),
            timing: Some(JointTiming {
                worst_cycles: 9000,
                mean_cycles: 7000,
                deadline_cycles: 84_000,
                overruns: 1,
            }),
            resets: 2,
        };
        let hello = JointHello {
            version: 7,
            firmware: [0, 1, 0],
            state: tick.state,
            fault: None,
            pressures: [scaling(400.0, 300.0), scaling(500.0, 250.0)],
            angle: scaling(2000.0, 1000.0),
            command: scaling(0.0, 400.0),
            ticks: 70_000,
        };
        let settings =
            JointSettings { protection: Protection::STANDARD, calibration: JointCalibration::default() };
        Status { hello, now, joint: Joint::NotReadBack, settings }
    }

    #[test]
    fn every_number_stands_under_its_own_name() {
        let json = status().to_json();
        for (name, value) in [
            ("pressure_a_bar", 2.0),
            ("pressure_b_bar", 3.2),
            ("angle_deg", 0.5_f64.to_degrees()),
            ("supply_bar", 7.5),
            ("temperature_c", 41.0),
            ("command_a_bar", 2.0),
            ("command_b_bar", 3.0),
            ("due_deg", 0.25_f64.to_degrees()),
            ("stiffness_nm_per_rad", 55.0),
            ("feedback_nm", -0.5),
            ("output_a_v", 0.65),
            ("output_b_v", 0.97),
            ("converters_supply_v", 3.25),
            ("ticks", 70_000.0),
            ("late_ticks", 3.0),
            ("resets", 2.0),
            ("worst_tick_cycles", 9000.0),
            ("mean_tick_cycles", 7000.0),
            ("deadline_cycles", 84_000.0),
            ("overruns", 1.0),
        ] {
            let told = json[name].as_f64().expect(name);
            assert!((told - value).abs() < 1e-5, "{name} is {told}, not {value}");
        }
        assert_eq!(json["joint"]["is_read_back"], false);
        let words = status().in_words();
        for line in [
            "state       Tracking",
            "joint       not read back: what is kept is not what runs; deploy it again",
            "measured    pressure a 2.00 bar, pressure b 3.20 bar, angle 28.65 degrees, supply 7.50 bar, temperature 41.0 °C",
            "commands    a 2.00 bar, b 3.00 bar",
            "due         14.32 degrees, 55.0 N m/rad; torque of the feedback -0.50 N m",
            "itself      output a 0.650 V, output b 0.970 V, converters supply 3.250 V",
            "counted     ticks 70000, late ticks 3, resets 2",
            "            worst tick cycles 9000, mean tick cycles 7000, deadline cycles 84000, overruns 1",
        ] {
            assert!(words.lines().any(|told| told == line), "{line} is missing in\n{words}");
        }
    }
}
