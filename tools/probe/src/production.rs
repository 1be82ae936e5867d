//! The production image, a tick a call.

use std::io::{ErrorKind, Read, Write};
use std::ops::Range;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use firmware::Samples;
use object::{Object, ObjectSymbol};
use rustix::process::{Pid, Signal, kill_process};
use wire::{FRAME_BYTES, Receiver, Request, Response};

use crate::stub::{Register, Stub};
use crate::valve_log::ValveLog;

/// The function that reads the converter; see the image's `scan.rs`.
const SCAN: &str = "adc_scan";
/// The bit of a function's address that says Thumb, which every function here is.
const THUMB: u64 = 1;
/// How long the emulator may take for anything.
const LIMIT: Duration = Duration::from_secs(60);
/// How many ticks the image may take for an answer.
const ANSWER_TICKS: u32 = 100_000;
/// The status register of the link's port (USART2), and its bit that says that a byte is there to
/// be read.
const LINK_STATUS: u32 = 0x4000_4400;
const RXNE: u8 = 1 << 5;
/// How often that bit is asked for before a byte is given up: the emulator takes a byte from its
/// socket when it comes to it.
const ARRIVAL_POLLS: u32 = 1_000_000;
/// The lowest address of the stack, and the one behind its highest; from memory.x.
const STACK: [&str; 2] = ["_stack_end", "_stack_start"];
/// The sectors of the parameter store, from memory.x.
const STORE: u32 = 0x0800_4000;
/// Unit: byte.
const STORE_BYTES: usize = 32 * 1024;
/// What the stack is filled with before the image starts.
const UNUSED: u8 = 0xA5;

/// The end of the variables' memory, which the image leaves free: for what the debugger lets the
/// processor do.
const SCRATCH: u32 = 0x2001_FE00;
/// `str r0, [r1]`, `mov r0, r2`, `mov r1, r3`, `bx lr`: a store, then a result of two words.
const STORE_AND_RETURN: [u16; 4] = [0x6008, 0x4610, 0x4619, 0x4770];
/// `push {r0-r7, lr}`, `b` back to it: until the stack is full.
const PUSH_FOR_EVER: [u16; 2] = [0xB5FF, 0xE7FD];
/// The processor's register of pending interrupts, and its bit that takes SysTick's back.
const ICSR: u32 = 0xE000_ED04;
const PENDSTCLR: u32 = 1 << 25;

/// What ends a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crash {
    /// It goes on where no memory is.
    NoMemory,
    /// It calls deeper and deeper.
    EndlessCalls,
}

/// The image, stopped where a tick asks for its samples.
pub struct Production {
    child: Child,
    stub: Stub,
    link: UnixStream,
    receiver: Receiver,
    valve: ValveLog,
    /// What the debugger's memory holds.
    scratch: Vec<u8>,
    /// Samples for the ticks that pass while something else is waited for.
    samples: Option<Samples>,
    /// The addresses of the stack.
    stack: Range<u32>,
}

impl Production {
    /// Starts the image of an ELF file and lets it run up to its first tick. `store`: what the
    /// parameter store begins with, blank behind it; the emulated flash cannot be changed by the
    /// image. `bus`: the socket that the users' bus goes to, if any. `options`: further ones of the
    /// emulator.
    ///
    /// # Errors
    /// The file is not the production image, or the emulator cannot be started.
    pub fn start(elf: &Path, store: &[u8], bus: Option<&Path>, options: &[String]) -> Result<Self> {
        let (scan, [stack_end, stack_start]) = (address(elf, SCAN)?, STACK.map(|name| address(elf, name)));
        let stack = stack_end?..stack_start?;
        let (link, their_link) = UnixStream::pair()?;
        let (debug, their_debug) = UnixStream::pair()?;
        debug.set_read_timeout(Some(LIMIT))?;
        link.set_nonblocking(true)?;
        let log = tempfile::tempfile()?;
        let child = Command::new("qemu-system-arm")
            .args(["-machine", "netduinoplus2", "-cpu", "cortex-m4", "-display", "none", "-monitor", "none"])
            .args(["-icount", "shift=3,sleep=off", "-d", "unimp", "-S"])
            .args(bus.map_or(["-chardev".to_owned(), "null,id=bus".to_owned()], |socket| {
                ["-chardev".to_owned(), format!("socket,id=bus,path={}", socket.display())]
            }))
            .args(["-chardev", "socket,id=link,fd=0", "-serial", "chardev:bus", "-serial", "chardev:link"])
            .args(["-chardev", "socket,id=stub,fd=1", "-gdb", "chardev:stub"])
            .args(options)
            .arg("-kernel")
            .arg(elf)
            // Descriptors 0 and 1 are the standard input and output; the log goes to the standard
            // error.
            .stdin(Stdio::from(OwnedFd::from(their_link)))
            .stdout(Stdio::from(OwnedFd::from(their_debug)))
            .stderr(Stdio::from(log.try_clone()?))
            .spawn()
            .context("cannot start qemu-system-arm")?;
        let mut stub = Stub::connect(debug)?;
        stub.write(stack.start, &vec![UNUSED; stack.len()])?;
        let mut flash = store.to_vec();
        flash.resize(STORE_BYTES, 0xFF);
        stub.write(STORE, &flash)?;
        stub.break_at(scan)?;
        stub.resume(&[])?;
        let valve = ValveLog::new(log);
        let (receiver, scratch) = (Receiver::new(), Vec::new());
        let mut image = Self { child, stub, link, receiver, valve, scratch, samples: None, stack };
        // What was written before the first tick.
        image.valve.codes()?;
        Ok(image)
    }

