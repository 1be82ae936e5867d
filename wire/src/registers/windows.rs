//! What stands in the windows: bytes, captured samples, the trace of a fault.

use crate::{CaptureSample, TraceEntry};

/// Registers of the upload's window.
pub const UPLOAD_REGISTERS: u16 = 120;
/// Size of the upload's buffer: the largest configuration fits. Unit: byte.
pub const UPLOAD_BYTES: usize = crate::FRAME_BYTES;
/// Registers of the message, two characters each.
pub const MESSAGE_REGISTERS: u16 = 50;
/// The most points that are pushed at once.
pub const STREAM_POINTS: u16 = 60;
/// Places of the queue.
pub const QUEUE_POINTS: u16 = 256;
/// Registers before the samples of the capture's window: number of the first, its tick, how many.
pub const CAPTURE_HEAD: u16 = 5;
/// Samples of the capture's window.
pub const CAPTURE_SAMPLES: u16 = 24;
/// Registers of a captured sample.
pub const SAMPLE_REGISTERS: u16 = 5;
/// Registers of an entry of the trace.
pub const TRACE_ENTRY_REGISTERS: u16 = 7;

/// Codes of the reference in a captured sample. Unit: 1/mm.
const REFERENCE_PER_MM: f32 = 128.0;

/// The everyday CRC-32, that of an upload.
pub(crate) static CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// The CRC-32 of an upload (ISO-HDLC, as in zip).
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Two bytes in a register, the first one in its high half; behind an odd last byte stands 0.
pub fn pack_bytes(bytes: &[u8]) -> impl Iterator<Item = u16> {
    bytes.chunks(2).map(|pair| match *pair {
        [high, low] => u16::from_be_bytes([high, low]),
        [high] => u16::from_be_bytes([high, 0]),
        _ => 0,
    })
}

/// The bytes of registers.
pub fn bytes_of(words: &[u16]) -> impl Iterator<Item = u8> {
    words.iter().flat_map(|word| word.to_be_bytes())
}

/// A captured sample: reference (i16, 1/128 mm), pressure, contraction, valve (codes), feedback
/// (i16, 1/4096 bar).
pub const fn pack_sample(sample: &CaptureSample) -> [u16; SAMPLE_REGISTERS as usize] {
    [
        ((REFERENCE_PER_MM * sample.reference_mm) as i16).cast_unsigned(),
        sample.pressure_code,
        sample.contraction_code,
        sample.dac_code,
        sample.feedback_4096th_bar.cast_unsigned(),
    ]
}

/// The sample of [`pack_sample`].
pub fn unpack_sample(words: [u16; SAMPLE_REGISTERS as usize]) -> CaptureSample {
    let [reference, pressure_code, contraction_code, dac_code, feedback] = words;
    CaptureSample {
        reference_mm: f32::from(reference.cast_signed()) / REFERENCE_PER_MM,
        pressure_code,
        contraction_code,
        dac_code,
        feedback_4096th_bar: feedback.cast_signed(),
    }
}

/// An entry of the trace: tick (u32), pressure, contraction, supply, valve (codes), reference (i16,
/// 1/64 mm).
pub const fn pack_trace_entry(entry: &TraceEntry) -> [u16; TRACE_ENTRY_REGISTERS as usize] {
    [
        (entry.tick >> 16) as u16,
        entry.tick as u16,
        entry.pressure_code,
        entry.contraction_code,
        entry.supply_code,
        entry.dac_code,
        entry.reference_64th_mm.cast_unsigned(),
    ]
}

/// The entry of [`pack_trace_entry`].
pub fn unpack_trace_entry(words: [u16; TRACE_ENTRY_REGISTERS as usize]) -> TraceEntry {
    let [high, low, pressure_code, contraction_code, supply_code, dac_code, reference] = words;
    TraceEntry {
        tick: u32::from(high) << 16 | u32::from(low),
        pressure_code,
        contraction_code,
        supply_code,
        dac_code,
        reference_64th_mm: reference.cast_signed(),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn samples_and_entries_survive_their_registers() {
        let sample = CaptureSample {
            reference_mm: -12.5,
            pressure_code: 1,
            contraction_code: 4095,
            dac_code: 77,
            feedback_4096th_bar: -4096,
        };
        assert_eq!(unpack_sample(pack_sample(&sample)), sample);
        let entry = TraceEntry {
            tick: 0x0102_0304,
            pressure_code: 5,
            contraction_code: 6,
            supply_code: 7,
            dac_code: 8,
            reference_64th_mm: -9,
        };
        assert_eq!(unpack_trace_entry(pack_trace_entry(&entry)), entry);
    }

    #[test]
    fn bytes_survive_their_registers_and_an_odd_one_is_filled_up() {
        let words: std::vec::Vec<_> = pack_bytes(&[1, 2, 3]).collect();
        assert_eq!(words, [0x0102, 0x0300]);
        assert!(bytes_of(&words).eq([1, 2, 3, 0]));
    }
}
