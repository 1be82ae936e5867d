//! The longest way through a function, over all its branches: whatever it is given, it takes no
//! more instructions.
//!
//! Where sizes are known when the firmware is compiled, the control law has no loops, so that its
//! ways can be followed one and all. Not all of them need be possible, for what one comparison has
//! told may contradict another: it is an upper bound, beside which what samples have taken stands
//! as a lower one.
//!
//! # Limits
//! A function that goes back, or on to where the code does not say, is refused.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, bail};

use super::elf::Function;
use super::thumb::{Code, Flow, Step};

/// The most instructions that each of these functions takes, those that it calls counted with it.
///
/// # Errors
/// The ELF file cannot be read; a function has a loop, or a branch to an address that it computes.
pub fn longest(elf: &Path, functions: &[&Function]) -> Result<Vec<u64>> {
    let code = Code::read(elf)?;
    let mut known = HashMap::new();
    let most = |function: &&Function| {
        let most =
            longest_from(&code, function.address, 0, &mut known).with_context(|| function.name.clone())?;
        most.with_context(|| format!("{} does not return", function.name))
    };
    functions.iter().map(most).collect()
}

/// From an instruction to the return, both counted; None where no way returns. `conditional`: so
/// many from here on are executed on a condition. `known`: what has been worked out; none at an
/// address that a way stands at.
fn longest_from(
    code: &Code,
    address: u64,
    conditional: usize,
    known: &mut HashMap<u64, Option<Option<u64>>>,
) -> Result<Option<u64>> {
    match known.get(&address) {
        Some(Some(most)) => return Ok(*most),
        Some(None) => bail!("a loop at {address:#x}"),
        None => {}
    }
    known.insert(address, None);
    let Step { flow, length, .. } = code.step(address)?;
    let next = address + length;
    let conditional_then = match flow {
        Flow::Conditional(count) => count,
        _ => conditional.saturating_sub(1),
    };
    let mut from = |address, conditional| longest_from(code, address, conditional, known);
    let mut most = match flow {
        Flow::On | Flow::Conditional(_) => from(next, conditional_then)?,
        Flow::Jump(to) => from(to, 0)?,
        Flow::Branch(to) => from(to, 0)?.max(from(next, conditional_then)?),
        Flow::Call(to) => from(to, 0)?.zip(from(next, conditional_then)?).map(|(call, rest)| call + rest),
        Flow::Return => Some(0),
        Flow::Trap => None,
        Flow::Computed => bail!("where it goes on from {address:#x} is computed"),
    };
    if conditional > 0 && matches!(flow, Flow::Jump(_) | Flow::Call(_) | Flow::Return | Flow::Trap) {
        most = most.max(from(next, conditional_then)?);
    }
    let most = most.map(|most| most + 1);
    known.insert(address, Some(most));
    Ok(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn longest(halfwords: &[u16]) -> Result<Option<u64>> {
        longest_from(&Code::of(0x100, halfwords), 0x100, 0, &mut HashMap::new())
    }

    /// `cmp r0, #0`, `nop`, `bx lr`.
    const COMPARE: u16 = 0x2800;
    const NOP: u16 = 0xBF00;
    const RETURN: u16 = 0x4770;

    #[test]
    fn of_two_ways_the_longer_counts() -> Result<()> {
        // beq past two nops.
        assert_eq!(longest(&[COMPARE, 0xD001, NOP, NOP, RETURN])?, Some(5));
        // beq to what is longer: b over it else.
        assert_eq!(longest(&[COMPARE, 0xD000, RETURN, NOP, NOP, NOP, RETURN])?, Some(6));
        Ok(())
    }

    #[test]
    fn a_jump_leads_over_what_lies_between() -> Result<()> {
        // b over two returns, short and long.
        assert_eq!(longest(&[0xE001, RETURN, RETURN, NOP, RETURN])?, Some(3));
        assert_eq!(longest(&[0xF000, 0xB802, RETURN, RETURN, NOP, RETURN])?, Some(3));
        Ok(())
    }

    #[test]
    fn a_call_counts_what_is_called_and_what_follows() -> Result<()> {
        // push {r7, lr}; bl to the nop behind; pop {r7, pc}.
        assert_eq!(longest(&[0xB580, 0xF000, 0xF801, 0xBD80, NOP, RETURN])?, Some(5));
        Ok(())
    }

    #[test]
    fn a_return_on_a_condition_may_go_on() -> Result<()> {
        // it eq; bxeq lr; nop; bx lr.
        assert_eq!(longest(&[COMPARE, 0xBF08, RETURN, NOP, RETURN])?, Some(5));
        Ok(())
    }

    #[test]
    fn instructions_of_the_floating_point_unit_count_one() -> Result<()> {
        // vadd.f32 s0, s0, s1.
        assert_eq!(longest(&[0xEE30, 0x0A20, RETURN])?, Some(2));
        Ok(())
    }

    #[test]
    fn loops_computed_branches_and_code_that_is_not_there_are_refused() {
        // b to itself; bx r0; tbb; nothing behind a nop.
        for halfwords in [&[0xE7FE][..], &[0x4700], &[0xE8DF, 0xF000], &[NOP]] {
            assert!(longest(halfwords).is_err(), "{halfwords:x?}");
        }
    }
}
