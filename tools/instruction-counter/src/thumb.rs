//! Which Thumb instructions enter a function, and which leave one.

/// What an instruction does to the call stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// It calls: `bl`, `blx`.
    Call,
    /// It returns: `bx lr`, or a load of the program counter from the stack.
    Return,
    /// It goes elsewhere, and leaves the call stack as it is: `b`, `bx` of another register. Tail
    /// calls are among them.
    Jump,
    /// None of these.
    Other,
}

impl Flow {
    /// What the instruction with this encoding does: one or two halfwords, little-endian.
    pub fn of(encoding: &[u8]) -> Self {
        let halfword = |i: usize| match encoding.get(2 * i..2 * i + 2) {
            Some(&[low, high]) => u16::from_le_bytes([low, high]),
            _ => 0,
        };
        let (first, second) = (halfword(0), halfword(1));
        let loads_pc = second & 0x8000 != 0;
        match first {
            // blx register
            _ if first & 0xFF87 == 0x4780 => Self::Call,
            // bl
            _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0xD000 => Self::Call,
            // bx lr; pop {…, pc}
            0x4770 | 0xBD00..=0xBDFF => Self::Return,
            // ldm sp!, {…, pc}
            0xE8BD if loads_pc => Self::Return,
            // ldr pc, [sp], #offset
            0xF85D if second & 0xFF00 == 0xFB00 => Self::Return,
            // b; bx register
            0xE000..=0xE7FF | 0x4700..=0x477F => Self::Jump,
            // b.w
            _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0x9000 => Self::Jump,
            _ => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Flow;

    /// The encoding of one or two halfwords as it stands in memory.
    fn flow(halfwords: &[u16]) -> Flow {
        Flow::of(&halfwords.iter().flat_map(|halfword| halfword.to_le_bytes()).collect::<Vec<_>>())
    }

    // Encodings as an assembler for ARMv7E-M makes them.

    #[test]
    fn calls_are_known() {
        assert_eq!(flow(&[0xF000, 0xF801]), Flow::Call, "bl forward");
        assert_eq!(flow(&[0xF7FF, 0xFFFE]), Flow::Call, "bl back");
        assert_eq!(flow(&[0x4798]), Flow::Call, "blx r3");
    }

    #[test]
    fn returns_are_known() {
        assert_eq!(flow(&[0x4770]), Flow::Return, "bx lr");
        assert_eq!(flow(&[0xBD80]), Flow::Return, "pop {{r7, pc}}");
        assert_eq!(flow(&[0xE8BD, 0x87F0]), Flow::Return, "pop.w {{r4-r10, pc}}");
        assert_eq!(flow(&[0xF85D, 0xFB04]), Flow::Return, "ldr pc, [sp], #4");
    }

    #[test]
    fn jumps_are_known() {
        assert_eq!(flow(&[0xE7FE]), Flow::Jump, "b back");
        assert_eq!(flow(&[0xF000, 0xB801]), Flow::Jump, "b.w forward");
        assert_eq!(flow(&[0x4718]), Flow::Jump, "bx r3");
    }

    #[test]
    fn the_rest_is_none_of_them() {
        assert_eq!(flow(&[0xF000, 0x8001]), Flow::Other, "beq.w forward");
        assert_eq!(flow(&[0xBC80]), Flow::Other, "pop {{r7}}");
        assert_eq!(flow(&[0xE8BD, 0x07F0]), Flow::Other, "pop.w {{r4-r10}}");
        assert_eq!(flow(&[0xF85D, 0x7B04]), Flow::Other, "ldr r7, [sp], #4");
        assert_eq!(flow(&[0xE8DF, 0xF003]), Flow::Other, "tbb [pc, r3]");
    }
}
