//! A headless Chromium that is driven over its debugging pipe: real clicks, and what the page says
//! of itself.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// The browsers that will do.
pub const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// Longest time for an answer, or for something to show.
const LIMIT: Duration = Duration::from_secs(30);

/// The browser, until it is dropped.
pub struct Browser {
    process: Child,
    commands: ChildStdin,
    messages: Receiver<Value>,
    last: u64,
    session: Option<String>,
    /// What the page has thrown or called an error, and the addresses that it has asked.
    pub errors: Vec<String>,
    /// Every address that was asked for.
    pub asked: Vec<String>,
}

impl Browser {
    /// The name of one that this machine has.
    pub fn find() -> Option<&'static str> {
        BROWSERS.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok())
    }

    /// Starts it, with an empty page.
    pub fn start(name: &str, profile: &Path) -> Self {
        // The pipe is wanted at the numbers 3 and 4.
        let line = format!(
            "exec {name} --headless --no-sandbox --disable-gpu --no-first-run --hide-scrollbars \
             --remote-debugging-pipe --user-data-dir='{}' 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null",
            profile.display()
        );
        let mut process = Command::new("sh")
            .args(["-c", &line])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the browser");
        let commands = process.stdin.take().expect("its input");
        let output = process.stdout.take().expect("its output");
        let (sender, messages) = channel();
        thread::spawn(move || {
            for message in BufReader::new(output).split(0).map_while(Result::ok) {
                let message = serde_json::from_slice(&message).expect("JSON");
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let (errors, asked) = (Vec::new(), Vec::new());
        let mut browser = Self { process, commands, messages, last: 0, session: None, errors, asked };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}))["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({"targetId": target, "flatten": true}));
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Goes to an address, in a window of this width, and waits until the page before is left: it
    /// is shown for a while, and would be asked in the place of the new one.
    pub fn open(&mut self, address: &str, width: u32) {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", size);
        self.value("window.isLeft = true");
        self.call("Page.navigate", json!({"url": address}));
        self.wait("!window.isLeft");
    }

    /// What an expression is in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let answer = self.call("Runtime.evaluate", json!({"expression": expression, "returnByValue": true}));
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str) {
        let deadline = Instant::now() + LIMIT;
        while self.value(expression) != Value::Bool(true) {
            assert!(Instant::now() < deadline, "never true: {expression}; errors: {:?}", self.errors);
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// Presses the mouse's button where an element is.
    pub fn click(&mut self, element: &str) {
        let middle = self.value(&format!(
            "(() => {{ const box = document.querySelector('{element}').getBoundingClientRect(); \
             return [box.x + box.width / 2, box.y + box.height / 2] }})()"
        ));
        for kind in ["mousePressed", "mouseReleased"] {
            let place =
                json!({"type": kind, "x": middle[0], "y": middle[1], "button": "left", "clickCount": 1});
            self.call("Input.dispatchMouseEvent", place);
        }
    }

    /// Keeps a picture of the page, as base64 of a PNG, in the directory that `MGPI_SCREENSHOTS`
    /// names.
    pub fn picture(&mut self, name: &str) {
        if let Some(directory) = std::env::var_os("MGPI_SCREENSHOTS") {
            let whole = json!({"format": "png", "captureBeyondViewport": true});
            let picture = self.call("Page.captureScreenshot", whole);
            let content = picture["data"].as_str().expect("a picture");
            std::fs::write(Path::new(&directory).join(format!("{name}.png.base64")), content)
                .expect("written");
        }
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({"id": self.last, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).expect("the browser listens");
        loop {
            let message = self.messages.recv_timeout(LIMIT).expect(method);
            if message["id"] == self.last {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
            self.note(&message);
        }
    }

    fn note(&mut self, message: &Value) {
        let about = &message["params"];
        match message["method"].as_str() {
            Some("Runtime.exceptionThrown") => self.errors.push(about["exceptionDetails"].to_string()),
            Some("Runtime.consoleAPICalled") if about["type"] == "error" => {
                self.errors.push(about["args"].to_string())
            }
            Some("Log.entryAdded") if about["entry"]["level"] == "error" => {
                self.errors.push(about["entry"].to_string())
            }
            Some("Network.requestWillBeSent") => {
                self.asked.push(about["request"]["url"].as_str().unwrap_or_default().to_owned());
            }
            _ => {}
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
