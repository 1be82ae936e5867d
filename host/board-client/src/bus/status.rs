//! All that a board says of itself: state, faults, measurements, what its ticks take.

use model_core::Mode;
use serde_json::{Value, json};
use wire::fault::table::{Row, TABLE};
use wire::registers::{Id, UpdateTrial, mode};
use wire::{FAULTS, Fault, Inputs, State};

use super::about::About;
use super::adapted::Adapted;
use super::board::{Block, Board, Identity};
use super::calibration::{in_words, read_inputs};
use super::client::BusError;
use super::error::row;
use super::reached::{InWords, Reached};

/// A board at a moment.
#[derive(Clone, Debug)]
pub struct Status {
    identity: Identity,
    about: Option<About>,
    image: Option<Running>,
    reached: Option<Reached>,
    now: Block,
    /// What the board reads of itself; none of one whose firmware is older.
    own: Option<Block>,
    /// What it has learnt of its muscle; none of one whose firmware is older.
    adapted: Option<Adapted>,
    /// How its sensors are connected; none of one whose firmware is older.
    inputs: Option<Inputs>,
    mode: Block,
    gains: Block,
    /// How often each fault that the board knows has occurred since the start, by its number less
    /// one.
    counts: Vec<u16>,
    record: Option<Recorded>,
}

/// The first fault since the last acknowledgement.
#[derive(Clone, Copy, Debug)]
struct Recorded {
    /// Of the fault.
    number: u32,
    tick: u32,
}

/// What is measured, with its unit in its name.
const SIGNALS: [Id; 6] =
    [Id::ReferenceMm, Id::ContractionMm, Id::PressureBar, Id::CommandBar, Id::SupplyBar, Id::TemperatureC];
/// What the board reads of itself, with its unit in its name.
const OWN: [Id; 4] = [Id::PressureNoise, Id::ContractionNoise, Id::OutputV, Id::ConvertersSupplyV];
/// The gains of the feedback.
const GAINS: [Id; 3] = [Id::Kp, Id::Ki, Id::Kd];
/// What is counted about the ticks and the bus.
const COUNTERS: [Id; 12] = [
    Id::Ticks,
    Id::WorstTick,
    Id::MeanTick,
    Id::Deadline,
    Id::Overruns,
    Id::LateTicks,
    Id::LimitedTicks,
    Id::BridgedSamples,
    Id::Resets,
    Id::BusFrames,
    Id::BusDamaged,
    Id::BusRefused,
];

/// Which of its two images a board runs, and whether for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Running {
    place: &'static str,
    trial: UpdateTrial,
}

impl Running {
    /// Asks the board; `None` of one that takes no images, or whose firmware is older than that.
    fn read(board: &mut Board) -> Result<Option<Self>, BusError> {
        let block = match board.read(Id::UpdatePlace, Id::UpdateTrial) {
            Err(error) if error.exception().is_some() => return Ok(None),
            block => block?,
        };
        let place = match block.whole(Id::UpdatePlace) {
            1 => "A",
            2 => "B",
            _ => return Ok(None),
        };
        Ok(UpdateTrial::of_number(block.whole(Id::UpdateTrial) as u16).map(|trial| Self { place, trial }))
    }

    fn in_words(&self) -> String {
        let Self { place, trial } = self;
        match trial {
            UpdateTrial::ForGood => format!("{place}, for good"),
            UpdateTrial::OnTrial => format!("{place}, on trial: it has to run for 10 s, and to be asked"),
            UpdateTrial::RolledBack => {
                format!("{place}, for good: the other was tried, and has not shown that it runs")
            }
            UpdateTrial::Waits => format!("{place}; the other is tried at the next start"),
        }
    }

    fn to_json(self) -> Value {
        json!({"place": self.place, "trial": self.trial.number()})
    }
}

