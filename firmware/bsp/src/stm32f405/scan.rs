//! The analogue inputs: ADC1, started by a timer, finished before the tick asks.
//!
//! # Design
//! TIM2 runs at the tick's rate, shifted so that its period ends a scan and a twentieth before the
//! tick is due. That starts the regular group: pressure and contraction, [`CONVERSIONS`] times in
//! turn, taken by DMA into a ring of one scan. Behind it the injected group follows by itself: what
//! has to be known once a tick, each with a data register of its own. The tick looks whether all is
//! there, and never waits. Both clocks come from one oscillator, so that the shift stays.
//!
//! What the tick is given of pressure and contraction is the mean of its conversions: their noise
//! divided by the root of [`CONVERSIONS`]. How large it is the supervisor tells
//! ([`Scan::noise`]).
//!
//! # Timing
//! Pressure and contraction are sampled for 84 ADC clocks, for a source of up to 10 kΩ behind the
//! input filter; so are supply and output. Temperature and reference need 10 µs, which are 480
//! clocks. 12 more each to convert: 2,712 clocks, 129 µs at 21 MHz, 678 µs at the fall-back's 4
//! MHz. The mean of the contraction is sampled 4.6 µs after that of the pressure.

pub mod joint;

use core::cell::UnsafeCell;

use firmware::noise::{CONVERSIONS, Conversions};
use firmware::{AcquisitionError, AdcCode, Samples};
use model_core::Surroundings;
use stm32f4::stm32f405::{ADC_COMMON, ADC1, DBGMCU, DMA2, TIM2};

use super::clock::Clocks;
use super::factory::Factory;
use super::output;

/// Channels in turn: pressure at PA0, contraction at PA1.
const PRESSURE: u8 = 0;
const CONTRACTION: u8 = 1;
/// In the order of conversion: the processor's temperature and reference, then PC0 and PA4.
const ONCE: [u8; 4] = [16, 17, 10, 4];
/// From the start of the first conversion to the end of the last, and a twentieth more. Unit: ADC
/// clock.
const SCAN_CLOCKS: u32 = 2_850;
/// Of the peripheral clock that feeds the converter.
const ADC_DIVIDER: u32 = 4;
/// Unit: conversion.
const REGULAR: u8 = 2 * CONVERSIONS as u8;
/// What stands for samples when there are none: no code of 12 bits.
const NOTHING: u64 = u64::MAX;

/// Which channels are converted, in their order: by the regular group, and by the injected one.
struct Sequence {
    regular: [u8; REGULAR as usize],
    once: [u8; 4],
}

/// What the DMA writes: contraction in the high half, pressure in the low, in turn.
#[repr(transparent)]
struct Ring(UnsafeCell<[u32; CONVERSIONS]>);

// SAFETY: the DMA writes it, whatever owns it; the program only reads, by whole words.
unsafe impl Sync for Ring {}

static RING: Ring = Ring(UnsafeCell::new([0; CONVERSIONS]));

impl Ring {
    fn word(&self, place: usize) -> u32 {
        // SAFETY: the place is within the ring, by the callers' loops; volatile, since it changes
        // behind the compiler's back.
        unsafe { self.0.get().cast::<u32>().add(place).read_volatile() }
    }
}

/// The running converter.
pub struct Scan {
    adc: ADC1,
    dma: DMA2,
    /// None in an emulator, which has no converter and no factory values.
    factory: Option<Factory>,
}

impl Scan {
    /// Readies the converter; [`start`](Self::start) lets it run. Converter and DMA have to be
    /// clocked.
    pub fn new(adc: ADC1, common: &ADC_COMMON, dma: DMA2, debug: &DBGMCU) -> Self {
        let regular = core::array::from_fn(|place| if place % 2 == 0 { PRESSURE } else { CONTRACTION });
        Self::ready(adc, common, dma, debug, &Sequence { regular, once: ONCE })
    }

