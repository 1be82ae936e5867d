//! The bring-up image: tests a new board part by part, and tells what each part shows by lines over
//! the service link (`wire::bring_up`, docs/bring-up.md). It is flashed by a debugger before the
//! production image, and stands where that has its starter.
//!
//! # Safety
//! The valve's output stays let go of, which is 0 V, but for half a second in a run that asks for
//! the output; the dump valve's output stays an input throughout, so that the dump valve is open,
//! and the bus is driven only in a run that asks for its echo. A panic, a fault of the processor
//! and a hanging program end in a reset, as in service.
//!
//! # Design
//! One loop with the interrupts off. It sleeps until one is due, of the tick or of a port, and then
//! does what its task would do. So nothing runs beside a measurement.
#![no_std]
#![no_main]

use bsp::link::LinkLine;
use bsp::safe_end::SafeEnd;
use bsp::serial::{self, Buffers, Line, Mover, Port};
use bsp::stm32f405::bring_up::oscillators::{Stopwatch, crystal_hz};
use bsp::stm32f405::bring_up::{flash_cycle, flash_size_kb, resistors};
use bsp::stm32f405::clock::{self, Source};
use bsp::stm32f405::flash::Flash;
use bsp::stm32f405::pins::{self, BusDriver, Light, VoltageDetector};
use bsp::stm32f405::scan::Scan;
use bsp::stm32f405::tick::{TICKS_PER_SECOND, Tick};
use bsp::stm32f405::watchdog::HardwareWatchdog;
use bsp::stm32f405::{memory, memory_test, output, valve};
use core::fmt::Write;
use cortex_m::peripheral::{NVIC, SCB};
use defmt_rtt as _;
use firmware::board::Valve;
use firmware::bring_up::{self as parts, Codes, Part, Report, ReportLine};
use firmware::faults::black_box::Reset;
use firmware::identity::Identity;
use firmware::scaling::{REFERENCE_SUPPLY_V, TEMPERATURE, VENT};
use firmware::{DacCode, Samples};
use heapless::String;
use stm32f4::stm32f405::{Interrupt, Peripherals, RCC, USART1, USART2};
use wire::Fault;
use wire::bring_up::{LINE_BYTES, NONE, Wanted};
use wire::registers;

/// Ticks that the inputs are looked at for.
const TICKS: u32 = 256;
/// Ticks that the output has before it is read back.
const SETTLING_TICKS: u32 = 20;
/// Ticks that a line has to leave in: it takes two.
const LEAVING_TICKS: u32 = 50;
/// Ticks that the echo has: it takes two.
const ECHO_TICKS: u32 = 20;

/// Vents, and begins again.
enum Again {}

impl SafeEnd for Again {
    fn make_safe() {
        valve::vent();
    }

    fn end(_: Fault, _: u32) -> ! {
        SCB::sys_reset()
    }
}

bsp::end_safely!(Again);
bsp::test_memory!();

/// Room for a request and for a line of the report.
type LinkBuffers = Buffers<u8, { LINE_BYTES + 1 }, { LINE_BYTES + 1 }>;
/// Room for the pattern that is sent, each way.
type BusBuffers = Buffers<u8, { ECHO_ROOM }, { ECHO_ROOM }>;
const ECHO_ROOM: usize = 2 * parts::ECHO_PATTERN.len();

/// The bus, whose echo is what is looked for.
struct BusLine(BusDriver);

impl Line for BusLine {
    const BAUD: u32 = registers::BAUD;
    const PORT: Interrupt = Interrupt::USART1;
    const TASK: Interrupt = Interrupt::SPI1;
    const HAS_ECHO: bool = false;
    type Received = u8;

    fn received(&self, byte: u8) -> u8 {
        byte
    }

    fn drive(&mut self, drives: bool) {
        self.0.set(drives);
    }
}

/// The board, and what its start has shown.
struct Bench {
    link: (Mover<USART2, LinkLine>, Port<LinkLine>),
    bus: (Mover<USART1, BusLine>, Port<BusLine>),
    scan: Scan,
    valve: output::Output,
    flash: Flash,
    stopwatch: Stopwatch,
    registers: RCC,
    watchdog: HardwareWatchdog,
    shown: Shown,
    report: Report,
}

