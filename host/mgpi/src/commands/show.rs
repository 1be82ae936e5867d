//! A board that is shown on a page while a command works with it.

use std::net::SocketAddr;
use std::thread;
use std::time::{Duration, Instant};

use crate::live::{Feed, LiveError, Order, Row, serve};
use board_client::bus::Board;
use board_client::bus::client::BusError;
use board_client::bus::play::Tick;
use board_client::bus::status::Status;
use board_client::stop::Stop;

/// Time between two rows of the page.
pub const ROW: Duration = Duration::from_millis(40);
/// Time between two looks at all the rest.
const STATUS: Duration = Duration::from_millis(500);

/// How long a browser has to hear that the run has ended: the streams of events are written at
/// once.
const FAREWELL: Duration = Duration::from_millis(200);

/// The page, as long as the program runs; when this is dropped, it says that the run has ended.
#[derive(Debug)]
pub struct Show {
    feed: Feed,
    /// When the status is to be read next.
    due: Instant,
    /// Time of the last row. Unit: s.
    last_s: f64,
}

impl Show {
    /// Serves the page, and says where.
    ///
    /// # Errors
    /// The address is taken, or not this machine's.
    pub fn start(http: SocketAddr) -> Result<Self, LiveError> {
        let feed = Feed::default();
        let address = serve(http, &feed)?;
        say!("http://{address}/ shows the board; Ctrl-C ends");
        if !address.ip().is_loopback() {
            eprintln!("warning: whoever reaches {address} sees the board, and may stop it");
        }
        Ok(Self { feed, due: Instant::now(), last_s: f64::NEG_INFINITY })
    }

    /// Shows rows, as many as an eye needs, and the board's status if that is due; answers what the
    /// page asks for.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn rows(
        &mut self,
        board: &mut Board,
        rows: impl Iterator<Item = Row>,
    ) -> Result<Vec<Order>, BusError> {
        let orders = self.feed.orders();
        let last_s = &mut self.last_s;
        self.feed.rows(rows.filter(|row| {
            let is_shown = row.time_s >= *last_s + ROW.as_secs_f64() || row.time_s < *last_s;
            if is_shown {
                *last_s = row.time_s;
            }
            is_shown
        }));
        if Instant::now() >= self.due || !orders.is_empty() {
            self.feed.status(Status::read(board)?.to_json());
            self.due = Instant::now() + STATUS;
        }
        Ok(orders)
    }

    /// Looks at the status with the next rows.
    pub fn look_soon(&mut self) {
        self.due = Instant::now();
    }

    /// Shows what is wrong.
    pub fn problem(&self, problem: &str) {
        self.feed.status(serde_json::json!({"problem": problem}));
    }
}

impl Drop for Show {
    fn drop(&mut self) {
        self.feed.end();
        thread::sleep(FAREWELL);
    }
}

/// Shows recorded ticks with what was wanted (mm), if there is a page; a stop that it asks for is
/// requested.
///
/// # Errors
/// The board does not answer.
pub fn show_rows<'a>(
    show: Option<&mut Show>,
    board: &mut Board,
    stop: &Stop,
    ticks: impl Iterator<Item = (&'a Tick, Option<f64>)>,
) -> Result<(), BusError> {
    let Some(show) = show else { return Ok(()) };
    let row = |(tick, reference_mm): (&Tick, Option<f64>)| Row {
        time_s: tick.time_s,
        reference_mm,
        contraction_mm: tick.contraction_mm,
        pressure_bar: tick.pressure_bar,
        command_bar: tick.command_bar,
    };
    if show.rows(board, ticks.map(row))?.contains(&Order::Stop) {
        stop.request();
    }
    Ok(())
}