impl Status {
    /// Asks the board.
    ///
    /// # Errors
    /// No answer.
    pub fn read(board: &mut Board) -> Result<Self, BusError> {
        let now = board.read(Id::State, Id::BusRefused)?;
        let record = board.read(Id::RecordFault, Id::RecordTick)?;
        Ok(Self {
            identity: board.identity().clone(),
            about: About::read(board)?,
            image: Running::read(board)?,
            reached: Reached::read(board)?,
            now,
            own: match board.read(Id::PressureNoise, Id::ConvertersSupplyV) {
                Err(error) if error.exception().is_some() => None,
                own => Some(own?),
            },
            adapted: match Adapted::read(board) {
                Err(error) if error.exception().is_some() => None,
                adapted => Some(adapted?),
            },
            inputs: read_inputs(board)?,
            mode: board.read(Id::Mode, Id::Mode)?,
            gains: board.read(Id::Kp, Id::Kd)?,
            counts: board.read_run(Id::FaultCounts)?,
            record: Some(record.whole(Id::RecordFault))
                .filter(|number| *number != 0)
                .map(|number| Recorded { number, tick: record.whole(Id::RecordTick) }),
        })
    }

    /// The board's state.
    pub fn state(&self) -> State {
        self.now.state()
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<Fault> {
        Fault::of_code(self.now.whole(Id::Fault) as u8)
    }

    /// What a register of the status says.
    pub fn number(&self, id: Id) -> f64 {
        self.now.number(id)
    }

    /// The faults that have occurred since the start, with how often.
    fn occurred(&self) -> impl Iterator<Item = (&'static Row, u16)> {
        TABLE.iter().zip(self.counts.iter().copied()).filter(|(_, count)| *count > 0)
    }

    /// How the firmware's versions differ from those that this program was made with.
    fn difference(&self) -> Option<String> {
        let (messages, faults) = (self.identity.wire_version, self.counts.len());
        let latched = self.now.whole(Id::Fault) as usize;
        if messages == wire::VERSION && faults == FAULTS && latched <= FAULTS {
            return None;
        }
        let is_newer = messages > wire::VERSION || latched > FAULTS;
        let (age, cure) = if is_newer {
            ("newer", "use a newer mgpi")
        } else {
            ("older", "what it does not know is left out; flash the firmware of this release")
        };
        let own = wire::VERSION;
        let known =
            if is_newer { String::new() } else { format!(", knows faults 1 to {faults} of {FAULTS}") };
        Some(format!("the firmware is {age}: it has messages {messages}, this program {own}{known}: {cure}"))
    }

    /// For people: a screen.
    pub fn in_words(&self) -> String {
        let Identity { release: [major, minor, patch], wire_version, storage_version, period_s, .. } =
            self.identity;
        let mut lines = vec![
            format!("state       {:?}", self.state()),
            format!(
                "board       firmware {major}.{minor}.{patch}, registers {}, messages {wire_version}, \
                 storage {storage_version}, a tick each {} us",
                wire::registers::VERSION,
                (period_s * 1e6).round()
            ),
        ];
        lines.extend(self.about.iter().flat_map(About::in_words));
        lines.extend(self.image.as_ref().map(|image| format!("image       {}", image.in_words())));
        lines.extend(self.reached.map(|Reached { kept, .. }| format!("bus         {}", InWords(&kept))));
        lines.extend(self.inputs.map(|inputs| {
            let Inputs { pressure, contraction, supply } = inputs;
            format!(
                "inputs      pressure {}, contraction {}, supply {}",
                in_words(&pressure, "bar"),
                in_words(&contraction, "mm"),
                in_words(&supply, "bar")
            )
        }));
        lines.extend(self.difference().map(|difference| format!("versions    {difference}")));
        match (self.now.whole(Id::Fault), self.fault().and_then(row)) {
            (0, _) => lines.push("fault       none".to_owned()),
            (number, None) => lines.push(format!("fault       {}", name(number))),
            (_, Some(row)) => lines.extend(with_cure("fault", row)),
        }
        if let Some(Recorded { number, tick }) = self.record {
            let after_s = f64::from(tick) * period_s;
            lines.push(format!("first       {}, {after_s:.3} s after the start (tick {tick})", name(number)));
        }
        for (row, count) in self.occurred() {
            lines.push(format!("            {count} x {} ({:?})", row.title, row.fault));
        }
        let values = |ids: &[Id]| ids.iter().map(|&id| self.with_unit(id)).collect::<Vec<_>>().join(", ");
        lines.push(format!("measured    {}", values(&SIGNALS)));
        lines.extend(self.own.as_ref().map(|own| {
            let shown = OWN.map(|id| {
                let register = id.register();
                let name = register.name.rsplit_once('_').map_or(register.name, |(name, _)| name);
                format!("{} {:.3} {}", name.replace('_', " "), own.number(id), register.unit)
            });
            format!("itself      {}", shown.join(", "))
        }));
        let learnt = self.adapted.filter(|adapted| adapted.steps > 0);
        lines.extend(learnt.map(|adapted| format!("learnt      {adapted}")));
        let counters = COUNTERS
            .iter()
            .map(|&id| format!("{} {}", id.register().name.replace('_', " "), self.number(id)));
        let counters: Vec<String> = counters.collect();
        lines.extend(
            counters
                .chunks(4)
                .zip(["counted     "].into_iter().chain(std::iter::repeat("            ")))
                .map(|(counters, head)| format!("{head}{}", counters.join(", "))),
        );
        lines.join("\n")
    }

    fn with_unit(&self, id: Id) -> String {
        let register = id.register();
        let name = register.name.rsplit_once('_').map_or(register.name, |(name, _)| name);
        format!("{name} {:.2} {}", self.number(id), register.unit)
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let Identity { release: [major, minor, patch], wire_version, storage_version, .. } = self.identity;
        let mut json = json!({
            "state": format!("{:?}", self.state()),
            "versions": {
                "registers": wire::registers::VERSION, "wire": wire_version, "storage": storage_version,
                "release": format!("{major}.{minor}.{patch}"), "faults": self.counts.len(),
                "difference": self.difference(),
            },
            "about": self.about.as_ref().map(About::to_json),
            "image": self.image.map(Running::to_json),
            "bus": self.reached.map(|Reached { kept, .. }| json!({
                "number": kept.unit, "rate_bit_per_s": kept.baud, "parity": format!("{:?}", kept.parity).to_lowercase(),
                "turnaround_us": kept.turnaround_us,
            })),
            "fault": match self.now.whole(Id::Fault) {
                0 => Value::Null,
                number => self.fault().and_then(row).map_or_else(|| json!({"number": number}), told),
            },
            "record": self.record.map(|Recorded { number, tick }| json!({"fault": name(number), "tick": tick})),
            "inputs": self.inputs.map(|Inputs { pressure, contraction, supply }| json!({
                "pressure": in_words(&pressure, "bar"), "contraction": in_words(&contraction, "mm"),
                "supply": in_words(&supply, "bar"),
            })),
            "occurred": self.occurred().map(|(row, count)| {
                let mut fault = told(row);
                fault["count"] = count.into();
                fault
            }).collect::<Vec<_>>(),
        });
        for id in SIGNALS.into_iter().chain(COUNTERS) {
            json[id.register().name] = self.number(id).into();
        }
        for (id, own) in OWN.into_iter().zip(std::iter::repeat(&self.own)) {
            json[id.register().name] = own.as_ref().map(|own| own.number(id)).into();
        }
        json["mode"] = mode(self.mode.whole(Id::Mode) as u16).map(mode_in_words).into();
        for id in GAINS {
            json[id.register().name] = self.gains.number(id).into();
        }
        json["adapted"] = self.adapted.as_ref().map(Adapted::to_json).into();
        json
    }
}

/// A fault's name; of one that this program does not know, its number.
fn name(number: u32) -> String {
    let known = u8::try_from(number).ok().and_then(Fault::of_code);
    known.map_or_else(|| format!("{number}, which this program does not know"), |fault| format!("{fault:?}"))
}

fn told(row: &Row) -> Value {
    let Row { fault, title, cause, cure, .. } = row;
    json!({"number": fault.code(), "name": format!("{fault:?}"), "title": title, "cause": cause, "cure": cure})
}

fn with_cure(head: &str, row: &Row) -> [String; 3] {
    [
        format!("{head:<12}{} {:?}: {}", row.fault.code(), row.fault, row.title),
        format!("  cause     {}", row.cause),
        format!("  cure      {}", row.cure),
    ]
}
/// What drives the valve in a mode.
fn mode_in_words(mode: Mode) -> &'static str {
    match mode {
        Mode::Both => "feed-forward and feedback",
        Mode::FeedforwardOnly => "feed-forward alone",
        Mode::FeedbackOnly => "feedback alone",
        Mode::Hold => "hold",
    }
}
