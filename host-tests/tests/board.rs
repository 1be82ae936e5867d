//! What surrounds the control on a board: the record that survives a reset, soft start, capture,
//! telemetry, the watchdog's logic, outputs on embedded-hal; and that nothing of it raises an alarm
//! where nothing is wrong.

use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as PwmCall};
use embedded_hal_mock::eh1::spi::{Mock as Spi, Transaction as SpiCall};
use firmware::DacCode;
use firmware::board::Valve;
use firmware::board::pwm_valve::PwmValve;
use firmware::board::spi_dac::SpiDac;
use firmware::faults::black_box::{BlackBox, Reset};
use firmware::led::{is_lit, is_lit_of_joint};
use firmware::scaling::{COMMAND, VENT};
use firmware::watchdog::{CheckIns, Task, Watchdog};
use host_tests::bench::Bench;
use host_tests::configuration;
use model_core::{Mode, ModelParameters, paper};
use wire::fault::table::TABLE;
use wire::fault::times::ALLOWANCE_TICKS;
use wire::joint::{Channel, JointBoardState, JointFault};
use wire::{
    CaptureOrder, Captured, Configuration, Fault, FaultRecord, Protection, Request, Response, State, TRACE,
    Telemetry, TraceEntry,
};

fn configuration_of_paper() -> Configuration {
    configuration(&ModelParameters::Cascade(paper::mgpi().expect("valid")))
}

/// A bench that tracks.
fn tracking() -> Bench {
    let mut bench = Bench::new(1);
    bench.start(Protection::STANDARD, &configuration_of_paper(), Mode::Both);
    bench
}

/// Ticks with a smooth reference.
fn track(bench: &mut Bench, ticks: u32) {
    for tick in 0..ticks {
        bench.reference_mm = 50.0 * (1.0 - (f64::from(tick) / 500.0).cos());
        bench.tick();
    }
}

fn record(bench: &mut Bench) -> Option<FaultRecord> {
    let Response::FaultRecord(record) = bench.request(&Request::FaultRecord) else { panic!("no record") };
    record
}

fn telemetry(bench: &mut Bench) -> Telemetry {
    let Response::Telemetry(telemetry) = bench.request(&Request::Telemetry) else { panic!("no telemetry") };
    telemetry
}

#[test]
fn every_fault_has_one_row_in_the_order_of_the_numbers() {
    assert_eq!(TABLE.map(|row| row.fault), Fault::ALL);
}

#[test]
fn the_first_fault_is_kept_with_the_ticks_before_it_over_resets_until_it_is_acknowledged() {
    let mut bench = tracking();
    track(&mut bench, 700);
    bench.wrong.supply_code = Some(4095);
    (0..3).for_each(|_| bench.tick());
    let first = record(&mut bench).expect("a fault");
    assert_eq!((first.fault, first.trace.len()), (Fault::SupplySensor, TRACE));
    let ticks: Vec<u32> = first.trace.iter().map(|entry| entry.tick).collect();
    let expected: Vec<u32> = (first.tick - TRACE as u32..first.tick).collect();
    assert_eq!(ticks, expected, "the ticks just before the fault in tick {}", first.tick);
    assert!(first.trace.iter().all(|entry| entry.dac_code > 0));
    bench.control().report(Fault::BrownOut);
    bench.reset(Reset::Pin, None);
    assert_eq!((bench.state(), record(&mut bench)), (State::Fault, Some(first.clone())));
    bench.reset(Reset::Software, Some(Fault::Panic));
    assert_eq!(record(&mut bench), Some(first), "the first stays");
    bench.demand(&Request::Acknowledge);
    assert_eq!((bench.state(), record(&mut bench)), (State::Off, None));
}

#[test]
fn a_reset_by_the_watchdog_keeps_the_trace_that_nobody_has_sealed() {
    let mut bench = tracking();
    track(&mut bench, 700);
    bench.reset(Reset::Watchdog, None);
    let record = record(&mut bench).expect("a fault");
    assert_eq!((record.fault, record.trace.len()), (Fault::WatchdogReset, TRACE));
    assert_eq!(Some(record.tick), record.trace.last().map(|entry| entry.tick));
    assert_eq!(telemetry(&mut bench).resets, 1);
}

#[test]
fn memory_after_power_on_or_with_a_record_that_was_not_closed_is_no_record() {
    let mut sealed = BlackBox::new();
    sealed.note(TraceEntry::default());
    sealed.seal(Fault::Panic, 7, 0);
    assert_eq!(BlackBox::after(Reset::Pin, sealed).fault_at_start(), Some(Fault::Panic));
    assert_eq!(BlackBox::after(Reset::PowerOn, sealed).fault_at_start(), None, "power-on");
    let mut other = sealed;
    other.reopen();
    other.note(TraceEntry { tick: 3, ..TraceEntry::default() });
    assert_eq!(BlackBox::after(Reset::Pin, other).record(), None);
}

