//! The named causes against none, against each cause alone, without each of themselves, and against
//! their rivals.

use maud::{Markup, html};

use crate::bars::{Bar, Mark, bars};
use diagnosis::causes::Cause;
use diagnosis::{Diagnosis, Tried};
use recording::unit::Unit;

/// The section of the report.
pub fn section(diagnosis: &Diagnosis, unit: Unit) -> Markup {
    let contest = contest(diagnosis);
    let causes = diagnosis.causes.iter().map(|named| named.cause);
    let at_the_valve: Vec<Cause> = causes.filter(|cause| diagnosis.is_judged_at_the_valve(*cause)).collect();
    let groups: Vec<Bar<'_>> = contest
        .iter()
        .map(|entry| Bar { name: &entry.name, values: &entry.values, is_chosen: entry.is_chosen })
        .collect();
    let noise = Mark { name: "noise of the sensor", value: diagnosis.anatomy.noise.deviation };
    let names = ["held-out error", "what visits to the same state differ by"];
    html! {
        h2 { "The evidence, for and against" }
        p { "Each set of causes was fitted together with the model, and tried on blocks of time that its fit had not seen: there \
            a cause that is not at work gains nothing. Bold: what the verdict names. Causes that are not drawn gain less, by a first estimate."
            @if !at_the_valve.is_empty() {
                " " (name(&at_the_valve)) ": found between command and pressure, with the bars of the valve below."
            }
        }
        (bars(&format!("Error of the model with … ({unit})"), &names, &groups, Some(&noise)))
        p { "The lower of the two compares visits of the muscle to the same state, far apart in time. An error of shape is the same at \
            both visits, and cancels; a difference comes from a missing cause, or from a disturbance." }
    }
}

/// A model that takes part.
struct Entry {
    name: String,
    /// Held-out error and, where it is known, the pure error. Output unit.
    values: Vec<f64>,
    is_chosen: bool,
}

/// All that take part, the worst first.
fn contest(diagnosis: &Diagnosis) -> Vec<Entry> {
    let entry = |name: String, heldout: f64, pure_error: Option<f64>, is_chosen| Entry {
        name,
        values: [heldout].into_iter().chain(pure_error).collect(),
        is_chosen,
    };
    let of = |set: &Tried| entry(name(&set.causes), set.heldout, set.pure_error, false);
    let named: Vec<Cause> =
        diagnosis.causes.iter().filter(|named| named.without.is_some()).map(|named| named.cause).collect();
    let pure = diagnosis.pure_error;
    let (none, with) = diagnosis.heldout;
    let mut all = vec![entry("no cause".to_owned(), none, pure.map(|pure| pure.0), false)];
    if !named.is_empty() {
        let is_named = super::are_causes_named(diagnosis.verdict);
        all.push(entry(name(&named), with, pure.map(|pure| pure.1), is_named));
    }
    let without = diagnosis.causes.iter().filter_map(|named| named.without.as_ref());
    for set in without.chain(best_of_each(diagnosis)) {
        let set = of(set);
        if !set.name.is_empty() && all.iter().all(|other| other.name != set.name) {
            all.push(set);
        }
    }
    all.sort_by(|one, other| other.values[0].total_cmp(&one.values[0]));
    all
}

/// Each cause alone, the sets that do as well as the named one, and the best set of each size.
fn best_of_each(diagnosis: &Diagnosis) -> impl Iterator<Item = &Tried> {
    let mut largest = 1;
    diagnosis.tried.iter().filter(move |set| {
        let is_best = set.causes.len() > largest;
        largest = largest.max(set.causes.len());
        set.causes.len() == 1 || is_best || diagnosis.alternatives.contains(&set.causes)
    })
}

/// Causes as a name, whatever their order.
pub fn name(causes: &[Cause]) -> String {
    let mut names: Vec<&str> = causes.iter().map(|cause| cause.name()).collect();
    names.sort_unstable();
    names.join(" and ")
}
