//! Causes that are easily taken for each other, and where they part; and what a person has to do for some.

use crate::causes::Cause;

/// Two causes, and what the excitation does to tell them apart.
const RIVALS: [(&str, &str, &str); 14] = [
    (
        "transport_delay",
        "valve_lag",
        "after a jump a delay leaves all still for its time, a lag begins at once",
    ),
    (
        "transport_delay",
        "viscous_lag",
        "after a jump a delay leaves all still for its time, a lag begins at once",
    ),
    ("valve_lag", "viscous_lag", "record the pressure too: it follows the command late, or it does not"),
    ("transport_delay", "inertia", "after a jump a mass overshoots, a delay does not"),
    (
        "viscous_lag",
        "rate_dependent_width",
        "when the input stops, what lags comes after; a loop that was wide for its speed stays where it is",
    ),
    ("viscous_lag", "inertia", "after a jump a mass overshoots, a lag does not"),
    ("viscous_lag", "creep", "in a long hold a lag ends, creep goes on over decades of time"),
    ("rate_dependent_width", "creep", "in a long hold creep goes on, after slow swings too"),
    ("creep", "drift", "creep starts anew, and the other way, at each jump; a drift goes on the same"),
    ("creep", "warm_up", "in a long hold there is no travel: what moves is creep"),
    ("drift", "warm_up", "in the rest between the swings time goes on and travel does not"),
    ("drift", "temperature", "let the temperature rise and fall, so that it is not a measure of time"),
    ("warm_up", "temperature", "let the temperature rise and fall in the rest too, where there is no travel"),
    (
        "valve_deadband",
        "hysteresis_shape",
        "record the pressure too: a dead band is between command and pressure, the loop after it",
    ),
];

/// Where the causes part, a line a pair.
pub fn lines(causes: &[Cause]) -> Vec<String> {
    let has = |name: &str| causes.iter().any(|cause| cause.name() == name);
    RIVALS
        .iter()
        .filter(|(one, other, _)| has(one) && has(other))
        .map(|(one, other, words)| format!("{one} or {other}: {words}"))
        .collect()
}

/// What has to be done beside playing the command, each thing once.
pub fn notes(causes: &[Cause]) -> Vec<&'static str> {
    let mut notes: Vec<&str> = causes.iter().filter_map(|cause| cause.about().note).collect();
    notes.sort_unstable();
    notes.dedup();
    notes
}
