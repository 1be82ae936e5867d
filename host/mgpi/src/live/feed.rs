//! What is shown: the last minutes of the loop and the board's status, from the thread that speaks
//! with the board to those that speak with browsers; and orders the other way.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};

/// Rows that are kept for a browser that comes later: some two minutes.
const KEPT: usize = 4000;

/// A moment of the loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Unit: s.
    pub time_s: f64,
    /// What is wanted; none where no controller runs. Unit: mm.
    pub reference_mm: Option<f64>,
    /// Unit: mm.
    pub contraction_mm: f64,
    /// Unit: bar.
    pub pressure_bar: f64,
    /// Unit: bar.
    pub command_bar: f64,
}

/// What a page asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Stop and vent.
    Stop,
    /// Release the latched fault.
    Acknowledge,
}

/// What is shown, shared by all threads.
#[derive(Clone, Debug, Default)]
pub struct Feed(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    shown: Mutex<Shown>,
    is_new: Condvar,
}

#[derive(Debug, Default)]
struct Shown {
    rows: VecDeque<Row>,
    /// Number of the row behind the last one.
    next: u64,
    status: Value,
    /// How often the status has changed.
    changes: u64,
    orders: Vec<Order>,
}

/// What a browser has seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    next: u64,
    changes: u64,
}

impl Feed {
    /// Shows rows.
    pub fn rows(&self, rows: impl IntoIterator<Item = Row>) {
        let mut shown = self.lock();
        for row in rows {
            if shown.rows.len() == KEPT {
                shown.rows.pop_front();
            }
            shown.rows.push_back(row);
            shown.next += 1;
        }
        self.0.is_new.notify_all();
    }

    /// Shows a status, as `mgpi status --json` has it, or `{"problem": words}`, or `{"ended":
    /// true}`.
    pub fn status(&self, status: Value) {
        let mut shown = self.lock();
        shown.status = status;
        shown.changes += 1;
        self.0.is_new.notify_all();
    }

    /// Shows that the run has ended; nothing comes after that.
    pub fn end(&self) {
        self.status(json!({"ended": true}));
    }

    /// Asks for something.
    pub fn order(&self, order: Order) {
        self.lock().orders.push(order);
    }

    /// What was asked for since the last time, the oldest first.
    pub fn orders(&self) -> Vec<Order> {
        std::mem::take(&mut self.lock().orders)
    }

    /// What there is beyond what was seen, as soon as there is something; none within `limit` is
    /// `None`.
    pub fn news(&self, seen: &mut Seen, limit: Duration) -> Option<Value> {
        let shown = self.lock();
        let is_old = |shown: &mut Shown| shown.next == seen.next && shown.changes == seen.changes;
        let waited = self.0.is_new.wait_timeout_while(shown, limit, is_old);
        let (shown, waited) = waited.unwrap_or_else(PoisonError::into_inner);
        if waited.timed_out() {
            return None;
        }
        let fresh = (shown.next - seen.next).min(shown.rows.len() as u64) as usize;
        let rows: Vec<Value> =
            shown.rows.range(shown.rows.len() - fresh..).copied().map(Row::into_json).collect();
        let status = if shown.changes == seen.changes { Value::Null } else { shown.status.clone() };
        *seen = Seen { next: shown.next, changes: shown.changes };
        Some(json!({"rows": rows, "status": status}))
    }

    fn lock(&self) -> MutexGuard<'_, Shown> {
        // A thread that panicked while it held the lock left something to show all the same.
        self.0.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Row {
    fn into_json(self) -> Value {
        let Self { time_s, reference_mm, contraction_mm, pressure_bar, command_bar } = self;
        json!([time_s, reference_mm, contraction_mm, pressure_bar, command_bar])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(time_s: f64) -> Row {
        Row { time_s, ..Row::default() }
    }

    #[test]
    fn what_was_seen_does_not_come_again_and_a_late_browser_gets_what_is_kept() {
        let feed = Feed::default();
        let mut seen = Seen::default();
        assert_eq!(feed.news(&mut seen, Duration::ZERO), None);
        feed.rows([row(1.0), row(2.0)]);
        feed.status(json!({"state": "Ready"}));
        let news = feed.news(&mut seen, Duration::ZERO).expect("news");
        assert_eq!(news["rows"].as_array().map(Vec::len), Some(2));
        assert_eq!(news["status"]["state"], "Ready");
        feed.rows([row(3.0)]);
        let news = feed.news(&mut seen, Duration::ZERO).expect("news");
        assert_eq!((&news["rows"], &news["status"]), (&json!([[3.0, null, 0.0, 0.0, 0.0]]), &Value::Null));
        feed.rows((0..2 * KEPT).map(|i| row(i as f64)));
        let news = feed.news(&mut Seen::default(), Duration::ZERO).expect("news");
        assert_eq!(news["rows"].as_array().map(Vec::len), Some(KEPT));
    }

    #[test]
    fn orders_are_taken_once() {
        let feed = Feed::default();
        feed.order(Order::Stop);
        feed.order(Order::Acknowledge);
        assert_eq!(feed.orders(), [Order::Stop, Order::Acknowledge]);
        assert_eq!(feed.orders(), []);
    }
}