#[test]
fn the_third_reset_in_a_row_is_a_loop_unless_the_board_has_run_for_ten_seconds() {
    let mut bench = Bench::new(1);
    (0..2).for_each(|_| bench.reset(Reset::Watchdog, None));
    bench.demand(&Request::Acknowledge);
    (0..10_001).for_each(|_| bench.tick());
    bench.reset(Reset::Watchdog, None);
    assert_eq!(bench.control().fault(), Some(Fault::WatchdogReset));
    (0..2).for_each(|_| bench.reset(Reset::Watchdog, None));
    assert_eq!(bench.control().fault(), Some(Fault::ResetLoop));
    assert_ne!(bench.request(&Request::Acknowledge), Response::Accepted);
    bench.reset(Reset::PowerOn, None);
    assert_eq!(bench.state(), State::Off);
}

#[test]
fn after_a_start_the_command_rises_no_faster_than_the_soft_start_and_slews_no_faster_than_its_limit() {
    let mut bench = tracking();
    bench.reference_mm = 100.0;
    let (rise, slew) = (10.0e-3, 100.0e-3);
    let mut last = 0.0;
    for tick in 1..=800 {
        bench.tick();
        let command = bench.command_bar();
        assert!(command <= rise * f64::from(tick) + 1e-9, "tick {tick}: {command} bar");
        last = command;
    }
    assert!(last > 3.0, "{last}");
    for reference in [0.0, 110.0].into_iter().cycle().take(40) {
        bench.reference_mm = reference;
        for _ in 0..7 {
            bench.tick();
            let command = bench.command_bar();
            // One code more for rounding.
            assert!((command - last).abs() <= slew + 1.0 / f64::from(COMMAND.codes_per_unit) + 1e-9);
            last = command;
        }
    }
}

#[test]
fn service_drives_a_code_and_vents_when_it_is_left_or_the_host_falls_silent() {
    let mut bench = Bench::new(1);
    bench.open(&Request::Service(410));
    (0..200).for_each(|_| bench.tick());
    assert_eq!((bench.state(), bench.output()), (State::Service, DacCode(410)));
    bench.demand(&Request::Stop);
    bench.tick();
    assert_eq!((bench.state(), bench.output()), (State::Off, VENT));
    bench.open(&Request::Service(410));
    bench.wrong.no_host = true;
    (0..501).for_each(|_| bench.tick());
    assert_eq!((bench.control().fault(), bench.output()), (Some(Fault::BusSilent), VENT));
}

#[test]
fn a_single_spike_is_bridged_and_counted_and_does_not_move_the_valve() {
    let (mut with, mut without) = (tracking(), tracking());
    track(&mut with, 500);
    track(&mut without, 500);
    with.wrong.contraction_code = Some(3500);
    with.tick();
    without.tick();
    with.wrong.contraction_code = None;
    let difference = with.output().0.abs_diff(without.output().0);
    assert!(difference <= 1, "{difference} codes");
    assert_eq!((with.state(), telemetry(&mut with).bridged_samples), (State::Tracking, 1));
}

#[test]
fn a_board_whose_model_fails_its_test_tracks_by_feedback_alone_if_the_protection_says_so() {
    let mut parameters = paper::mgpi().expect("valid");
    parameters.input_max = 26.0;
    let configuration = configuration(&ModelParameters::Cascade(parameters));
    let mut bench = Bench::new(1);
    bench.demand(&Request::Configure(configuration));
    (0..Protection::STANDARD.self_test_ticks).for_each(|_| bench.tick());
    assert_eq!(
        (bench.state(), telemetry(&mut bench).faults[usize::from(Fault::Model.code()) - 1]),
        (State::Ready, 1)
    );
    assert_ne!(bench.request(&Request::Start(Mode::FeedforwardOnly)), Response::Accepted);
    bench.open(&Request::Start(Mode::Both));
    bench.reference_mm = 40.0;
    (0..100).for_each(|_| bench.tick());
    // The feed-forward alone would ask for 1.8 bar: what is out is the gain times the error, and
    // the soft start.
    assert!(bench.command_bar() < 1.2, "{} bar", bench.command_bar());
}