/// What only the start can tell.
struct Shown {
    reset: Reset,
    identity: Identity,
    brown_out_level: u8,
    is_supplied: bool,
    crystal_hz: Option<f32>,
    source: Source,
    resistors: [(&'static str, bool); 3],
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut LINK: LinkBuffers = LinkBuffers::new();
    static mut BUS: BusBuffers = BusBuffers::new();
    cortex_m::interrupt::disable();
    // They are there: nobody has taken them.
    let (Some(device), Some(core)) = (Peripherals::take(), cortex_m::Peripherals::take()) else {
        SCB::sys_reset()
    };
    let mut bench = Bench::start(device, core, LINK, BUS);
    let mut line = String::<LINE_BYTES>::new();
    loop {
        bench.wait();
        while let Some(byte) = bench.link.1.read() {
            if byte != b'\n' {
                // What is too long is no request.
                let _ = line.push(byte.into());
            } else {
                let wanted = Wanted::of_line(&line);
                line.clear();
                wanted.into_iter().for_each(|wanted| bench.run(wanted));
            }
        }
        if line.len() == line.capacity() {
            line.clear();
        }
    }
}

impl Bench {
    fn start(
        device: Peripherals,
        core: cortex_m::Peripherals,
        link: &'static mut LinkBuffers,
        bus: &'static mut BusBuffers,
    ) -> Self {
        clock::feed_peripherals(&device.RCC);
        let watchdog = HardwareWatchdog::start(device.IWDG, &device.DBGMCU);
        let reset = memory::reset_cause(&device.RCC);
        let is_supplied = VoltageDetector::start(device.PWR, &device.EXTI).wait();
        let resistors = resistors::keep_low();
        // Behind a reset the processor runs from the internal oscillator.
        let crystal_hz = crystal_hz(&device.RCC, &device.TIM11);
        // By a wrong crystal the link would have a wrong rate, and nobody could read what is told.
        let has_crystal = crystal_hz.is_some_and(|hz| parts::CRYSTAL_HZ.admits(hz));
        let clocks = clock::start(&device.RCC, &device.FLASH, &device.DBGMCU, is_supplied && has_crystal);
        let identity = memory::identity(&device.DBGMCU);
        let brown_out_level = memory::brown_out_level(&device.FLASH);
        pins::route(&device.GPIOA, &device.GPIOB, &device.GPIOC, false);
        let valve = output::vented(device.DAC, device.TIM3, clocks.timer_hz);
        let scan = Scan::new(device.ADC1, &device.ADC_COMMON, device.DMA2, &device.DBGMCU);
        Scan::start(&device.TIM2, &clocks, TICKS_PER_SECOND);
        // Its interrupt is looked at, never taken.
        Tick::start(core.SYST, clocks.core_hz);
        let stopwatch = Stopwatch::start(&device.RCC, device.TIM5, clocks.timer_hz);
        // SAFETY: the interrupts stay off; these two end the sleep.
        unsafe {
            NVIC::unmask(Interrupt::USART1);
            NVIC::unmask(Interrupt::USART2);
        }
        let bus_line = BusLine(BusDriver::listening(device.GPIOA));
        Self {
            link: serial::open(device.USART2, clocks.slow_bus_hz, LinkLine, link),
            bus: serial::open(device.USART1, clocks.fast_bus_hz, bus_line, bus),
            scan,
            valve,
            flash: Flash::new(device.FLASH),
            stopwatch,
            registers: device.RCC,
            watchdog,
            shown: Shown {
                reset,
                identity,
                brown_out_level,
                is_supplied,
                crystal_hz,
                source: clocks.source,
                resistors,
            },
            report: Report::default(),
        }
    }

    /// Sleeps until something is due, and does it; whether it was the tick.
    fn wait(&mut self) -> bool {
        cortex_m::asm::wfi();
        let is_tick = SCB::is_pendst_pending();
        if is_tick {
            SCB::clear_pendst();
            self.watchdog.feed(false);
        }
        NVIC::unpend(Interrupt::USART1);
        NVIC::unpend(Interrupt::USART2);
        self.link.0.advance();
        self.bus.0.advance();
        is_tick
    }

    /// Waits for so many ticks, or until something is so.
    fn wait_ticks(&mut self, mut ticks: u32, is_over: impl Fn(&Self) -> bool) {
        while ticks > 0 && !is_over(self) {
            ticks -= u32::from(self.wait());
        }
    }

    /// The samples of the next tick.
    fn samples(&mut self) -> Option<Samples> {
        self.wait_ticks(1, |_| false);
        self.scan.read().ok()
    }

    /// A line that leaves.
    fn say(&mut self, line: &ReportLine) {
        self.link.1.send(line.as_bytes());
        self.wait_ticks(LEAVING_TICKS, |bench| !bench.link.1.is_sending());
    }

    fn number(&mut self, part: &Part, value: Option<f32>) {
        let line = self.report.number(part, value);
        self.say(&line);
    }

    fn word(&mut self, name: &str, word: &str, is_good: bool) {
        let line = self.report.word(name, word, is_good);
        self.say(&line);
    }

    /// Tests every part, and tells it.
    fn run(&mut self, wanted: Wanted) {
        Light.set(true);
        self.report = Report::default();
        self.processor();
        self.clocks();
        self.levels();
        self.inputs();
        if wanted.output {
            self.output();
        }
        if wanted.echo {
            self.echo();
        }
        self.flash_cycle();
        let end = core::mem::take(&mut self.report).end();
        self.say(&end);
        Light.set(false);
    }

    /// Which one it is, why it has started, its option bytes, its memory.
    fn processor(&mut self) {
        let Shown { reset, identity, brown_out_level, .. } = self.shown;
        let mut unique_id = String::<24>::new();
        let _ = identity.unique_id.iter().try_for_each(|word| write!(unique_id, "{word:04x}"));
        let is_written = identity.unique_id.iter().any(|&word| word != 0 && word != u16::MAX);
        self.word("unique_id", if is_written { &unique_id } else { NONE }, is_written);
        self.number(&parts::FLASH_SIZE, Some(flash_size_kb().into()));
        let (cause, is_expected) = match reset {
            Reset::PowerOn => ("power_on", true),
            Reset::Pin => ("pin", true),
            Reset::Software => ("software", true),
            Reset::Watchdog => ("watchdog", false),
            Reset::BrownOut => ("brown_out", false),
        };
        self.word("reset_cause", cause, is_expected);
        self.number(&parts::BROWN_OUT_LEVEL, Some(brown_out_level.into()));
        let has_memory = memory_test::has_passed();
        self.word("memory", if has_memory { "whole" } else { "damaged" }, has_memory);
    }

    fn clocks(&mut self) {
        let Shown { is_supplied, crystal_hz, source, .. } = self.shown;
        self.word("supply_detector", if is_supplied { "high" } else { "low" }, is_supplied);
        self.number(&parts::CRYSTAL_HZ, crystal_hz);
        let is_crystal = source == Source::Crystal;
        self.word("clock", if is_crystal { "crystal" } else { "internal" }, is_crystal);
        let watchdog_hz = self.stopwatch.watchdog_hz(&self.registers);
        self.number(&parts::WATCHDOG_HZ, watchdog_hz);
    }

    /// Resistors, contacts, and the pin of the bus's driver.
    fn levels(&mut self) {
        for (name, is_low) in self.shown.resistors {
            self.word(name, if is_low { "there" } else { "missing" }, is_low);
        }
        let closed = |is_open| if is_open { "open" } else { "closed" };
        let (stop, coil) = (pins::is_stop_open(), pins::has_coil_voltage());
        self.word("emergency_stop", closed(stop), !stop);
        self.word("dump_coil_contact", closed(coil), !coil);
        let driver = pins::is_bus_driver_high();
        self.word("bus_driver", if driver { "high" } else { "low" }, !driver);
    }

    /// The sensors, the supply, the vented output, over some ticks.
    fn inputs(&mut self) {
        let mut codes: [Codes; 6] = Default::default();
        for _ in 0..TICKS {
            if let Some(samples) = self.samples() {
                let [reference, output] = [samples.reference, samples.output].map(Option::unwrap_or_default);
                let once = [samples.supply, samples.temperature, reference, output].map(|code| [code.0]);
                let often = Scan::conversions();
                let taken =
                    often.iter().map(<[u16; _]>::as_slice).chain(once.iter().map(<[u16; 1]>::as_slice));
                let each = codes.iter_mut().zip(taken);
                each.for_each(|(codes, taken)| taken.iter().for_each(|&code| codes.take(code)));
            }
        }
        let [pressure, contraction, supply, temperature, reference, output] = &codes;
        let supply_v = reference.mean().map(parts::supply_v);
        self.number(&parts::SUPPLY_V, supply_v);
        let celsius = |code| (code - TEMPERATURE.zero_code) / TEMPERATURE.codes_per_unit;
        self.number(&parts::TEMPERATURE_C, temperature.mean().map(celsius));
        self.number(&parts::PRESSURE_CODE, pressure.mean());
        self.number(&parts::CONTRACTION_CODE, contraction.mean());
        self.number(&parts::SUPPLY_CODE, supply.mean());
        self.number(&parts::PRESSURE_NOISE, pressure.deviation());
        self.number(&parts::CONTRACTION_NOISE, contraction.deviation());
        self.number(&parts::SUPPLY_NOISE, supply.deviation());
        let vented_v = output.mean().zip(supply_v).map(|(code, supply_v)| parts::volts(code, supply_v));
        self.number(&parts::VENTED_V, vented_v);
    }

    /// What the output's pin reads, some ticks behind a code. Unit: code.
    fn output_by(&mut self, code: DacCode) -> Option<f32> {
        let Ok(()) = self.valve.set(code);
        self.wait_ticks(SETTLING_TICKS, |_| false);
        let mut codes = Codes::default();
        for _ in 0..SETTLING_TICKS {
            let read = self.samples().and_then(|samples| samples.output);
            read.into_iter().for_each(|read| codes.take(read.0));
        }
        codes.mean()
    }

    /// The output by some codes, and vented again.
    fn output(&mut self) {
        let mut readings = [None; parts::DRIVEN.len()];
        for (reading, (code, _)) in readings.iter_mut().zip(&parts::DRIVEN) {
            *reading = self.output_by(*code).map(|read| read - f32::from(code.0));
        }
        let vented = self.output_by(VENT).map(|read| parts::volts(read, REFERENCE_SUPPLY_V));
        for (reading, (_, part)) in readings.into_iter().zip(&parts::DRIVEN) {
            self.number(part, reading);
        }
        self.number(&parts::VENTED_AGAIN_V, vented);
    }

    /// Whether the bus hears what it sends, and its driver lets go of it.
    fn echo(&mut self) {
        while self.bus.1.read().is_some() {}
        self.bus.1.send(&parts::ECHO_PATTERN);
        self.wait_ticks(ECHO_TICKS, |_| false);
        let mut heard = 0;
        for expected in parts::ECHO_PATTERN {
            heard += u16::from(self.bus.1.read() == Some(expected));
        }
        self.number(&parts::ECHO_BYTES, Some(heard.into()));
        let driver = pins::is_bus_driver_high();
        self.word("bus_driver_after", if driver { "high" } else { "low" }, !driver);
    }

    /// Last: the processor stands still meanwhile.
    fn flash_cycle(&mut self) {
        let cycle = flash_cycle::cycle(&mut self.flash, &self.stopwatch).ok();
        self.number(&parts::FLASH_WORDS, cycle.map(|cycle| cycle.wrong_words as f32));
        self.number(&parts::ERASE_MS, cycle.map(|cycle| cycle.erase_ms));
        self.number(&parts::PROGRAM_US, cycle.map(|cycle| cycle.program_us));
    }
}
