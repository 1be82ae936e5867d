//! Writes the valid inputs that the binary targets begin with into `fuzz/corpus`, anew after a change of the messages:
//! `cargo run --manifest-path fuzz/Cargo.toml --example seeds`.

use std::path::Path;

use firmware::law::{paper_parameters, piecewise_parameters};
use firmware::store::{ParameterStore, Parameters};
use host_tests::HostBoard;
use host_tests::flash::MockFlash;
use host_tests::store::{full_set, numbered, paper_set};
use model_core::Mode;
use wire::{CaptureOrder, Configuration, FRAME_BYTES, Protection, Request, State, TickRequest, VERSION};
use workbench::pil::lock_step::Board;

fn main() {
    for (name, requests) in conversations() {
        write("requests", name, &requests.iter().flat_map(bare).collect::<Vec<u8>>());
        let mut board = HostBoard::default();
        let exchange = requests.iter().flat_map(|request| {
            let response = board.request(request).expect("a board on the host always answers");
            [framed(request), framed(&response)].concat()
        });
        write("frames", name, &exchange.collect::<Vec<u8>>());
    }
    for saves in [1, 2, 4] {
        let mut store = ParameterStore::new(MockFlash::<1024>::blank());
        for number in 0..saves {
            let set = if number % 2 == 0 { paper_set() } else { Parameters::FACTORY };
            store.save(State::Ready, &numbered(number, set)).expect("a blank flash");
        }
        // Before the contents: after how many units of work the power goes, and how.
        write(
            "parameter_store",
            &format!("saves_{saves}"),
            &[&[100, 0, saves as u8], store.flash().bytes()].concat(),
        );
    }
}

/// Requests that a host could send.
fn conversations() -> [(&'static str, Vec<Request>); 4] {
    let configure = |tracking| Request::Configure(Configuration { version: VERSION, tracking });
    let tick = |reference_mm, contraction_code| {
        Request::Tick(TickRequest { reference_mm, pressure_code: 700, contraction_code })
    };
    let paper = configure(paper_parameters().expect("valid"));
    let piecewise = configure(piecewise_parameters().expect("valid"));
    let full = configure(full_set().tracking.expect("a model"));
    let swing = [tick(10.0, 300), tick(60.0, 900), tick(20.0, 800)];
    let questions = [Request::Identify, Request::Telemetry, Request::FaultRecord];
    let modes = [Mode::FeedbackOnly, Mode::FeedforwardOnly, Mode::Hold].map(Request::SetMode);
    let fault = [tick(f32::NAN, 900), tick(0.0, 0), Request::FaultRecord, Request::Acknowledge];
    let service =
        [Request::Protect(Protection::STANDARD), Request::Service(100), tick(0.0, 300), Request::Stop];
    let capture = [CaptureOrder::Start(1), CaptureOrder::Stop, CaptureOrder::Read(0)].map(Request::Capture);
    let start = [Request::Start(Mode::Both)];
    [
        ("paper", [&[paper][..], &swing[..1], &start, &swing, &modes, &fault].concat()),
        ("piecewise", [&[piecewise][..], &swing[..1], &start, &capture[..1], &swing, &capture[1..]].concat()),
        ("full", [&[full][..], &start, &swing].concat()),
        ("service", [&questions[..], &service, &questions].concat()),
    ]
}

/// A request as the board's parser gets it out of its frame.
fn bare(request: &Request) -> Vec<u8> {
    postcard::to_slice(request, &mut [0; FRAME_BYTES]).expect("fits in a frame").to_vec()
}

fn framed(message: &impl serde::Serialize) -> Vec<u8> {
    wire::encode(message, &mut [0; FRAME_BYTES]).expect("fits in a frame").to_vec()
}

fn write(target: &str, name: &str, bytes: &[u8]) {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    std::fs::create_dir_all(&directory).expect("the sources can be written");
    std::fs::write(directory.join(name), bytes).expect("the sources can be written");
}