    /// Gives the tick its samples, or none that are new, and runs on to the next tick. The codes
    /// that were written to the valve in between, one a tick if all is well.
    ///
    /// The emulator's clock runs on while the debugger stops the processor, up to the next tick.
    /// That tick is not due yet: the processor takes its interrupt back before it goes on.
    ///
    /// # Errors
    /// The image does not come to its next tick.
    pub fn tick(&mut self, samples: Option<Samples>) -> Result<Vec<u16>> {
        self.samples = samples;
        let packed = samples.map_or(u64::MAX, |samples| {
            let Samples { temperature, supply, pressure, contraction, .. } = samples;
            [contraction, pressure, supply, temperature]
                .iter()
                .fold(0, |packed, code| packed << 16 | u64::from(code.0))
        });
        self.run(
            &STORE_AND_RETURN,
            &[
                (Register::R0, PENDSTCLR),
                (Register::R1, ICSR),
                (Register::R2, packed as u32),
                (Register::R3, (packed >> 32) as u32),
            ],
        )
    }

    /// Does something to the program that it cannot bear, in the middle of a tick, and runs on to
    /// the first tick after the reset. The codes that were written to the valve in between.
    ///
    /// # Errors
    /// The image does not come to another tick.
    pub fn crash(&mut self, crash: Crash) -> Result<Vec<u16>> {
        match crash {
            // `bx r0`.
            Crash::NoMemory => self.run(&[0x4700], &[(Register::R0, 0x6000_0001)]),
            Crash::EndlessCalls => self.run(&PUSH_FOR_EVER, &[]),
        }
    }

    /// Lets the processor go on with these instructions and registers, up to the next tick.
    fn run(&mut self, instructions: &[u16], registers: &[(Register, u32)]) -> Result<Vec<u16>> {
        let code: Vec<u8> = instructions.iter().flat_map(|instruction| instruction.to_le_bytes()).collect();
        if self.scratch != code {
            self.stub.write(SCRATCH, &code)?;
            self.scratch = code;
        }
        self.stub.resume(&[registers, &[(Register::Pc, SCRATCH)]].concat())?;
        self.valve.codes()
    }

    /// Sends a request, without waiting for its response.
    ///
    /// # Errors
    /// The emulator has ended.
    pub fn send(&mut self, request: &Request) -> Result<()> {
        let mut buffer = [0; FRAME_BYTES];
        Ok(self.link.write_all(wire::encode(request, &mut buffer)?)?)
    }

    /// The next response, if it is there.
    ///
    /// # Errors
    /// The emulator has ended, or the response cannot be read.
    pub fn response(&mut self) -> Result<Option<Response>> {
        let mut byte = [0];
        loop {
            match self.link.read(&mut byte) {
                Ok(0) => bail!("the emulator has ended"),
                Ok(_) => {
                    if let Some(response) = self.receiver.push(byte[0]) {
                        return Ok(Some(response?));
                    }
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(None),
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Sends a request, a byte a tick with the last samples, and ticks on until its response is
    /// there. A byte has arrived before its tick goes on, so that how many ticks it takes hangs on
    /// the image alone and not on the host's speed.
    ///
    /// # Errors
    /// There is none.
    pub fn request(&mut self, request: &Request) -> Result<Response> {
        let mut buffer = [0; FRAME_BYTES];
        for byte in wire::encode(request, &mut buffer)? {
            self.link.write_all(&[*byte])?;
            self.await_arrival()?;
            self.tick(self.samples)?;
        }
        for _ in 0..ANSWER_TICKS {
            if let Some(response) = self.response()? {
                return Ok(response);
            }
            self.tick(self.samples)?;
        }
        bail!("no answer to {request:?}")
    }

    /// Waits until the link's port holds a byte.
    fn await_arrival(&mut self) -> Result<()> {
        for _ in 0..ARRIVAL_POLLS {
            if self.stub.read(LINK_STATUS, 4)?.first().is_some_and(|status| status & RXNE != 0) {
                return Ok(());
            }
        }
        bail!("a byte that was sent does not arrive")
    }

    /// The most that the stack has ever held. Unit: byte.
    ///
    /// # Errors
    /// The stub does not tell.
    pub fn stack_bytes(&mut self) -> Result<u32> {
        let stack = self.stub.read(self.stack.start, self.stack_room())?;
        let unused = stack.iter().take_while(|byte| **byte == UNUSED).count();
        Ok(self.stack_room() - unused as u32)
    }

    /// The most that the stack can hold. Unit: byte.
    pub fn stack_room(&self) -> u32 {
        self.stack.end - self.stack.start
    }

    /// Ends the emulator in order, so that what it counts is written.
    ///
    /// # Errors
    /// It does not end.
    pub fn end(mut self) -> Result<()> {
        kill_process(Pid::from_child(&self.child), Signal::TERM)?;
        self.child.wait()?;
        Ok(())
    }
}

impl Drop for Production {
    fn drop(&mut self) {
        // Fails when it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Where a symbol of an ELF file is: a function, or an end of the stack.
fn address(elf: &Path, name: &str) -> Result<u32> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = object::File::parse(&*bytes)?;
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
    let symbol = symbol.with_context(|| format!("{} has no symbol {name}", elf.display()))?;
    Ok((symbol.address() & !THUMB) as u32)
}