#[test]
fn the_capture_has_the_last_ticks_up_to_a_fault_and_is_read_in_parts() {
    let mut bench = tracking();
    bench.demand(&Request::Capture(CaptureOrder::Start(2)));
    track(&mut bench, 700);
    let tripped_in = bench.control().ticks();
    bench.control().report(Fault::Panic);
    (0..50).for_each(|_| bench.tick());
    let mut read = |from| match bench.request(&Request::Capture(CaptureOrder::Read(from))) {
        Response::Captured(part) => part,
        other => panic!("{other:?}"),
    };
    let all: Vec<Captured> =
        (0..).map_while(|part| Some(read(48 * part)).filter(|part| !part.samples.is_empty())).collect();
    let samples = all.iter().map(|part| part.samples.len()).sum::<usize>();
    assert_eq!((samples, all[0].kept, all[0].every), (350, 350, 2));
    let last = all.last().expect("some");
    let last_tick = last.first_tick + 2 * (last.samples.len() as u32 - 1);
    assert!(tripped_in - last_tick <= 1, "{last_tick} of {tripped_in}");
    assert!(all.windows(2).all(|parts| parts[0].first_tick + 96 == parts[1].first_tick));
}

#[test]
fn every_response_fits_a_frame() {
    let mut bench = tracking();
    track(&mut bench, 1500);
    bench.control().report(Fault::Panic);
    for request in
        [Request::Identify, Request::Telemetry, Request::FaultRecord, Request::Capture(CaptureOrder::Read(0))]
    {
        let response = bench.request(&request);
        assert!(wire::encode(&response, &mut [0; wire::FRAME_BYTES]).is_ok(), "{request:?}");
    }
}

#[test]
fn the_watchdog_is_content_while_every_task_checks_in_and_not_when_one_stops() {
    for silent in [Task::Link, Task::Supervisor] {
        let (check_ins, mut watchdog) = (CheckIns::new(), Watchdog::default());
        let mut content_ticks = 0;
        for tick in 0..1000_u16 {
            for task in [Task::Link, Task::Supervisor] {
                // Now and then is enough.
                if tick % 200 == 0 && (task != silent || tick < 400) {
                    check_ins.check_in(task);
                }
            }
            content_ticks += u16::from(watchdog.is_content(&check_ins));
        }
        assert_eq!(content_ticks, 200 + ALLOWANCE_TICKS + 1, "{silent:?}");
    }
}

#[test]
fn the_status_light_counts_the_fault_and_tells_the_states_apart() {
    let flashes = |state, fault, ticks: u32| {
        let lit: Vec<bool> = (0..ticks).map(|tick| is_lit(state, fault, tick)).collect();
        usize::from(lit[0]) + lit.windows(2).filter(|pair| !pair[0] && pair[1]).count()
    };
    for fault in Fault::ALL {
        let (tens, ones) = (u32::from(fault.code()) / 10, u32::from(fault.code()) % 10);
        let period = (tens + ones + 5) * 300;
        assert_eq!(flashes(State::Fault, Some(fault), period) as u32, tens + ones, "{fault:?}");
    }
    for (fault, counts) in [
        (JointFault::OfBoard(Fault::BusSilent), 2 + 1),
        // A hundred is a flicker of three.
        (JointFault::OfChannel(Channel::B, Fault::OutputStray), 3 * 2 + 3 + 4),
        (JointFault::AngleSensor, 3 * 3 + 1),
    ] {
        let code = u32::from(fault.code());
        let period = (code / 100 + code / 10 % 10 + code % 10 + 5) * 300;
        let lit: Vec<bool> =
            (0..period).map(|tick| is_lit_of_joint(JointBoardState::Fault, Some(fault), tick)).collect();
        assert_eq!(1 + lit.windows(2).filter(|pair| !pair[0] && pair[1]).count(), counts, "{fault}");
    }
    let by_state = [State::Off, State::SelfTest, State::Ready, State::Tracking, State::Service];
    let counts = by_state.map(|state| flashes(state, None, 10_000));
    assert_eq!(counts, [5, 100, 10, 1, 20]);
}

#[test]
fn a_converter_on_a_bus_gets_the_code_under_its_configuration_bits() {
    let word = |bytes: [u8; 2]| {
        [SpiCall::transaction_start(), SpiCall::write_vec(bytes.to_vec()), SpiCall::transaction_end()]
    };
    let expected = [word([0x30, 0x00]), word([0x3A, 0xBC]), word([0x3F, 0xFF])].concat();
    let mut bus = Spi::new(&expected);
    let mut valve = SpiDac(bus.clone());
    for code in [VENT, DacCode(0xABC), DacCode(u16::MAX)] {
        valve.set(code).expect("the bus works");
    }
    bus.done();
}

#[test]
fn a_coil_gets_the_duty_cycle_of_the_code() {
    let calls =
        [0, 2100, 4200].map(|duty| [PwmCall::max_duty_cycle(4200), PwmCall::set_duty_cycle(duty)]).concat();
    let mut pulses = Pwm::new(&calls);
    let mut valve = PwmValve(pulses.clone());
    for code in [VENT, DacCode(2048), DacCode(4095)] {
        valve.set(code).expect("the timer works");
    }
    pulses.done();
}
