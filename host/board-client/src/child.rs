//! A program that this one starts and ends: an emulator or a plant.
//!
//! # Contract
//! It runs in a process group of its own, which ends with its owner, whatever it has started
//! itself: by [`Drop`], or, where the owner is killed, by a guard. A Ctrl-C of the terminal reaches
//! only the owner. What it says on its standard error is kept.

use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

/// How long a program that has closed its output may take to end by itself.
const GRACE: Duration = Duration::from_millis(500);

/// How often a wait for a program looks whether it is still wanted.
pub const WAIT_SLICE: Duration = Duration::from_millis(100);

/// Waits for a line of the owner. A pipe that is closed without one is that of an owner who was
/// killed.
const GUARD: &str = "read line || kill -s KILL -- -$0";

/// A shell that ends a group whose owner was killed.
#[derive(Debug)]
struct Guard(Child);

impl Guard {
    fn of(group: &Child) -> io::Result<Self> {
        let mut shell = Command::new("sh");
        shell.args(["-c", GUARD, &group.id().to_string()]).stdin(Stdio::piped());
        shell.stdout(Stdio::null()).stderr(Stdio::null()).process_group(0);
        Ok(Self(shell.spawn()?))
    }

    /// Ends it without an effect.
    fn dismiss(&mut self) {
        // Fails when somebody has killed it.
        let _ = self.0.stdin.take().map(|mut pipe| pipe.write_all(b"dismissed\n"));
        let _ = self.0.wait();
    }
}

/// A running program with all that it has started.
#[derive(Debug)]
pub struct ChildGroup {
    child: Child,
    guard: Option<Guard>,
    messages: File,
}

impl ChildGroup {
    /// Starts a program.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn spawn(command: &mut Command) -> io::Result<Self> {
        let messages = tempfile::tempfile()?;
        let child = command.stderr(messages.try_clone()?).process_group(0).spawn()?;
        // Whatever fails from here on, the program ends with it.
        let mut group = Self { child, guard: None, messages };
        group.guard = Some(Guard::of(&group.child)?);
        Ok(group)
    }

    /// The program's ends of its pipes.
    pub fn pipes(&mut self) -> (Option<std::process::ChildStdin>, Option<std::process::ChildStdout>) {
        (self.child.stdin.take(), self.child.stdout.take())
    }

    /// Whether it has not ended by itself.
    pub fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Ends the program, if it does not do so by itself, and says how it ended and what it said
    /// last.
    pub fn end(&mut self) -> String {
        let deadline = Instant::now() + GRACE;
        while Instant::now() < deadline {
            if let Ok(Some(status)) = self.child.try_wait() {
                return format!("{}{}", in_words(status), self.last_messages());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        self.kill();
        format!("it closed its output without ending{}", self.last_messages())
    }

    /// What it said on its standard error so far.
    pub fn messages(&self) -> String {
        // A file that cannot be read says nothing.
        let text = contents(&self.messages).unwrap_or_default();
        String::from_utf8_lossy(&text).trim_end().to_owned()
    }

    fn last_messages(&self) -> String {
        const LINES: usize = 10;
        let messages = self.messages();
        let lines: Vec<&str> = messages.lines().collect();
        lines[lines.len().saturating_sub(LINES)..].iter().map(|line| format!("\n  {line}")).collect()
    }

    fn kill(&mut self) {
        // Fails when all have ended already.
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        let _ = self.child.wait();
        // Only now: nobody else can have the group's number while the program has not been waited
        // for.
        self.guard.take().iter_mut().for_each(Guard::dismiss);
    }
}

impl Drop for ChildGroup {
    fn drop(&mut self) {
        self.kill();
    }
}

/// What a file holds that a running program writes; the program's place in it stays.
///
/// # Errors
/// It cannot be read.
pub fn contents(file: &File) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; file.metadata()?.len() as usize];
    file.read_exact_at(&mut bytes, 0)?;
    Ok(bytes)
}

fn in_words(status: ExitStatus) -> String {
    format!("it ended ({status})")
}
