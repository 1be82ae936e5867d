//! The live page in a real browser, clicked through: it draws the loop as it comes, stops the
//! board, shows a fault with its cure and releases it. Skipped, in so many words, without Chromium.

mod browser;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use board_client::bus::client::Address;
use board_client::bus::port::{Line, Parity};
use board_client::bus::{Board, upload};
use board_models::paper_parameters;
use browser::{BROWSERS, Browser};
use host_tests::desk::Desk;
use rustix::process::{Pid, Signal, kill_process};
use wire::registers::{Command as Order, Id, Value};
use wire::{Configuration, State, VERSION};

/// `mgpi watch`, until it is ended.
struct Watch {
    program: Child,
    address: String,
}

impl Watch {
    fn start(port: &Path) -> Self {
        let test = std::env::current_exe().expect("this program");
        let mgpi = test.parent().and_then(Path::parent).expect("its directory").join("mgpi");
        let mut program = Command::new(mgpi)
            .args(["watch", "--http", "127.0.0.1:0", "--port"])
            .arg(port)
            .stdout(Stdio::piped())
            .spawn()
            .expect("mgpi runs");
        let mut line = String::new();
        BufReader::new(program.stdout.take().expect("its output")).read_line(&mut line).expect("a line");
        let address = line.split_whitespace().next().expect("an address").to_owned();
        Self { program, address }
    }

    /// Ends it as a user does.
    fn end(mut self) {
        kill_process(Pid::from_child(&self.program), Signal::INT).expect("interrupted");
        assert!(self.program.wait().expect("ended").success());
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        // It has ended, unless the test has failed.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn open(desk: &Desk) -> Board {
    let address = Address {
        port: desk.port().to_owned(),
        line: Line { baud: 115_200, parity: Parity::None },
        unit: 1,
        limit: Duration::from_millis(500),
    };
    Board::open(address).expect("a board")
}

/// Tracks a set point, and leaves the board alone with it.
fn track(desk: &Desk, reference_mm: f32) {
    let mut board = open(desk);
    let mode: Vec<u16> = std::iter::once(0).chain(Value::F32(reference_mm).words()).collect();
    board.write(Id::Mode, &mode).expect("written");
    board.drive(Order::Start, State::Tracking).expect("started");
}

#[test]
fn the_page_shows_the_loop_stops_the_board_and_releases_a_fault() {
    let Some(name) = Browser::find() else {
        println!("the live page is not looked at in a browser: there is none of {}", BROWSERS.join(", "));
        return;
    };
    let profile = tempfile::tempdir().expect("a temporary directory");
    let desk = Desk::new(1.0, |_, bytes| bytes);
    let tracking = paper_parameters().expect("valid");
    let configuration = Configuration { version: VERSION, tracking };
    upload::deploy(&mut open(&desk), &configuration, &|_, _| ()).expect("deployed");
    track(&desk, 40.0);

    let watch = Watch::start(desk.port());
    let mut browser = Browser::start(name, profile.path());
    browser.open(&watch.address, 1200);
    browser.wait("document.querySelector('#state')?.textContent === 'Tracking'");
    for plot in ["contraction", "pressure", "loop", "error"] {
        // A set point that stays is a line of two points.
        browser.wait(&format!(
            "[...document.querySelectorAll('#{plot} polyline')].some(line => line.points.numberOfItems > 40)"
        ));
    }
    browser.wait("parseFloat(document.querySelector('#now').textContent) > 20");
    browser.wait("/^\\d+\\.\\d+ mm over the last \\d+ s/.test(document.querySelector('#rmse').textContent)");
    let said = |browser: &mut Browser, id: &str| {
        browser.value(&format!("document.querySelector('{id}').textContent")).to_string()
    };
    assert!(said(&mut browser, "#mode").contains("feed-forward and feedback"));
    let gains = said(&mut browser, "#gains");
    assert!(["kp", "ki", "kd"].iter().all(|gain| gains.contains(gain)), "{gains}");
    browser.picture("watch-tracking");
    browser.click("#pause");
    let drawn = "[...document.querySelectorAll('#contraction polyline')].map(line => line.getAttribute('points')).join('|')";
    let held = browser.value(drawn);
    thread::sleep(Duration::from_millis(400));
    let later = browser.value(drawn);
    assert_eq!(held, later, "a paused page goes on");
    browser.click("#pause");
    browser.wait("document.querySelector('#pause').textContent === 'Pause the page'");
    let head = browser.value("tableOfRows().split('\\n')[0]");
    assert_eq!(head, "time_s,reference_mm,contraction_mm,pressure_bar,command_bar");
    assert!(browser.value("tableOfRows().split('\\n').length").as_f64() > Some(40.0));
    assert_eq!(browser.value("document.querySelector('#acknowledge').disabled"), true);
    browser.click("#stop");
    browser.wait("document.querySelector('#state').textContent === 'Ready'");
    browser.wait("parseFloat(document.querySelector('#now').textContent) < 5");
    watch.end();

    // A limit that the muscle runs into.
    open(&desk).set(Id::OverpressureHard, 0.5).expect("written");
    track(&desk, 60.0);
    let watch = Watch::start(desk.port());
    for width in [390, 1200] {
        browser.open(&watch.address, width);
        browser.wait("document.querySelector('#state')?.textContent === 'Fault'");
        // The muscle rests: its loop is hardly more than a point.
        browser.wait("document.querySelector('#loop polyline').points.numberOfItems > 0");
        let smallest = "Math.min(...[...document.querySelectorAll('svg text')].map(text => \
                        parseFloat(getComputedStyle(text).fontSize) * text.getScreenCTM().a).filter(size => size > 0))";
        let letters = browser.value(smallest).as_f64().expect("a number");
        assert!(letters >= 9.0, "letters of {letters} pixels at {width} pixels");
        let overlaps = "[...document.querySelectorAll('figure > svg')].flatMap(plot => {
            const texts = [...plot.querySelectorAll('text')], boxes = texts.map(text => text.getBoundingClientRect());
            return boxes.flatMap((a, i) => boxes.slice(i + 1).flatMap((b, k) =>
                Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
                && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1
                    ? [`${texts[i].textContent} over ${texts[i + 1 + k].textContent}`] : []));
        }).join(', ')";
        assert_eq!(browser.value(overlaps), "", "letters over others at {width} pixels");
        let is_wider = "document.documentElement.scrollWidth > document.documentElement.clientWidth";
        assert_eq!(browser.value(is_wider), false, "at {width} pixels the page is wider");
        browser.picture(&format!("watch-fault-{width}"));
    }
    let faults = browser.value("document.querySelector('#faults').textContent").to_string();
    assert!(faults.contains("latched, 1 time") && faults.contains("Cure:"), "{faults}");
    browser.click("#acknowledge");
    browser.wait("['Ready', 'SelfTest'].includes(document.querySelector('#state').textContent)");
    browser.wait("document.querySelector('#acknowledge').disabled");
    assert_eq!(browser.errors, [""; 0]);
    let own = |address: &String| address.starts_with("http://127.0.0.1:") || address.starts_with("data:");
    assert!(browser.asked.iter().all(own), "something from outside: {:?}", browser.asked);
    watch.end();
    browser.wait("document.querySelector('#state').textContent === 'Ended'");
    browser.wait("document.querySelector('#problem').textContent.startsWith('The run has ended')");
    for button in ["stop", "acknowledge", "pause"] {
        let is_hidden = browser.value(&format!("document.querySelector('#{button}').hidden"));
        assert_eq!(is_hidden, true, "{button} of a run that has ended");
    }
    browser.picture("watch-ended");
}
