//! Writes the valid inputs that the binary targets begin with into `tools/fuzz/corpus`. Run it
//! after each change of the messages: `cargo run --manifest-path tools/fuzz/Cargo.toml --example
//! seeds`.

use std::path::Path;

use board_client::pil::lock_step::Board;
use board_models::{paper_parameters, piecewise_parameters};
use firmware::store::{ParameterStore, Parameters};
use host_tests::HostBoard;
use host_tests::flash::MockFlash;
use host_tests::store::{full_set, numbered, paper_set};
use model_core::Mode;
use wire::registers::{Id, UPLOAD_BYTES, UPLOAD_REGISTERS, Value, checksum, pack_bytes};
use wire::{CaptureOrder, Configuration, FRAME_BYTES, Protection, Request, State, TickRequest, VERSION};

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
    for (name, tracking) in [("paper", paper_parameters()), ("piecewise", piecewise_parameters())] {
        write(
            "bus",
            name,
            &on_the_bus(Configuration { version: VERSION, tracking: tracking.expect("valid") }),
        );
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
        Request::Tick(TickRequest {
            reference_mm: Some(reference_mm),
            pressure_code: 700,
            contraction_code,
            load_n: None,
            temperature_c: None,
        })
    };
    let paper = configure(paper_parameters().expect("valid"));
    let piecewise = configure(piecewise_parameters().expect("valid"));
    let full = configure(full_set().tracking.expect("a model"));
    let swing = [tick(10.0, 300), tick(60.0, 900), tick(20.0, 800)];
    let questions = [Request::Identify, Request::Telemetry, Request::FaultRecord];
    let modes = [Mode::FeedbackOnly, Mode::FeedforwardOnly, Mode::Hold].map(Request::SetMode);
    let fault = [tick(f32::NAN, 900), tick(0.0, 0), Request::FaultRecord, Request::Acknowledge];
    let service = [
        Request::Protect(Protection::STANDARD),
        Request::Arm,
        Request::Service(100),
        tick(0.0, 300),
        Request::Stop,
    ];
    let capture = [CaptureOrder::Start(1), CaptureOrder::Stop, CaptureOrder::Read(0)].map(Request::Capture);
    let start = [Request::Arm, Request::Start(Mode::Both), Request::Heartbeat(1)];
    [
        ("paper", [&[paper][..], &swing[..1], &start, &swing, &modes, &fault].concat()),
        ("piecewise", [&[piecewise][..], &swing[..1], &start, &capture[..1], &swing, &capture[1..]].concat()),
        ("full", [&[full][..], &start, &swing].concat()),
        ("service", [&questions[..], &service, &questions].concat()),
    ]
}

/// A host on the bus that uploads a configuration, tracks, streams and records: the parts of the
/// target's input.
fn on_the_bus(configuration: Configuration) -> Vec<u8> {
    let mut buffer = [0; UPLOAD_BYTES];
    let bytes = postcard::to_slice(&configuration, &mut buffer).expect("fits");
    let number =
        |id: Id, number: f64| Value::of_number(id.register().kind, number).words().collect::<Vec<_>>();
    let write = |id: Id, words: &[u16]| {
        let data: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        let head = [id.register().address, words.len() as u16].map(u16::to_be_bytes).concat();
        part(&[&[16][..], &head, &[data.len() as u8], &data].concat())
    };
    let set = |id: Id, value: f64| write(id, &number(id, value));
    let read = |id: Id, count: u16| {
        part(&[&[3][..], &id.register().address.to_be_bytes(), &count.to_be_bytes()].concat())
    };
    let blocks = bytes.chunks(2 * usize::from(UPLOAD_REGISTERS)).enumerate().flat_map(|(k, block)| {
        let words: Vec<u16> = pack_bytes(block).collect();
        write(Id::UploadOffset, &[&[k as u16 * 2 * UPLOAD_REGISTERS], &words[..]].concat())
    });
    let points = [0.0, 20.0, 40.0].map(|point| number(Id::PushPoints, point)).concat();
    let track = [
        set(Id::UploadLength, bytes.len() as f64),
        set(Id::UploadChecksum, checksum(bytes).into()),
        set(Id::UploadOrder, 1.0),
        set(Id::Kp, 0.1),
        set(Id::Command, 6.0),
        set(Id::Command, 1.0),
        set(Id::Heartbeat, 1.0),
        set(Id::CaptureEvery, 1.0),
        write(Id::PushNumber, &[number(Id::PushNumber, 0.0), points].concat()),
        set(Id::StreamOrder, 1.0),
        read(Id::State, 38),
        read(Id::CaptureFirst, 125),
        set(Id::Command, 2.0),
        set(Id::Command, 6.0),
        set(Id::Command, 5.0),
        set(Id::SetpointBar, 3.0),
        // Nothing but bytes.
        vec![0, 3, 1, 2, 3],
        set(Id::Command, 2.0),
    ];
    blocks.chain(track.concat()).collect()
}

/// A frame to the board.
fn part(pdu: &[u8]) -> Vec<u8> {
    [&[2, pdu.len() as u8], pdu].concat()
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
