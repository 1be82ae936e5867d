//! The most stack that a function can take, over all calls: what stands beside the most that runs
//! have taken.
//!
//! A function takes what its instructions put on the stack, each once, whether or not one way leads
//! over all of them; and while it calls, the most that one of those it calls takes. A jump to
//! another function counts as a call.
//!
//! # Limits
//! Calls through pointers are not followed: only texts and the log are written by them. Nor are
//! panics, which end the program. A function that calls itself, or that takes as much of the stack
//! as a register says, is refused.

use std::collections::HashMap;

use anyhow::{Context, Result, bail};

use super::elf::{Function, Image, is_panic};
use super::thumb::{Code, Flow, Step};

/// What the processor puts on the stack when an interrupt comes: 26 words, and one to a whole
/// double word.
const EXCEPTION_FRAME: u64 = 108;

/// What the functions of an image take of the stack. Unit of all: byte.
pub struct Depths<'a> {
    code: Code,
    /// By address.
    functions: HashMap<u64, &'a Function>,
    constants: &'a [std::ops::Range<u64>],
    /// What has been worked out; none for a function that is being looked at.
    known: HashMap<u64, Option<u64>>,
}

impl<'a> Depths<'a> {
    /// Of an image.
    ///
    /// # Errors
    /// Its ELF file cannot be read.
    pub fn of(image: &'a Image) -> Result<Self> {
        Ok(Self {
            code: Code::read(&image.path)?,
            functions: image
                .functions
                .iter()
                .filter(|function| function.bytes > 0)
                .map(|f| (f.address, f))
                .collect(),
            constants: &image.constants,
            known: HashMap::new(),
        })
    }

    /// With all that it calls.
    ///
    /// # Errors
    /// What it does cannot be followed.
    pub fn deepest(&mut self, function: &Function) -> Result<u64> {
        match self.known.get(&function.address) {
            Some(Some(depth)) => return Ok(*depth),
            Some(None) => bail!("{} calls itself", function.name),
            None => {}
        }
        self.known.insert(function.address, None);
        let (alone, calls) = self.frame(function).with_context(|| function.name.clone())?;
        let mut below = 0;
        for to in calls {
            let Some(&called) = self.functions.get(&to) else {
                bail!("{} calls {to:#x}, where no function begins", function.name);
            };
            if !is_panic(&called.name) {
                below = below.max(self.deepest(called)?);
            }
        }
        self.known.insert(function.address, Some(alone + below));
        Ok(alone + below)
    }

    /// As an interrupt: with what the processor keeps meanwhile.
    ///
    /// # Errors
    /// What it does cannot be followed.
    pub fn interrupt(&mut self, function: &Function) -> Result<u64> {
        Ok(EXCEPTION_FRAME + self.deepest(function)?)
    }

    /// What it takes itself, and what it calls.
    fn frame(&self, function: &Function) -> Result<(u64, Vec<u64>)> {
        let inside = function.address..function.address + function.bytes;
        let (mut taken, mut calls, mut address) = (0, Vec::new(), inside.start);
        while address < inside.end {
            if let Some(constants) = self.constants.iter().find(|constants| constants.contains(&address)) {
                address = constants.end;
                continue;
            }
            let step: Step = self.code.step(address)?;
            taken += step.taken.with_context(|| format!("{address:#x} takes what a register says"))?;
            match step.flow {
                Flow::Call(to) => calls.push(to),
                Flow::Jump(to) | Flow::Branch(to) if !inside.contains(&to) => calls.push(to),
                _ => {}
            }
            address += step.length;
        }
        Ok((taken, calls))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(address: u64, bytes: u64) -> Function {
        Function { name: format!("{address:#x}"), address, instructions: 0, bytes }
    }

    fn deepest(halfwords: &[u16], functions: &[Function], constants: &[std::ops::Range<u64>]) -> Result<u64> {
        let code = Code::of(0x100, halfwords);
        let by_address = functions.iter().map(|function| (function.address, function)).collect();
        Depths { code, functions: by_address, constants, known: HashMap::new() }.deepest(&functions[0])
    }

    /// `push {r7, lr}`, `sub sp, #8`, `pop {r7, pc}`, `bx lr`.
    const PUSH: u16 = 0xB580;
    const TAKE: u16 = 0xB082;
    const POP: u16 = 0xBD80;
    const RETURN: u16 = 0x4770;

    #[test]
    fn of_two_calls_the_deeper_counts() -> Result<()> {
        // push; bl to the next function; bl to the one behind it; pop.
        let code = [PUSH, 0xF000, 0xF803, 0xF000, 0xF803, POP, TAKE, RETURN, TAKE, TAKE, RETURN];
        assert_eq!(deepest(&code, &[function(0x100, 12), function(0x10C, 4), function(0x110, 6)], &[])?, 24);
        Ok(())
    }

    #[test]
    fn a_jump_to_another_function_is_a_call() -> Result<()> {
        // push; b to the next function.
        assert_eq!(
            deepest(&[PUSH, 0xE7FF, TAKE, RETURN], &[function(0x100, 4), function(0x104, 4)], &[])?,
            16
        );
        Ok(())
    }

    #[test]
    fn constants_are_no_instructions() -> Result<()> {
        let code = [PUSH, TAKE, PUSH, TAKE, POP];
        assert_eq!(deepest(&code, &[function(0x100, 10)], &[0x102..0x104, 0x106..0x108])?, 16);
        Ok(())
    }

    #[test]
    fn what_calls_itself_or_where_no_function_begins_is_refused() {
        // bl to itself; bl to the next instruction; sub.w sp, sp, r0.
        for code in [[0xF7FF, 0xFFFE], [0xF000, 0xF800], [0xEBAD, 0x0D00]] {
            assert!(deepest(&code, &[function(0x100, 4)], &[]).is_err(), "{code:x?}");
        }
    }
}
