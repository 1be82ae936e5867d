//! What comes in: orders that are answered, set points that are not, a stop for all.
//!
//! | key | what | answer |
//! |---|---|---|
//! | `order` of a board | a query with `{"order": "start"}`, `"stop"` or `"acknowledge"` | `{"done": true}`, of a start with its `grant`; or an error with its `reason` |
//! | `setpoint` of a board | `{"grant": 7, "sequence": 1, "setpoint_mm": 20.0, "sent_s": 1.7e9}` | none; on `refused` if it is not taken |
//! | `stop` of the gateway | anything | none: every board of every line is stopped and vented |
//!
//! A query may be for many boards at once, by a pattern in its key; each answers by its own key.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use gateway::Gateway;
use gateway::boards::Boards;
use gateway::driving::SetPoint;
use serde::Deserialize;
use serde_json::{Value, json};
use zenoh::bytes::Encoding;
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::key_expr::KeyExpr;
use zenoh::pubsub::Subscriber;
use zenoh::query::{Query, Queryable};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::NetworkError;
use crate::keys::Keys;

/// How many orders, and how many words of refusal, may wait: beyond them a client that floods is
/// told no more.
const WAITING: usize = 64;

/// A set point that was not taken.
#[derive(Debug)]
pub struct Refusal {
    /// The board's place among all.
    pub index: usize,
    /// That of the set point, if it could be read.
    pub sequence: Option<u64>,
    /// Why.
    pub reason: String,
}

/// Takes orders, until it is dropped.
#[derive(Debug)]
pub struct Orders {
    _setpoints: Subscriber<()>,
    _stop: Subscriber<()>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Order {
    order: Kind,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Start,
    Stop,
    Acknowledge,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetPointMessage {
    grant: u32,
    sequence: u64,
    setpoint_mm: f64,
    sent_s: f64,
}

impl Orders {
    /// Takes what comes for the boards of a gateway. What is refused comes out of the receiver.
    ///
    /// # Errors
    /// The session does not take a key.
    pub fn start(
        session: &Session,
        gateway: &Arc<Gateway>,
        keys: &Keys,
    ) -> Result<(Self, Receiver<Refusal>), NetworkError> {
        let of = |problem: zenoh::Error| NetworkError::of(&problem);
        let queries = session
            .declare_queryable(keys.of_any("order"))
            .with(FifoChannel::new(WAITING))
            .wait()
            .map_err(of)?;
        let (all, its) = (gateway.clone(), keys.clone());
        // It ends with the session: an order may wait for its line, which must not hold up others.
        thread::spawn(move || answer(&queries, &all, &its));
        let (refused, refusals) = sync_channel(WAITING);
        let (all, its) = (gateway.clone(), keys.clone());
        let setpoints = session
            .declare_subscriber(keys.of_any("setpoint"))
            .callback(move |sample| take(&sample, &all, &its, &refused))
            .wait()
            .map_err(of)?;
        let all = gateway.clone();
        let stop = session
            .declare_subscriber(keys.of_all("stop"))
            .callback(move |_| all.stop_all())
            .wait()
            .map_err(of)?;
        Ok((Self { _setpoints: setpoints, _stop: stop }, refusals))
    }
}

/// Answers until the session ends.
fn answer(queries: &Queryable<FifoChannelHandler<Query>>, gateway: &Gateway, keys: &Keys) {
    while let Ok(query) = queries.recv() {
        let content = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        let order: Result<Order, _> = serde_json::from_slice(&content);
        for (index, key) in of_pattern(keys, "order", query.key_expr()) {
            let done = match &order {
                Ok(Order { order }) => carry_out(gateway, index, *order),
                Err(problem) => Err(format!("no order: {problem}")),
            };
            // Who has asked may have gone.
            let _ = match done {
                Ok(told) => query.reply(key, told.to_string()).encoding(Encoding::APPLICATION_JSON).wait(),
                Err(reason) => query
                    .reply_err(json!({"key": key, "reason": reason}).to_string())
                    .encoding(Encoding::APPLICATION_JSON)
                    .wait(),
            };
        }
    }
}

fn carry_out(gateway: &Gateway, index: usize, order: Kind) -> Result<Value, String> {
    match order {
        Kind::Start => gateway.start_board(index).map(|grant| json!({"done": true, "grant": grant})),
        Kind::Stop => gateway.stop(index).map(|()| json!({"done": true})),
        Kind::Acknowledge => gateway.acknowledge(index).map(|()| json!({"done": true})),
    }
    .map_err(|refused| refused.to_string())
}

/// The boards whose key a pattern is for, with these keys.
fn of_pattern(keys: &Keys, what: &str, pattern: &KeyExpr<'_>) -> Vec<(usize, String)> {
    let key = |index| (index, keys.of_board(index, what));
    let is_meant = |(_, key): &(usize, String)| {
        KeyExpr::try_from(key.as_str()).is_ok_and(|key| pattern.intersects(&key))
    };
    keys.indices().map(key).filter(is_meant).collect()
}

/// Takes a set point.
fn take(sample: &Sample, gateway: &Gateway, keys: &Keys, refused: &SyncSender<Refusal>) {
    // One board's: a set point has the grant of one.
    if let Some(index) = keys.index(sample.key_expr(), "setpoint") {
        let message: Result<SetPointMessage, _> = serde_json::from_slice(&sample.payload().to_bytes());
        let (sequence, taken) = match &message {
            Ok(message) => {
                let &SetPointMessage { grant, sequence, setpoint_mm, sent_s } = message;
                let age_s = Boards::unix_s(Boards::now_s()) - sent_s;
                let point = SetPoint { grant, sequence, mm: setpoint_mm, age_s };
                (Some(sequence), gateway.set(index, point).map_err(|refused| refused.to_string()))
            }
            Err(problem) => (None, Err(format!("no set point: {problem}"))),
        };
        if let Err(reason) = taken {
            // Where nobody publishes any more, or not fast enough, nobody is told.
            let _ = refused.try_send(Refusal { index, sequence, reason });
        }
    }
}
