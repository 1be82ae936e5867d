//! `docs/faults.md`, made of the table of faults and that of states.

use std::fmt::Write as _;
use std::fs;

use anyhow::{Context, Result, ensure};
use firmware::state_machine::{Event, Next, next};
use wire::State;
use wire::fault::table::{Latch, Reaction, Row, TABLE};

use crate::run;

const HEADER: &str = "\
<!-- Made by `cargo xtask faults` from wire/src/fault/table.rs and firmware/src/state_machine.rs. -->

# States and faults

What the valve board does when, and what to do when it has stopped. Limits are those of the standard protection
(`wire/src/protection.rs`); the host may set others while the valve is vented.

## States

The valve is driven in `Tracking`, `Holding` and `Service`, and vented in all others. `home` is `SelfTest` with a
configuration, `Off` without; `-` is refused, and changes nothing.

";

const FAULTS: &str = "
## Faults

Each has a number, which the status light flashes (tens long, ones short) and the telemetry counts. The first one is kept
with its tick and the ticks before it, also over a reset, until it is acknowledged (`Request::FaultRecord`). *Vent* means:
the output is at its safe value in the tick that sees the fault, the state is `Fault`, and nothing drives until the host
has acknowledged it. The time counts from the tick in which what is detected begins; behind every row stands a test that
injects its fault (`cargo test -p host-tests --test faults`). The board in the emulator (`mgpi emulate`, `mgpi pil`) is protected
alike, but for what it does not have: supply, clock, reset and watchdog. `--no-monitors` switches those of the plant off there.

";

/// Writes the page, or only compares.
///
/// # Errors
/// The page cannot be written, or differs from the table.
pub fn faults(check: bool) -> Result<()> {
    let path = run::root().join("docs/faults.md");
    let page = page();
    if check {
        let is_current = fs::read_to_string(&path).is_ok_and(|found| found == page);
        ensure!(is_current, "{} is out of date: cargo xtask faults", path.display());
        return Ok(());
    }
    fs::write(&path, page).with_context(|| format!("cannot write {}", path.display()))
}

fn page() -> String {
    let mut page = HEADER.to_owned();
    let events: Vec<_> = Event::ALL.iter().map(|event| format!("{event:?}")).collect();
    page += &table_row(std::iter::once(String::new()).chain(events));
    page += &"|---".repeat(Event::ALL.len() + 1);
    page += "|\n";
    for state in State::ALL {
        let cells = Event::ALL.iter().map(|&event| match next(state, event) {
            Next::To(state) => format!("{state:?}"),
            Next::Home => "home".to_owned(),
            Next::Refused => "-".to_owned(),
        });
        page += &table_row(std::iter::once(format!("**{state:?}**")).chain(cells));
    }
    page += FAULTS;
    page += "| no. | fault | reaction | within, ticks | until |\n|---|---|---|---|---|\n";
    for row in &TABLE {
        let anchor = format!("[{}](#{}-{:?})", row.title, row.fault.code(), row.fault).to_lowercase();
        let within = if row.within_ticks == 0 { "at start".to_owned() } else { row.within_ticks.to_string() };
        page += &table_row([row.fault.code().to_string(), anchor, reaction(row), within, latch(row)]);
    }
    for Row { fault, title, detection, cause, cure, .. } in &TABLE {
        // Writing to a string cannot fail.
        let _ = write!(
            page,
            "\n### {} {fault:?}\n\n*{}.* Seen when {detection}.\n\n**Cause:** {cause}.\n\n**Cure:** {cure}.\n",
            fault.code(),
            capitalised(title),
        );
    }
    page
}

fn table_row(cells: impl IntoIterator<Item = String>) -> String {
    cells.into_iter().fold("|".to_owned(), |row, cell| row + " " + &cell + " |") + "\n"
}

fn reaction(row: &Row) -> String {
    match row.reaction {
        Reaction::Vent => "vent",
        Reaction::AsConfigured => "vent, or feedback alone, as configured",
        Reaction::Count => "counted",
    }
    .to_owned()
}

fn latch(row: &Row) -> String {
    match row.latch {
        Latch::Acknowledged => "acknowledged",
        Latch::PowerOn => "power-on",
        Latch::Never => "-",
    }
    .to_owned()
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}
