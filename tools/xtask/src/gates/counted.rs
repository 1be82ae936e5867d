//! An image in the emulator under the instruction counter.
//!
//! The emulated serial port (USART2) is one end of a pair of connected sockets, handed over as the
//! emulator's standard input. The counter writes its results when the emulator is asked to end.

use std::fs;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use rustix::process::{Pid, Signal, kill_process};

use super::elf::{Function, Image};

/// How long the image may take for an answer.
const ANSWER_LIMIT: Duration = Duration::from_secs(60);

/// What the calls of a function have cost. Unit: instructions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Number of calls.
    pub calls: u64,
    /// Of the dearest call.
    pub most: u64,
}

/// Runs an image while `drive` talks to it, and counts the instructions of some of its functions,
/// in their order. `plugin`: the counter's file.
///
/// # Errors
/// The emulator does not start or end, `drive` fails, or the call stack was lost.
pub fn run(
    image: &Image,
    plugin: &Path,
    functions: &[&Function],
    drive: impl FnOnce(&UnixStream) -> Result<()>,
) -> Result<Vec<Cost>> {
    let results = image.path.with_extension("counts");
    let (link, theirs) = UnixStream::pair()?;
    link.set_read_timeout(Some(ANSWER_LIMIT))?;
    let child = Command::new("qemu-system-arm")
        .args(["-machine", "netduinoplus2", "-cpu", "cortex-m4", "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-chardev", "socket,id=link,fd=0", "-serial", "null", "-serial", "chardev:link"])
        .arg("-plugin")
        .arg(plugin_option(image, plugin, functions, None, &results))
        .arg("-kernel")
        .arg(&image.path)
        // Descriptor 0 is the standard input. Standard output is the firmware's log.
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .context("cannot start qemu-system-arm")?;
    let driven = drive(&link);
    let messages = end(child)?;
    driven.with_context(|| format!("in the emulator: {}", messages.trim()))?;
    let text = fs::read_to_string(&results)
        .with_context(|| format!("no counts in {}; the emulator: {}", results.display(), messages.trim()))?;
    read_costs(&text, &functions.iter().map(|function| function.name.as_str()).collect::<Vec<_>>())
}

/// How the emulator is told of the counter: functions to be counted, and the way from the begin of
/// one of them to the return of another. Commas separate the option's parts; one in a file's name
/// is doubled.
pub fn plugin_option(
    image: &Image,
    plugin: &Path,
    functions: &[&Function],
    way: Option<[&Function; 2]>,
    results: &Path,
) -> String {
    let escaped = |path: &Path| path.to_string_lossy().replace(',', ",,");
    let mut option = format!("{},out={}", escaped(plugin), escaped(results));
    option.extend(image.handlers.iter().map(|address| format!(",handler={address:#x}")));
    option.extend(functions.iter().map(|f| format!(",fn={}:{:#x}", f.name, f.address)));
    option.extend(way.map(|[from, to]| format!(",way={}:{}", from.name, to.name)));
    option
}

/// Ends the emulator in order, and answers what it said.
fn end(child: Child) -> Result<String> {
    // Fails when it has ended by itself; the counts are then there, or missed later.
    let _ = kill_process(Pid::from_child(&child), Signal::TERM);
    let output = child.wait_with_output().context("the emulator does not end")?;
    Ok(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The counter's results: a line a function and way, with its calls, least, most, sum and dearest
/// call.
///
/// # Errors
/// The call stack was lost, or they are not there.
pub fn read_costs(text: &str, names: &[&str]) -> Result<Vec<Cost>> {
    if let Some(problem) = text.strip_prefix("lost ") {
        bail!("the counter has lost the call stack: {problem}");
    }
    let lines = text.lines().zip(names);
    let costs: Option<Vec<_>> = lines.map(|(line, name)| read_cost(line, name)).collect();
    costs.filter(|costs| costs.len() == names.len()).with_context(|| format!("no counts: {text}"))
}

fn read_cost(line: &str, name: &str) -> Option<Cost> {
    let numbers: Vec<u64> =
        line.strip_prefix(name)?.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    let [calls, _, most, _, _] = numbers[..] else { return None };
    Some(Cost { calls, most })
}
