//! The production image with the rig as its muscle.

use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;

use board_client::pil::lock_step::{Measurement, Plant};
use firmware::scaling::{COMMAND, CONTRACTION, PRESSURE, SUPPLY, TEMPERATURE};
use firmware::{AdcCode, Samples};
use host_tests::{PERIOD_S, rig};
use libtest_mimic::Failed;
use model_core::Surroundings;
use probe::Production;
use wire::{Configuration, Fault, Refusal, Request, Response, State, Telemetry};

type Muscle = Box<dyn FnMut(f32) -> Result<Measurement, Failed>>;

/// The bench.
pub struct Bench {
    pub image: Production,
    muscle: Muscle,
    /// What was written to the valve last. Unit: DAC code.
    pub output: u16,
    pub measured: Measurement,
    heartbeat: u16,
}

impl Bench {
    /// The image after power-on, its parameter store blank.
    pub fn new(seed: u64) -> Result<Self, Failed> {
        Self::with_store(seed, &[])
    }

    /// The image after power-on with this in its parameter store.
    pub fn with_store(seed: u64, store: &[u8]) -> Result<Self, Failed> {
        Self::start(seed, store, None)
    }

    /// The image after power-on, its parameter store blank, and the users' bus.
    pub fn with_bus(seed: u64) -> Result<(Self, UnixStream), Failed> {
        let directory = tempfile::tempdir()?;
        let name = directory.path().join("bus");
        let socket = UnixListener::bind(&name)?;
        let bench = Self::start(seed, &[], Some(&name))?;
        // It ticks: whatever the emulator connects to is connected.
        socket.set_nonblocking(true)?;
        let (bus, _) = socket.accept()?;
        bus.set_nonblocking(true)?;
        Ok((bench, bus))
    }

    fn start(seed: u64, store: &[u8], bus: Option<&Path>) -> Result<Self, Failed> {
        let measured =
            Measurement { pressure_bar: 0.0, contraction_mm: 0.0, surroundings: Surroundings::default() };
        let image = Production::start(&super::production(), store, bus, &[])?;
        Ok(Self { image, muscle: muscle(seed), output: 0, measured, heartbeat: 0 })
    }

    /// Another muscle, at rest.
    pub fn replace_muscle(&mut self, seed: u64) {
        self.muscle = muscle(seed);
    }

    /// A tick: the muscle under the last command, then the image with what `sensors` makes of the
    /// samples.
    pub fn tick(&mut self, sensors: impl FnOnce(Samples) -> Option<Samples>) -> Result<(), Failed> {
        self.measured = (self.muscle)(COMMAND.value(self.output))?;
        let Measurement { pressure_bar, contraction_mm, .. } = self.measured;
        let samples = Samples {
            pressure: AdcCode(PRESSURE.code(pressure_bar as f32)),
            contraction: AdcCode(CONTRACTION.code(contraction_mm as f32)),
            supply: AdcCode(SUPPLY.code(8.0)),
            temperature: AdcCode(TEMPERATURE.code(30.0)),
            // The emulator has neither.
            output: None,
            reference: None,
            surroundings: Surroundings::default(),
        };
        let written = self.image.tick(sensors(samples))?;
        self.output = *written.last().ok_or("the valve was not written in a tick")?;
        Ok(())
    }

    /// Ticks until the response to a request is there.
    pub fn request(&mut self, request: &Request) -> Result<Response, Failed> {
        self.image.send(request)?;
        self.response()
    }

    /// Ticks until a response is there.
    pub fn response(&mut self) -> Result<Response, Failed> {
        for _ in 0..100_000 {
            if let Some(response) = self.image.response()? {
                return Ok(response);
            }
            self.tick(Some)?;
        }
        Err("no answer".into())
    }

    /// The same for a request that has to be accepted.
    pub fn demand(&mut self, request: &Request) -> Result<(), Failed> {
        match self.request(request)? {
            Response::Accepted => Ok(()),
            other => Err(format!("{request:?}: {other:?}").into()),
        }
    }

    /// Opens the valve by a request, in two steps.
    pub fn open(&mut self, request: &Request) -> Result<(), Failed> {
        self.demand(&Request::Arm)?;
        self.demand(request)
    }

    /// Shows that the host lives.
    pub fn beat(&mut self) -> Result<(), Failed> {
        self.heartbeat = self.heartbeat.wrapping_add(1);
        self.demand(&Request::Heartbeat(self.heartbeat))
    }

    /// The same for one that changes what the board keeps, which the emulated flash does not.
    pub fn demand_unstored(&mut self, request: &Request) -> Result<(), Failed> {
        match self.request(request)? {
            Response::Refused(Refusal::NotStored) => Ok(()),
            other => Err(format!("{request:?}: {other:?}").into()),
        }
    }

    /// What the board counts and measures.
    pub fn telemetry(&mut self) -> Result<Telemetry, Failed> {
        match self.request(&Request::Telemetry)? {
            Response::Telemetry(telemetry) => Ok(telemetry),
            other => Err(format!("{other:?}").into()),
        }
    }

    /// Configures the image, unless it is configured, and ticks until it is ready.
    pub fn make_ready(&mut self, configuration: Option<&Configuration>) -> Result<(), Failed> {
        if let Some(configuration) = configuration {
            self.demand_unstored(&Request::Configure(configuration.clone()))?;
        }
        for _ in 0..20 {
            if self.telemetry()?.state == State::Ready {
                return Ok(());
            }
            for _ in 0..50 {
                self.tick(Some)?;
            }
        }
        Err(format!("not ready: {:?}", self.telemetry()?).into())
    }

    /// Fails unless the image is at this fault, vented.
    pub fn assert_vented_by(&mut self, fault: Fault) -> Result<(), Failed> {
        let Telemetry { state, fault: found, .. } = self.telemetry()?;
        if (state, found, self.output) == (State::Fault, Some(fault), 0) {
            Ok(())
        } else {
            Err(format!("{fault:?}: {state:?}, {found:?}, output {}", self.output).into())
        }
    }
}

fn muscle(seed: u64) -> Muscle {
    let (mut plant, mut tick) = (rig(seed), 0_u32);
    Box::new(move |command_bar| {
        tick += 1;
        Ok(plant.advance(f64::from(tick) * PERIOD_S, command_bar)?)
    })
}
