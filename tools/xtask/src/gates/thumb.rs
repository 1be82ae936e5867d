//! The instructions of an image: where each leads, and what it takes of the stack.

use std::path::Path;

use anyhow::{Context, Result, bail};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSection};
use yaxpeax_arch::{Decoder, U8Reader};
use yaxpeax_arm::armv7::{ConditionCode, InstDecoder, Instruction, Opcode, Operand, Reg};

/// The number of the program counter among the registers, and those of the one that says where to
/// return and of the stack's.
const PROGRAM_COUNTER: u8 = 15;
const LINK: u8 = 14;
const STACK: u8 = 13;
/// First halfwords of the floating-point unit's instructions, which the decoder leaves out; none of
/// them branches.
const FLOATING_POINT: std::ops::RangeInclusive<u16> = 0xEC00..=0xEFFF;
/// First halfword of the one that puts such registers on the stack, but for one bit of their
/// number.
const PUSH_FLOATS: u16 = 0xED2D;
const ANY_FLOATS: u16 = 0x0040;

/// Where an instruction leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// On.
    On,
    /// To an address.
    Jump(u64),
    /// There or on.
    Branch(u64),
    /// There, and when that returns on.
    Call(u64),
    /// Back to the caller.
    Return,
    /// So many of the next ones are executed on a condition.
    Conditional(usize),
    /// Nowhere: it is not to be reached.
    Trap,
    /// Where the code does not say.
    Computed,
}

/// What an instruction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Where it leads.
    pub flow: Flow,
    /// Unit: byte.
    pub length: u64,
    /// What it takes of the stack. Unit: byte; none where the code does not say.
    pub taken: Option<u64>,
}

/// The instructions of an image.
pub struct Code {
    address: u64,
    bytes: Vec<u8>,
}

impl Code {
    /// Of halfwords from an address on.
    #[cfg(test)]
    pub fn of(address: u64, halfwords: &[u16]) -> Self {
        Self { address, bytes: halfwords.iter().flat_map(|word| word.to_le_bytes()).collect() }
    }

    /// Reads those of an ELF file.
    ///
    /// # Errors
    /// It cannot be read, or has none.
    pub fn read(elf: &Path) -> Result<Self> {
        let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
        let file = ElfFile32::<LittleEndian>::parse(&*bytes)?;
        let text = file.section_by_name(".text").context("it has no code")?;
        Ok(Self { address: text.address(), bytes: text.data()?.to_vec() })
    }

    /// What the instruction at an address does.
    ///
    /// # Errors
    /// There is none, or it is not known.
    pub fn step(&self, address: u64) -> Result<Step> {
        let offset = address.checked_sub(self.address).and_then(|offset| usize::try_from(offset).ok());
        let bytes = offset.and_then(|offset| self.bytes.get(offset..)).unwrap_or_default();
        let &[low, high, ..] = bytes else { bail!("{address:#x} is not in the code") };
        let first = u16::from_le_bytes([low, high]);
        if FLOATING_POINT.contains(&first) {
            // The last byte of the number of words.
            let words = bytes.get(2).filter(|_| first & !ANY_FLOATS == PUSH_FLOATS);
            return Ok(Step {
                flow: Flow::On,
                length: 4,
                taken: Some(words.map_or(0, |words| 4 * u64::from(*words))),
            });
        }
        let length = if first >= 0xE800 { 4 } else { 2 };
        let decoded = InstDecoder::default_thumb().decode(&mut U8Reader::new(bytes));
        let Ok(instruction) = decoded else { bail!("{first:#x} at {address:#x} is not known") };
        Ok(Step { flow: flow(&instruction, address, length), length, taken: taken(&instruction) })
    }
}

fn is(register: u8, operand: &Operand) -> bool {
    matches!(operand, Operand::Reg(found) if found.number() == register)
}

