//! Causes that are easily taken for each other, and where they part; and what a person has to do for some.

use crate::cause::Cause;

/// Two causes, and what the excitation does to tell them apart.
const RIVALS: [(Cause, Cause, &str); 14] = [
    (
        Cause::TransportDelay,
        Cause::ValveLag,
        "after a jump a delay leaves all still for its time, a lag begins at once",
    ),
    (
        Cause::TransportDelay,
        Cause::ViscousLag,
        "after a jump a delay leaves all still for its time, a lag begins at once",
    ),
    (
        Cause::ValveLag,
        Cause::ViscousLag,
        "record the pressure too: it follows the command late, or it does not",
    ),
    (Cause::TransportDelay, Cause::Inertia, "after a jump a mass overshoots, a delay does not"),
    (
        Cause::ViscousLag,
        Cause::RateDependentWidth,
        "when the input stops, what lags comes after; a loop that was wide for its speed stays where it is",
    ),
    (Cause::ViscousLag, Cause::Inertia, "after a jump a mass overshoots, a lag does not"),
    (Cause::ViscousLag, Cause::Creep, "in a long hold a lag ends, creep goes on over decades of time"),
    (Cause::RateDependentWidth, Cause::Creep, "in a long hold creep goes on, after slow swings too"),
    (
        Cause::Creep,
        Cause::Drift,
        "creep starts anew, and the other way, at each jump; a drift goes on the same",
    ),
    (Cause::Creep, Cause::WarmUp, "in a long hold there is no travel: what moves is creep"),
    (Cause::Drift, Cause::WarmUp, "in the rest between the swings time goes on and travel does not"),
    (
        Cause::Drift,
        Cause::Temperature,
        "let the temperature rise and fall, so that it is not a measure of time",
    ),
    (
        Cause::WarmUp,
        Cause::Temperature,
        "let the temperature rise and fall in the rest too, where there is no travel",
    ),
    (
        Cause::ValveDeadband,
        Cause::HysteresisShape,
        "record the pressure too: a dead band is between command and pressure, the loop after it",
    ),
];

/// Where the causes part, a line a pair.
pub fn lines(causes: &[Cause]) -> Vec<String> {
    RIVALS
        .iter()
        .filter(|(one, other, _)| causes.contains(one) && causes.contains(other))
        .map(|(one, other, words)| format!("{one} or {other}: {words}"))
        .collect()
}

/// What has to be done beside playing the command, each thing once.
pub fn notes(causes: &[Cause]) -> Vec<&'static str> {
    let mut notes: Vec<&str> = causes.iter().filter_map(|cause| note(*cause)).collect();
    notes.sort_unstable();
    notes.dedup();
    notes
}

fn note(cause: Cause) -> Option<&'static str> {
    Some(match cause {
        Cause::ValveLag | Cause::ValveDeadband | Cause::SupplySaturation => {
            "record the measured pressure as pressure_bar beside command_bar"
        }
        Cause::Load => "change the load where the plan says so, and record it as load_n",
        Cause::Temperature => {
            "record temperature_c, and let it rise and fall by some K while the plan is played"
        }
        Cause::WarmUp => "begin with a muscle that has rested for an hour: the first cycles show it",
        Cause::TransportDelay | Cause::Inertia => {
            "record 100 rows a second or more: fast movements are short"
        }
        _ => return None,
    })
}
