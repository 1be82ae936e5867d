//! Frames: postcard, CRC-16, COBS, zero.

use postcard::ser_flavors::{self, Flavor};
use serde::{Serialize, de::DeserializeOwned};

/// The longest frame. Unit: byte.
pub const FRAME_BYTES: usize = 2048;

const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_IBM_SDLC);

/// A frame that holds no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`FRAME_BYTES`].
    TooLong,
    /// Stuffing, checksum or content wrong.
    Damaged,
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooLong => write!(f, "the frame is longer than {FRAME_BYTES} bytes"),
            Self::Damaged => write!(f, "the frame is damaged: stuffing, checksum or content is wrong"),
        }
    }
}

impl core::error::Error for FrameError {}

/// Writes the frame of a message into the buffer; answers the part that it takes.
///
/// # Errors
/// The buffer is too short.
pub fn encode<'a, M: Serialize>(message: &M, buffer: &'a mut [u8]) -> Result<&'a [u8], FrameError> {
    let slice = ser_flavors::Slice::new(buffer);
    let cobs = ser_flavors::Cobs::try_new(slice).map_err(|_| FrameError::TooLong)?;
    let flavor = ser_flavors::crc::CrcModifier::new(cobs, CRC.digest());
    let mut serializer = postcard::Serializer { output: flavor };
    message.serialize(&mut serializer).map_err(|_| FrameError::TooLong)?;
    serializer.output.finalize().map(|frame| &*frame).map_err(|_| FrameError::TooLong)
}

/// Gathers bytes into frames, and frames into messages.
#[derive(Debug)]
pub struct Receiver {
    frame: heapless::Vec<u8, FRAME_BYTES>,
    overflow: bool,
}

impl Receiver {
    /// A receiver at the start of a frame.
    pub const fn new() -> Self {
        Self { frame: heapless::Vec::new(), overflow: false }
    }

