//! What comes in: orders that are answered, set points that are not, a stop for all.
//!
//! | key | what | answer |
//! |---|---|---|
//! | `order` of a board | a query with `{"order": "start"}`, `"stop"` or `"acknowledge"` | `{"done": true}`, of a start with its `grant`; or an error with its `reason` |
//! | `setpoint` of a board | `{"grant": 7, "sequence": 1, "setpoint_mm": 20.0, "sent_s": 1.7e9}`; without `setpoint_mm` a sign of life alone | none; on `refused` if it is not taken |
//! | `order` and `setpoint` of a group | the same for all of its boards, with one grant | one, for all; set points on `refused` of each board |
//! | `trajectory` of the gateway | a query with `{"start_s": 1.7e9, "parts": [{"board": "biceps", "grant": 7, "points": [[0.5, 20.0]]}]}` | `{"done": true, "start_s": 1.7e9}`, or an error with its `reason` |
//! | `reload` of the gateway | a query: the file of the lines is read again | `{"done": true}`, or an error with its `reason` |
//! | `stop` of the gateway | anything | none: every board of every line is stopped and vented |
//!
//! A query may be for many boards at once, by a pattern in its key; each answers by its own key, at a
//! start when all have been tried. A query by keys of another version is answered by an error that says so.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use gateway::boards::Boards;
use gateway::driving::SetPoint;
use gateway::{Gateway, Part};
use serde::{Deserialize, Deserializer};
use serde_json::{Value, json};
use zenoh::bytes::Encoding;
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::key_expr::KeyExpr;
use zenoh::pubsub::Subscriber;
use zenoh::query::{Query, Queryable};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::keys::{Keys, VERSION};
use crate::{NetworkError, Reload};

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
    _setpoints: [Subscriber<()>; 2],
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
    #[serde(default, deserialize_with = "given")]
    setpoint_mm: Option<f64>,
    sent_s: f64,
}

