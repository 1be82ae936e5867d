//! Faults injected into the production image: by its samples and its link, and by its registers.

use firmware::scaling::{PRESSURE, SUPPLY, TEMPERATURE};
use firmware::{AdcCode, Samples};
use host_tests::configuration;
use libtest_mimic::Failed;
use model_core::{Mode, ModelParameters, paper};
use probe::production::Crash;
use wire::{Fault, Request, Response, State};

use super::bench::Bench;

/// What the converter says instead, `ticks` after the fault began.
type Spoil = fn(Samples, ticks: u32) -> Option<Samples>;

/// Fault, what shows it, and the ticks that the fault table allows it.
const BY_SAMPLES: [(Fault, Spoil, u32); 9] = [
    (Fault::Acquisition, |_, _| None, 3),
    (Fault::PressureSensor, |samples, _| Some(Samples { pressure: AdcCode(0), ..samples }), 3),
    (Fault::ContractionSensor, |samples, _| Some(Samples { contraction: AdcCode(4095), ..samples }), 3),
    (Fault::SupplySensor, |samples, _| Some(Samples { supply: AdcCode(4095), ..samples }), 3),
    (
        Fault::PressureSpiking,
        |samples, _| Some(Samples { pressure: AdcCode(samples.pressure.0 + 900), ..samples }),
        5,
    ),
    (
        Fault::ContractionSpiking,
        |samples, _| Some(Samples { contraction: AdcCode(samples.contraction.0 + 500), ..samples }),
        5,
    ),
    (
        Fault::OverpressureHard,
        |samples, _| Some(Samples { pressure: AdcCode(PRESSURE.code(7.8)), ..samples }),
        1,
    ),
    (Fault::SupplyLow, |samples, _| Some(Samples { supply: AdcCode(SUPPLY.code(3.5)), ..samples }), 200),
    (
        Fault::Temperature,
        |samples, _| Some(Samples { temperature: AdcCode(TEMPERATURE.code(95.0)), ..samples }),
        200,
    ),
];

/// A bench that is ready, with the paper's model.
fn ready() -> Result<Bench, Failed> {
    let mut bench = Bench::new(5)?;
    bench.make_ready(Some(&configuration(&ModelParameters::Cascade(paper::mgpi()?))))?;
    Ok(bench)
}

/// Tracks towards 40 mm until the valve is open.
pub fn track(bench: &mut Bench) -> Result<(), Failed> {
    bench.demand(&Request::Reference(40.0))?;
    bench.open(&Request::Start(Mode::Both))?;
    for _ in 0..300 {
        bench.tick(Some)?;
    }
    bench.beat()?;
    if bench.output > 200 { Ok(()) } else { Err(format!("the valve is at {}", bench.output).into()) }
}

pub fn of_samples() -> Result<(), Failed> {
    let mut bench = ready()?;
    for (fault, spoil, within_ticks) in BY_SAMPLES {
        track(&mut bench)?;
        let mut ticks = 0;
        while bench.output > 0 && ticks < 1000 {
            bench.tick(|samples| spoil(samples, ticks))?;
            ticks += 1;
        }
        println!("{fault:?}: vented in {ticks} ticks, at most {within_ticks}");
        if ticks > within_ticks {
            return Err(format!("{fault:?}: {ticks} ticks").into());
        }
        bench.assert_vented_by(fault)?;
        // The muscle needs some time to come down before the next self-test.
        for _ in 0..1500 {
            bench.tick(Some)?;
        }
        bench.demand(&Request::Acknowledge)?;
        bench.make_ready(None)?;
    }
    track(&mut bench)?;
    bench.demand(&Request::Reference(f32::NAN))?;
    bench.assert_vented_by(Fault::Reference)?;
    bench.demand(&Request::Acknowledge)?;
    let clock = usize::from(Fault::Clock.code()) - 1;
    if bench.telemetry()?.faults[clock] == 1 {
        Ok(())
    } else {
        Err("the missing crystal is not counted".into())
    }
}

pub fn of_the_processor() -> Result<(), Failed> {
    let mut bench = ready()?;
    let crashes = [(Fault::HardFault, Crash::NoMemory), (Fault::StackOverflow, Crash::EndlessCalls)];
    for (fault, crash) in crashes {
        track(&mut bench)?;
        let written = bench.image.crash(crash)?;
        println!("{fault:?}: the valve gets {written:?} up to the first tick after the reset");
        if written.is_empty() || written.iter().any(|code| *code != 0) {
            return Err(format!("{fault:?}: the valve gets {written:?}").into());
        }
        bench.output = 0;
        bench.assert_vented_by(fault)?;
        match bench.request(&Request::FaultRecord)? {
            Response::FaultRecord(Some(record)) if record.fault == fault && !record.trace.is_empty() => {}
            other => return Err(format!("{fault:?}: {other:?}").into()),
        }
        let refused = bench.request(&Request::Start(Mode::Both))?;
        if refused != Response::Refused(wire::Refusal::WrongState(State::Fault)) {
            return Err(format!("{fault:?}: a start is answered by {refused:?}").into());
        }
        for _ in 0..1500 {
            bench.tick(Some)?;
        }
        bench.demand(&Request::Acknowledge)?;
        bench.make_ready(Some(&configuration(&ModelParameters::Cascade(paper::mgpi()?))))?;
    }
    Ok(())
}