    /// Takes a byte. At the end of a frame answers its message, or why there is none; empty frames
    /// (a zero to get into step) are passed over.
    pub fn push<M: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<M, FrameError>> {
        if byte != 0 {
            self.overflow |= self.frame.push(byte).is_err();
            return None;
        }
        let message = match (self.overflow, self.frame.is_empty()) {
            (true, _) => Some(Err(FrameError::TooLong)),
            (false, true) => None,
            (false, false) => Some(decode(&mut self.frame)),
        };
        self.frame.clear();
        self.overflow = false;
        message
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

fn decode<M: DeserializeOwned>(frame: &mut [u8]) -> Result<M, FrameError> {
    let length = cobs::decode_in_place(frame).map_err(|_| FrameError::Damaged)?;
    let content = frame.get(..length).ok_or(FrameError::Damaged)?;
    match postcard::de_flavors::crc::take_from_bytes_u16(content, CRC.digest()) {
        Ok((message, [])) => Ok(message),
        _ => Err(FrameError::Damaged),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::{Configuration, DEAD_ZONES, PLAYS, Request, TickRequest, VERSION};
    use model_core::agpi::AgpiParameters;
    use model_core::cascade::CascadeParameters;
    use model_core::dead_zone::DeadZoneParameters;
    use model_core::egpi::EgpiParameters;
    use model_core::envelope::{EnvelopeParameters, KNOTS, PiecewiseLinearParameters};
    use model_core::extension::{
        CreepParameters, DeadbandForm, DriftParameters, ExtensionParameters, PeriodicDisturbanceParameters,
        PressureRateParameters, ProfileParameters, RateDependentThresholdsParameters,
        RateDependentWidthParameters, ScheduleParameters, Sites, SupplySaturationParameters,
        TransportDelayParameters, ValveDeadbandParameters, ValveLagForm, ValveLagParameters,
        WarmUpParameters,
    };
    use model_core::memoryless::MemorylessParameters;
    use model_core::pid::PidParameters;
    use model_core::play::PlayParameters;
    use model_core::{ModelParameters, ObserverParameters, TrackingParameters};

    fn receive(bytes: &[u8]) -> std::vec::Vec<Result<Request, FrameError>> {
        let mut receiver = Receiver::new();
        bytes.iter().filter_map(|&byte| receiver.push(byte)).collect()
    }

    fn tick() -> Request {
        Request::Tick(TickRequest {
            reference_mm: Some(12.5),
            pressure_code: 0,
            contraction_code: 4095,
            load_n: Some(NUMBER),
            temperature_c: None,
        })
    }

    /// A number without a zero byte.
    const NUMBER: f32 = 0.123_456_79;

    /// A full list.
    fn full<const L: usize>() -> model_core::List<f32, L> {
        core::iter::repeat_n(NUMBER, L).collect()
    }

    fn plays() -> PlayParameters<f32, PLAYS> {
        PlayParameters { q: NUMBER, thresholds: full(), weights: full() }
    }

    fn envelope() -> EnvelopeParameters<f32> {
        let knots: PiecewiseLinearParameters<f32, KNOTS> =
            PiecewiseLinearParameters { inputs: full(), values: full() };
        EnvelopeParameters::PiecewiseLinear(knots)
    }

    /// The largest cascade: every list full.
    fn cascade() -> Request {
        let number = NUMBER;
        configure(ModelParameters::Cascade(CascadeParameters {
            envelope: envelope(),
            plays: plays(),
            dead_zones: DeadZoneParameters { thresholds: full(), weights: full(), offset: number },
            input_min: number,
            input_max: number,
            preconditioned: true,
        }))
    }

    /// The largest model with two envelopes.
    fn two_envelopes() -> Request {
        let number = NUMBER;
        let agpi = AgpiParameters {
            rising: envelope(),
            falling: envelope(),
            plays: plays(),
            gain: number,
            offset: number,
            input_min: number,
            input_max: number,
            preconditioned: true,
        };
        let memoryless = MemorylessParameters { rises: [number; 3] };
        configure(ModelParameters::Egpi(EgpiParameters { agpi, memoryless }))
    }

    fn profile() -> ProfileParameters<f32> {
        ProfileParameters { knots: full(), values: full() }
    }

    /// All of them, every list full.
    fn extensions() -> ExtensionParameters<f32> {
        let number = NUMBER;
        let schedule = || Some(ScheduleParameters { reference: number, offset: profile() });
        ExtensionParameters {
            valve_deadband: Some(ValveDeadbandParameters { band: number, form: DeadbandForm::Hold }),
            supply_saturation: Some(SupplySaturationParameters { supply: number }),
            valve_lag: Some(ValveLagParameters {
                time_constant_s: number,
                lead_limit: number,
                form: ValveLagForm::Orifice { supply: number, outside: number },
            }),
            transport_delay: Some(TransportDelayParameters { delay_s: number }),
            load: schedule(),
            temperature: schedule(),
            warm_up: Some(WarmUpParameters { travel: number, offset: profile() }),
            viscous_lag: Some(profile()),
            inertia: Some(profile()),
            rate_dependent_width: Some(RateDependentWidthParameters {
                radius: number,
                exponent: number,
                filter_s: number,
                width: profile(),
            }),
            rate_dependent_thresholds: Some(RateDependentThresholdsParameters {
                exponent: number,
                filter_s: number,
                gain: profile(),
                pressure: Some(PressureRateParameters { gain: number, resolution: number }),
            }),
            creep: Some(CreepParameters { time_constants_s: full(), fractions: full() }),
            drift: Some(DriftParameters { rate_per_s: number, compensated: true }),
            periodic_disturbance: Some(PeriodicDisturbanceParameters {
                amplitude: number,
                frequency_hz: number,
                phase_rad: number,
                compensated: true,
            }),
            sites: Sites::default(),
        }
    }

    fn configure(model: ModelParameters<f32, PLAYS, DEAD_ZONES>) -> Request {
        let number = NUMBER;
        Request::Configure(Configuration {
            version: VERSION,
            tracking: TrackingParameters {
                model,
                extensions: extensions(),
                pid: PidParameters::paper(),
                observer: ObserverParameters::default(),
                command_min: number,
                command_max: number,
                slew_bar_per_s: number,
                period_s: number,
            },
        })
    }

    #[test]
    fn a_message_survives_its_frame() {
        for message in [tick(), cascade(), two_envelopes(), Request::Identify] {
            let mut buffer = [0; FRAME_BYTES];
            let frame = encode(&message, &mut buffer).expect("fits");
            assert_eq!(receive(frame), [Ok(message)]);
        }
    }

    #[test]
    fn every_flipped_bit_is_noticed() {
        let mut buffer = [0; FRAME_BYTES];
        let frame = encode(&tick(), &mut buffer).expect("fits").to_vec();
        for bit in 0..frame.len() * 8 {
            let mut damaged = frame.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            damaged.push(0);
            assert!(!receive(&damaged).contains(&Ok(tick())), "bit {bit}");
            assert!(receive(&damaged).iter().all(|received| received.is_err()), "bit {bit}");
        }
    }

    #[test]
    fn a_receiver_is_in_step_again_after_garbage_and_after_an_overlong_frame() {
        let mut buffer = [0; FRAME_BYTES];
        let frame = encode(&tick(), &mut buffer).expect("fits").to_vec();
        let garbage = std::vec![7_u8; 3];
        let overlong = std::vec![7_u8; FRAME_BYTES + 1];
        let bytes = [&garbage[..], &[0], &overlong, &[0], &[0], &frame].concat();
        assert_eq!(receive(&bytes), [Err(FrameError::Damaged), Err(FrameError::TooLong), Ok(tick())]);
    }
}