/// A number that is there has to be one: what a program writes for none is no sign of life.
fn given<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    f64::deserialize(deserializer).map(Some)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TrajectoryMessage {
    start_s: Option<f64>,
    parts: Vec<PartMessage>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PartMessage {
    /// The name of a board or a group.
    board: String,
    grant: u32,
    /// Time from the start on (s), set point (mm).
    points: Vec<(f64, f64)>,
}

impl Orders {
    /// Takes what comes for the boards of a gateway. What is refused comes out of the receiver.
    ///
    /// # Errors
    /// The session does not take a key.
    pub fn start(
        session: &Session,
        gateway: &Arc<Gateway>,
        reload: &Reload,
        keys: &Keys,
    ) -> Result<(Self, Receiver<Refusal>), NetworkError> {
        let of = |problem: zenoh::Error| NetworkError::of(&problem);
        let (all, its) = (gateway.clone(), keys.clone());
        answer_each(session, keys.of_any("order"), move |query| answer(query, &all, &its))?;
        let (all, its) = (gateway.clone(), keys.clone());
        answer_each(session, keys.of_any_group("order"), move |query| answer_group(query, &all, &its))?;
        let (all, key) = (gateway.clone(), keys.of_all("trajectory"));
        answer_each(session, key.clone(), move |query| reply(query, &key, play(&all, &content(query))))?;
        let (reload, key) = (reload.clone(), keys.of_all("reload"));
        answer_each(session, key.clone(), move |query| {
            reply(query, &key, reload().map(|()| json!({"done": true})));
        })?;
        answer_each(session, keys.of_any_version(), other_version)?;
        let (refused, refusals) = sync_channel(WAITING);
        let subscribe = |keys_of: String, refused: SyncSender<Refusal>| {
            let (all, its) = (gateway.clone(), keys.clone());
            session
                .declare_subscriber(keys_of)
                .callback(move |sample| take(&sample, &all, &its, &refused))
                .wait()
                .map_err(of)
        };
        let setpoints = [
            subscribe(keys.of_any("setpoint"), refused.clone())?,
            subscribe(keys.of_any_group("setpoint"), refused)?,
        ];
        let all = gateway.clone();
        let stop = session
            .declare_subscriber(keys.of_all("stop"))
            .callback(move |_| all.stop_all())
            .wait()
            .map_err(of)?;
        Ok((Self { _setpoints: setpoints, _stop: stop }, refusals))
    }
}

/// Answers queries one by one, in a thread of its own that ends with the session: one may wait for
/// its line, which must not hold up others.
fn answer_each(
    session: &Session,
    key: String,
    answer: impl Fn(&Query) + Send + 'static,
) -> Result<(), NetworkError> {
    let queries: Queryable<FifoChannelHandler<Query>> = session
        .declare_queryable(key)
        .with(FifoChannel::new(WAITING))
        .wait()
        .map_err(|problem| NetworkError::of(&problem))?;
    thread::spawn(move || {
        while let Ok(query) = queries.recv() {
            answer(&query);
        }
    });
    Ok(())
}

fn content(query: &Query) -> Vec<u8> {
    query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default()
}

fn reply(query: &Query, key: &str, done: Result<Value, String>) {
    // Who has asked may have gone.
    let _ = match done {
        Ok(told) => query.reply(key, told.to_string()).encoding(Encoding::APPLICATION_JSON).wait(),
        Err(reason) => query
            .reply_err(json!({"key": key, "reason": reason}).to_string())
            .encoding(Encoding::APPLICATION_JSON)
            .wait(),
    };
}

/// Answers an order to boards.
fn answer(query: &Query, gateway: &Gateway, keys: &Keys) {
    let content = content(query);
    let meant = of_pattern(keys.all("order"), query.key_expr());
    if let Ok(Order { order: Kind::Start }) = serde_json::from_slice(&content) {
        let boards: Vec<usize> = meant.iter().map(|(index, _)| *index).collect();
        for ((_, key), started) in meant.iter().zip(gateway.start_each(&boards)) {
            reply(query, key, started.map(granted).map_err(|refused| refused.to_string()));
        }
        return;
    }
    for (index, key) in meant {
        reply(query, &key, carry_out(gateway, &[index], &content));
    }
}

/// Answers an order to groups.
fn answer_group(query: &Query, gateway: &Gateway, keys: &Keys) {
    let content = content(query);
    let key = |(group, places): (String, Vec<usize>)| (places, keys.of_group(&group, "order"));
    let groups = gateway.groups().into_iter().map(key).collect();
    for (places, key) in of_pattern(groups, query.key_expr()) {
        reply(query, &key, carry_out(gateway, &places, &content));
    }
}

/// Says to who speaks another version that this is not his.
fn other_version(query: &Query) {
    let key = query.key_expr().as_str();
    let version = key.splitn(3, '/').take(2).collect::<Vec<_>>().join("/");
    if version != VERSION && !version.contains('*') {
        reply(query, key, Err(format!("this gateway speaks {VERSION}, not {version}")));
    }
}

fn carry_out(gateway: &Gateway, boards: &[usize], order: &[u8]) -> Result<Value, String> {
    let Order { order } = serde_json::from_slice(order).map_err(|problem| format!("no order: {problem}"))?;
    match order {
        Kind::Start => gateway.start_boards(boards).map(granted),
        Kind::Stop => gateway.stop(boards).map(|()| json!({"done": true})),
        Kind::Acknowledge => gateway.acknowledge(boards).map(|()| json!({"done": true})),
    }
    .map_err(|refused| refused.to_string())
}

/// The answer to a start.
fn granted(grant: u32) -> Value {
    json!({"done": true, "grant": grant})
}

/// Takes a trajectory.
fn play(gateway: &Gateway, content: &[u8]) -> Result<Value, String> {
    let message: TrajectoryMessage =
        serde_json::from_slice(content).map_err(|problem| format!("no trajectory: {problem}"))?;
    let mut parts = Vec::new();
    for PartMessage { board, grant, points } in message.parts {
        let places = gateway.named(&board);
        if places.is_empty() {
            return Err(format!("{board}: there is no board or group of this name"));
        }
        parts.extend(places.into_iter().map(|index| Part { index, grant, points: points.clone() }));
    }
    if parts.is_empty() {
        return Err("no trajectory: it is for no board".to_owned());
    }
    // The moment at which 1970 was, since the gateway's start.
    let epoch_s = -Boards::unix_s(0.0);
    match gateway.play(parts, message.start_s.map(|start_s| epoch_s + start_s)) {
        Ok(start_s) => Ok(json!({"done": true, "start_s": Boards::unix_s(start_s)})),
        Err((index, refused)) => {
            let name = gateway.boards().all().get(index).map_or_else(String::new, |board| board.name.clone());
            Err(format!("{name}: {refused}"))
        }
    }
}

/// Those whose key a pattern is for.
fn of_pattern<T>(keys: Vec<(T, String)>, pattern: &KeyExpr<'_>) -> Vec<(T, String)> {
    let is_meant =
        |(_, key): &(T, String)| KeyExpr::try_from(key.as_str()).is_ok_and(|key| pattern.intersects(&key));
    keys.into_iter().filter(is_meant).collect()
}

/// Takes a set point of a board or a group.
fn take(sample: &Sample, gateway: &Gateway, keys: &Keys, refused: &SyncSender<Refusal>) {
    let key = sample.key_expr().as_str();
    // A pattern is nobody's: a set point has the grant of one.
    let boards = match keys.index(key, "setpoint") {
        Some(index) => vec![index],
        None => keys.group(key, "setpoint").map_or_else(Vec::new, |group| gateway.group(group)),
    };
    let message: Result<SetPointMessage, _> = serde_json::from_slice(&sample.payload().to_bytes());
    for index in boards {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_point_that_is_no_number_is_no_sign_of_life() {
        let read = |point: &str| {
            let text = format!("{{\"grant\": 1, \"sequence\": 2, \"sent_s\": 3.0{point}}}");
            serde_json::from_str::<SetPointMessage>(&text).map(|message| message.setpoint_mm)
        };
        assert_eq!(read(", \"setpoint_mm\": 20").expect("a number"), Some(20.0));
        assert_eq!(read("").expect("a sign of life"), None);
        assert!(read(", \"setpoint_mm\": null").is_err());
        assert!(read(", \"setpoint\": 20").is_err());
    }
}