    fn ready(adc: ADC1, common: &ADC_COMMON, dma: DMA2, debug: &DBGMCU, sequence: &Sequence) -> Self {
        let stream = dma.st(0);
        // SAFETY: it moves half words, twice as many as the ring has words, to the ring, which is
        // there for good.
        unsafe {
            stream.ndtr().write(|w| w.ndt().set(REGULAR.into()));
            stream.par().write(|w| w.pa().bits(adc.dr().as_ptr() as u32));
            stream.m0ar().write(|w| w.m0a().bits(RING.0.get() as u32));
        }
        stream.cr().write(|w| {
            w.chsel().set(0).psize().bits16().msize().bits16().minc().incremented().circ().enabled();
            w.dir().peripheral_to_memory().pl().very_high().en().enabled()
        });
        common.ccr().write(|w| w.adcpre().div4().tsvrefe().enabled());
        adc.cr1().write(|w| w.scan().enabled().jauto().enabled());
        adc.smpr1()
            .write(|w| w.smp16().cycles480().smp17().cycles480().smp10().cycles84().smp11().cycles84());
        adc.smpr2().write(|w| w.smp0().cycles84().smp1().cycles84().smp4().cycles84().smp5().cycles84());
        let [first, second, third, fourth] = sequence.once;
        // SAFETY: the channels exist.
        unsafe {
            let in_turn = |from: usize| {
                let channels = sequence.regular.iter().skip(from).take(6).zip(0_u32..);
                channels.fold(0, |bits, (channel, place)| bits | u32::from(*channel) << (5 * place))
            };
            adc.sqr3().write(|w| w.bits(in_turn(0)));
            adc.sqr2().write(|w| w.bits(in_turn(6)));
            adc.sqr1().write(|w| w.bits(in_turn(12) | u32::from(REGULAR - 1) << 20));
            adc.jsqr().write(|w| {
                w.jl().set(3).jsq1().bits(first).jsq2().bits(second).jsq3().bits(third).jsq4().bits(fourth)
            });
            adc.cr2().write(|w| {
                w.adon().enabled().dma().enabled().dds().continuous();
                w.extsel().tim2trgo().exten().rising_edge()
            });
        }
        Self { adc, dma, factory: Factory::of_chip(debug) }
    }

    /// Starts the timer that starts the conversions; the clock of the tick has to be started right
    /// after.
    pub fn start(timer: &TIM2, clocks: &Clocks, ticks_per_second: u32) {
        let period = clocks.timer_hz / ticks_per_second;
        let lead = SCAN_CLOCKS * ADC_DIVIDER * (clocks.timer_hz / 1000) / (clocks.fast_bus_hz / 1000);
        timer.arr().write(|w| w.arr().set(period - 1));
        timer.cnt().write(|w| w.cnt().set(lead));
        timer.cr2().write(|w| w.mms().update());
        timer.cr1().write(|w| w.cen().enabled());
    }

    /// The samples that were converted for this tick.
    pub fn read(&mut self) -> Result<Samples, AcquisitionError> {
        match adc_scan(&self.adc, &self.dma) {
            NOTHING => Err(AcquisitionError),
            packed => {
                let code = |place: u32| AdcCode((packed >> (16 * place)) as u16);
                let own = |register: usize| AdcCode(self.adc.jdr(register).read().jdata().bits());
                let factory = self.factory.as_ref();
                Ok(Samples {
                    temperature: factory.map_or(code(0), |factory| factory.temperature.typical(code(0))),
                    supply: code(1),
                    pressure: code(2),
                    contraction: code(3),
                    reference: factory.map(|factory| factory.reference.typical(own(1))),
                    output: factory.filter(|_| output::IS_READ_BACK).map(|_| own(3)),
                    // This board measures neither.
                    surroundings: Surroundings { load: None, temperature: None },
                })
            }
        }
    }

    /// The conversions of the last scan: those of one may be mixed with those of the next, by
    /// whoever does not look right behind a tick.
    pub fn conversions() -> [Conversions; 2] {
        let words: [u32; CONVERSIONS] = core::array::from_fn(|place| RING.word(place));
        [words.map(|word| word as u16), words.map(|word| (word >> 16) as u16)]
    }
}

/// Four codes, 16 bits each, the first lowest: temperature, supply, and the means of pressure and
/// contraction; or [`NOTHING`].
///
/// Never inlined, and with a name of its own, so that a debugger can put other values in its place:
/// the emulator has no converter. Without a loop, so that its instructions can be counted.
// SAFETY: nothing else in the image has this name.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn adc_scan(adc: &ADC1, dma: &DMA2) -> u64 {
    if !is_complete(adc, dma) {
        return NOTHING;
    }
    // Eight codes of 12 bits stay within their half of a word.
    let [a, b, c, d, e, f, g, h] = [0, 1, 2, 3, 4, 5, 6, 7].map(|place| RING.word(place));
    let sums = (a + b) + (c + d) + ((e + f) + (g + h));
    let mean = |sum: u32| u64::from((sum + CONVERSIONS as u32 / 2) / CONVERSIONS as u32);
    let code = |register: usize| u64::from(adc.jdr(register).read().jdata().bits());
    code(0) | code(2) << 16 | mean(sums & 0xFFFF) << 32 | mean(sums >> 16) << 48
}

/// Whether a scan has been converted since the last call, all of it.
#[inline(always)]
fn is_complete(adc: &ADC1, dma: &DMA2) -> bool {
    if adc.sr().read().jeoc().bit_is_clear() || dma.lisr().read().tcif0().bit_is_clear() {
        return false;
    }
    // The bits of the first register are cleared by zeros and kept by ones, those of the other by
    // ones.
    adc.sr().modify(|_, w| w.jeoc().clear_bit());
    dma.lifcr().write(|w| w.ctcif0().clear());
    true
}

const _: () = assert!(CONVERSIONS == 8, "a sum of more does not stay within its half, of fewer is left out");
