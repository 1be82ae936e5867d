//! A serial line whose other end is a program: a pseudo terminal.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use board_client::emulator::terminal::PseudoTerminal;
use rmodbus::{ModbusProto, guess_request_frame_len};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// A line that somebody answers.
pub struct Line {
    path: PathBuf,
    stop: Arc<AtomicBool>,
    server: Option<JoinHandle<()>>,
}

impl Line {
    /// Gives every whole request, with its CRC, to `answer`; what that answers goes back.
    pub fn new(mut answer: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let mut terminal = PseudoTerminal::open().expect("a pseudo terminal");
        let path = terminal.path().to_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let asked = stop.clone();
        let server = thread::spawn(move || {
            let (mut request, end) = (Vec::new(), terminal.end());
            while !asked.load(Ordering::Relaxed) {
                let slice = Timespec { tv_sec: 0, tv_nsec: 10_000_000 };
                if poll(&mut [PollFd::new(&*end, PollFlags::IN)], Some(&slice)).is_ok_and(|ready| ready == 0)
                {
                    continue;
                }
                let mut buffer = [0; 512];
                let count = end.read(&mut buffer).expect("readable");
                request.extend_from_slice(&buffer[..count]);
                while request.len() >= 7 {
                    let length =
                        guess_request_frame_len(&request, ModbusProto::Rtu).expect("a request").into();
                    if request.len() < length {
                        break;
                    }
                    let frame: Vec<u8> = request.drain(..length).collect();
                    end.write_all(&answer(&frame)).expect("writable");
                }
            }
        });
        Self { path, stop, server: Some(server) }
    }

    /// The end that a client opens.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(server) = self.server.take() {
            server.join().expect("the server has not panicked");
            // The last bytes are on their way.
            thread::sleep(Duration::from_millis(1));
        }
    }
}

/// A frame with its CRC.
pub fn framed(content: &[u8]) -> Vec<u8> {
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS).checksum(content);
    [content, &crc.to_le_bytes()].concat()
}
