//! The longest way through a function, over all its branches: whatever it is given, it takes no more instructions.
//!
//! Where sizes are known when the firmware is compiled, the control law has no loops, so that its ways can be followed one and all.
//! Not all of them need be possible, for what one comparison has told may contradict another: it is an upper bound, beside which
//! what samples have taken stands as a lower one.
//!
//! # Limits
//! A function that goes back, or on to where the code does not say, is refused.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSection};
use yaxpeax_arch::{Decoder, U8Reader};
use yaxpeax_arm::armv7::{ConditionCode, InstDecoder, Instruction, Opcode, Operand};

use super::elf::Function;

/// The number of the program counter among the registers, and that of the one that says where to return.
const PROGRAM_COUNTER: u8 = 15;
const LINK: u8 = 14;
/// First halfwords of the floating-point unit's instructions, which the decoder leaves out; none of them branches.
const FLOATING_POINT: std::ops::RangeInclusive<u16> = 0xEC00..=0xEFFF;

/// Where an instruction leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flow {
    On,
    /// To an address.
    Jump(u64),
    /// There or on.
    Branch(u64),
    /// There, and when that returns on.
    Call(u64),
    Return,
    /// So many of the next ones are executed on a condition.
    Conditional(usize),
    /// Nowhere: it is not to be reached.
    Trap,
}

/// The instructions of an image.
struct Code {
    address: u64,
    bytes: Vec<u8>,
}

/// The most instructions that each of these functions takes, those that it calls counted with it.
///
/// # Errors
/// The ELF file cannot be read; a function has a loop, or a branch to an address that it computes.
pub fn longest(elf: &Path, functions: &[&Function]) -> Result<Vec<u64>> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = ElfFile32::<LittleEndian>::parse(&*bytes)?;
    let text = file.section_by_name(".text").context("it has no code")?;
    let code = Code { address: text.address(), bytes: text.data()?.to_vec() };
    let mut known = HashMap::new();
    let most = |function: &&Function| {
        let most = code.longest(function.address, 0, &mut known).with_context(|| function.name.clone())?;
        most.with_context(|| format!("{} does not return", function.name))
    };
    functions.iter().map(most).collect()
}

impl Code {
    /// From an instruction to the return, both counted; None where no way returns. `conditional`: so many from here on are executed
    /// on a condition. `known`: what has been worked out; none at an address that a way stands at.
    fn longest(
        &self,
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
        let (flow, length) = self.instruction(address)?;
        let next = address + length;
        let conditional_then = match flow {
            Flow::Conditional(count) => count,
            _ => conditional.saturating_sub(1),
        };
        let mut from = |address, conditional| self.longest(address, conditional, known);
        let mut most = match flow {
            Flow::On | Flow::Conditional(_) => from(next, conditional_then)?,
            Flow::Jump(to) => from(to, 0)?,
            Flow::Branch(to) => from(to, 0)?.max(from(next, conditional_then)?),
            Flow::Call(to) => from(to, 0)?.zip(from(next, conditional_then)?).map(|(call, rest)| call + rest),
            Flow::Return => Some(0),
            Flow::Trap => None,
        };
        if conditional > 0 && matches!(flow, Flow::Jump(_) | Flow::Call(_) | Flow::Return | Flow::Trap) {
            most = most.max(from(next, conditional_then)?);
        }
        let most = most.map(|most| most + 1);
        known.insert(address, Some(most));
        Ok(most)
    }

    /// Where an instruction leads, and its length in bytes.
    fn instruction(&self, address: u64) -> Result<(Flow, u64)> {
        let offset = address.checked_sub(self.address).and_then(|offset| usize::try_from(offset).ok());
        let bytes = offset.and_then(|offset| self.bytes.get(offset..)).unwrap_or_default();
        let &[low, high, ..] = bytes else { bail!("{address:#x} is not in the code") };
        let first = u16::from_le_bytes([low, high]);
        if FLOATING_POINT.contains(&first) {
            return Ok((Flow::On, 4));
        }
        let length = if first >= 0xE800 { 4 } else { 2 };
        let decoded = InstDecoder::default_thumb().decode(&mut U8Reader::new(bytes));
        let Ok(instruction) = decoded else { bail!("{first:#x} at {address:#x} is not known") };
        let flow = flow(&instruction, address, length);
        Ok((
            flow.with_context(|| format!("{:?} at {address:#x} cannot be followed", instruction.opcode))?,
            length,
        ))
    }
}

/// Where an instruction leads that stands at an address; None where it does not say.
fn flow(instruction: &Instruction, address: u64, length: u64) -> Option<Flow> {
    let is_short_jump =
        length == 2 && instruction.opcode == Opcode::B && instruction.condition == ConditionCode::AL;
    // The decoder counts from the next instruction, but for this one, as the processor does, from four bytes on.
    let from = address + if is_short_jump { 4 } else { length };
    let to = instruction.operands.iter().find_map(|operand| match operand {
        Operand::BranchThumbOffset(halfwords) => from.checked_add_signed(i64::from(*halfwords) * 2),
        _ => None,
    });
    let is =
        |register, operand: &Operand| matches!(operand, Operand::Reg(found) if found.number() == register);
    let [first, ..] = &instruction.operands;
    match instruction.opcode {
        Opcode::B if instruction.condition == ConditionCode::AL => to.map(Flow::Jump),
        Opcode::B | Opcode::CBZ | Opcode::CBNZ => to.map(Flow::Branch),
        Opcode::BL => to.map(Flow::Call),
        Opcode::BX => is(LINK, first).then_some(Flow::Return),
        Opcode::BLX | Opcode::TBB | Opcode::TBH => None,
        Opcode::UDF => Some(Flow::Trap),
        Opcode::IT => match instruction.operands[1] {
            Operand::Imm32(mask) => Some(Flow::Conditional(4 - (mask.trailing_zeros() as usize).min(3))),
            _ => None,
        },
        Opcode::POP | Opcode::LDM(..) => {
            let loads = |operand: &Operand| matches!(operand, Operand::RegList(list) if list >> PROGRAM_COUNTER & 1 == 1);
            Some(if instruction.operands.iter().any(loads) { Flow::Return } else { Flow::On })
        }
        // What else writes the program counter: a return from one register on the stack, or a jump that is computed.
        Opcode::LDR if is(PROGRAM_COUNTER, first) => Some(Flow::Return),
        Opcode::MOV | Opcode::ADD if is(PROGRAM_COUNTER, first) => None,
        _ => Some(Flow::On),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn longest(halfwords: &[u16]) -> Result<Option<u64>> {
        let code =
            Code { address: 0x100, bytes: halfwords.iter().flat_map(|word| word.to_le_bytes()).collect() };
        code.longest(0x100, 0, &mut HashMap::new())
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