/// Where an instruction leads that stands at an address.
fn flow(instruction: &Instruction, address: u64, length: u64) -> Flow {
    let is_short_jump =
        length == 2 && instruction.opcode == Opcode::B && instruction.condition == ConditionCode::AL;
    // The decoder counts from the next instruction, but for this one, as the processor does, from
    // four bytes on.
    let from = address + if is_short_jump { 4 } else { length };
    let to = instruction.operands.iter().find_map(|operand| match operand {
        Operand::BranchThumbOffset(halfwords) => from.checked_add_signed(i64::from(*halfwords) * 2),
        _ => None,
    });
    let said = |flow: fn(u64) -> Flow| to.map_or(Flow::Computed, flow);
    let [first, ..] = &instruction.operands;
    match instruction.opcode {
        Opcode::B if instruction.condition == ConditionCode::AL => said(Flow::Jump),
        Opcode::B | Opcode::CBZ | Opcode::CBNZ => said(Flow::Branch),
        Opcode::BL => said(Flow::Call),
        Opcode::BX if is(LINK, first) => Flow::Return,
        Opcode::BX | Opcode::BLX | Opcode::TBB | Opcode::TBH => Flow::Computed,
        Opcode::UDF => Flow::Trap,
        Opcode::IT => match instruction.operands[1] {
            Operand::Imm32(mask) => Flow::Conditional(4 - (mask.trailing_zeros() as usize).min(3)),
            _ => Flow::Computed,
        },
        Opcode::POP | Opcode::LDM(..) => {
            let loads = |operand: &Operand| matches!(operand, Operand::RegList(list) if list >> PROGRAM_COUNTER & 1 == 1);
            if instruction.operands.iter().any(loads) { Flow::Return } else { Flow::On }
        }
        // What else writes the program counter: a return from one register on the stack, or a jump
        // that is computed.
        Opcode::LDR if is(PROGRAM_COUNTER, first) => Flow::Return,
        Opcode::MOV | Opcode::ADD if is(PROGRAM_COUNTER, first) => Flow::Computed,
        _ => Flow::On,
    }
}

/// What an instruction takes of the stack. Unit: byte; none where it does not say.
fn taken(instruction: &Instruction) -> Option<u64> {
    let is_stack = |register: &Reg| register.number() == STACK;
    match (instruction.opcode, &instruction.operands) {
        (Opcode::PUSH, [Operand::RegList(list), ..]) => Some(4 * u64::from(list.count_ones())),
        (Opcode::SUB, [to, from, Operand::Imm32(bytes), ..]) if is(STACK, to) && is(STACK, from) => {
            Some(u64::from(*bytes))
        }
        // Down before it is written to.
        (Opcode::STR, [_, Operand::RegDerefPreindexOffset(base, bytes, false, true), ..])
        | (Opcode::STRD, [_, _, Operand::RegDerefPreindexOffset(base, bytes, false, true), ..])
            if is_stack(base) =>
        {
            Some(u64::from(*bytes))
        }
        (Opcode::SUB | Opcode::MOV, [to, ..]) if is(STACK, to) => None,
        _ => Some(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_pushed_or_subtracted_is_taken_of_the_stack() -> Result<()> {
        for (halfwords, bytes) in [
            // push {r7, lr}; push.w {r4 to r11, lr}; str r11, [sp, #-4]!.
            (&[0xB580][..], 8),
            (&[0xE92D, 0x4FF0], 36),
            (&[0xF84D, 0xBD04], 4),
            // vpush {d8 to d15}; vpush {s16}.
            (&[0xED2D, 0x8B10], 64),
            (&[0xED2D, 0x8A01], 4),
            // sub sp, #8; sub.w sp, sp, #10368; subw sp, sp, #1028.
            (&[0xB082], 8),
            (&[0xF5AD, 0x5D22], 10368),
            (&[0xF2AD, 0x4D04], 1028),
            // add sp, #8; sub r0, #8; vadd.f32 s0, s0, s1.
            (&[0xB002], 0),
            (&[0x3808], 0),
            (&[0xEE30, 0x0A20], 0),
        ] {
            assert_eq!(Code::of(0, halfwords).step(0)?.taken, Some(bytes), "{halfwords:x?}");
        }
        Ok(())
    }

    #[test]
    fn a_stack_that_a_register_moves_is_not_said() -> Result<()> {
        // sub.w sp, sp, r0.
        assert_eq!(Code::of(0, &[0xEBAD, 0x0D00]).step(0)?.taken, None);
        Ok(())
    }
}
