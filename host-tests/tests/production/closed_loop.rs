//! The production image beside the emulated one, on the same muscle with the same noise.
//!
//! The production image gets its reference over its link, while it ticks: it takes effect when the
//! bytes are through, some ticks later. The emulated image then gets, tick by tick, the reference
//! that the other has acknowledged.

use board_client::emulator::{Emulator, image};
use board_client::stop::Stop;
use host_tests::{configuration, rig, run};
use libtest_mimic::Failed;
use model_core::{Mode, ModelParameters, paper};
use wire::{Protection, Request, Response};

use super::bench::Bench;

const SEED: u64 = 3;
/// 2 s of approach and a swing of 6 s.
const TICKS: usize = 8000;
const APPROACH: usize = 2000;
/// From heartbeat to heartbeat, of which the board wants one in 500.
const BEAT_TICKS: usize = 200;

fn reference_mm(tick: usize) -> f64 {
    let rise = |turns: f64| (1.0 - (std::f64::consts::TAU * turns).cos()) / 2.0;
    match tick.checked_sub(APPROACH) {
        None => 10.0 * rise(0.5 * tick as f64 / APPROACH as f64),
        Some(since) => 10.0 + 90.0 * rise(since as f64 / 6000.0),
    }
}

/// Root mean square of the error behind the approach. Unit: mm.
fn rmse_mm(contraction_mm: &[f64]) -> f64 {
    let squares = contraction_mm.iter().enumerate().skip(APPROACH);
    let sum: f64 = squares.map(|(tick, contraction)| (reference_mm(tick) - contraction).powi(2)).sum();
    (sum / (contraction_mm.len() - APPROACH) as f64).sqrt()
}

pub fn as_the_emulated_image() -> Result<(), Failed> {
    let configuration = configuration(&ModelParameters::Cascade(paper::mgpi()?));
    let (mut acknowledged, mut of_production) = (Vec::new(), Vec::new());
    let mut bench = Bench::new(SEED)?;
    bench.make_ready(Some(&configuration))?;
    bench.open(&Request::Start(Mode::Both))?;
    // The muscle of the other run begins here.
    bench.replace_muscle(SEED);
    let (mut sent, mut current, mut answered, mut beats) = (0.0, 0.0, true, 0);
    for tick in 0..TICKS {
        if let Some(response) = bench.image.response()? {
            if response != Response::Accepted {
                return Err(format!("tick {tick}: {response:?}").into());
            }
            (current, answered) = (sent, true);
        }
        if answered {
            answered = false;
            // Each request has to be answered before the next: in between, that the host lives.
            if tick >= beats * BEAT_TICKS {
                bench.image.send(&Request::Heartbeat(beats as u16))?;
                beats += 1;
            } else {
                sent = reference_mm(tick);
                bench.image.send(&Request::Reference(sent as f32))?;
            }
        }
        bench.tick(Some)?;
        acknowledged.push(current);
        of_production.push(bench.measured.contraction_mm);
    }
    if !answered {
        bench.response()?;
    }
    let telemetry = bench.telemetry()?;
    println!("production image: worst tick {} of 16000 cycles of the emulator", telemetry.worst_tick_cycles);

    let mut emulator = Emulator::start(&image::find(None)?, &Stop::default())?;
    let protection = Protection { self_test_ticks: 0, ..Protection::STANDARD };
    if emulator.request(&Request::Protect(protection))? != Response::Accepted {
        return Err("the emulated image refuses its protection".into());
    }
    let run = run(&mut emulator, &mut rig(SEED), &configuration, Mode::Both, &acknowledged)?;
    let of_emulated: Vec<f64> = run.samples.iter().map(|sample| sample.measured.contraction_mm).collect();

    let (production, emulated) = (rmse_mm(&of_production), rmse_mm(&of_emulated));
    let difference_percent = 100.0 * (production / emulated - 1.0);
    println!("RMSE: production {production:.4} mm, emulated {emulated:.4} mm, {difference_percent:+.2} %");
    if difference_percent.abs() <= 2.0 { Ok(()) } else { Err(format!("{difference_percent} %").into()) }
}
