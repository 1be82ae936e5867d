//! Bags: MCAP files, as ROS 2 and Foxglove record them, of messages in CDR or JSON.
//!
//! A variable is a number of a topic's messages: `/joint.position_1`; of a topic of one number the
//! topic itself. Topics have rates of their own, a recording has one clock: see [`clock`]. Messages
//! are read once, and their numbers put into a file ([`list`]).
//!
//! # Limits
//! Text and arrays beyond [`ELEMENTS`] numbers are passed over, as are Protobuf, the messages of
//! ROS 1, and bags of SQLite, which ROS 2 converts.

mod cdr;
mod clock;
mod definition;
mod list;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::sync::Arc;

use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use recording::input::FromPlace;
use serde_json::Value;

use super::variables::{Found, Variable};
use super::{Options, Problem};
use clock::Topic;
use definition::Definition;
use list::Store;

/// How many elements of an array are variables, at most: an array of more is a picture or a scan.
pub const ELEMENTS: usize = 64;
/// A record that says to be longer than this, and longer than the file, is damaged: memory would be
/// taken for all of it. Messages, which may be packed, are some megabytes at most. Unit: bytes.
const RECORD: usize = 1 << 30;
/// Nanoseconds in a second.
const NANOSECONDS: f64 = 1e9;
/// The parts of the time that a message is stamped with.
const STAMP: [&str; 2] = ["header.stamp.sec", "header.stamp.nanosec"];

/// How a topic's messages are read.
enum Reader {
    Cdr(Definition),
    Json,
    /// They are not; why.
    Not(String),
}

/// The variables of a bag on one clock, and what was done to get them there, in words.
///
/// # Errors
/// The bag is damaged, a message that is asked for cannot be read, or there is no such topic for a
/// clock.
pub fn found(file: &Arc<File>, options: &Options) -> Result<Found, Problem> {
    let is_asked_for = |topic: &str| {
        let mut asked = options.columns.iter().map(|renamed| renamed.column.as_str()).chain(options.clock);
        options.columns.is_empty() || asked.any(|name| belongs(name, topic))
    };
    let mut topics: BTreeMap<String, (Reader, Topic)> = BTreeMap::new();
    let store = &mut Store::new(options.scratch)?;
    let most = usize::try_from(file.metadata()?.len()).map_or(usize::MAX, |length| length.max(RECORD));
    let limits = LinearReaderOptions::default().with_record_length_limit(most);
    let bytes = BufReader::new(FromPlace::new(file, 0));
    for message in MessageReader::new_with_options(bytes, limits) {
        let message = message.map_err(|error| Problem::Damaged(error.to_string()))?;
        let name = &message.channel.topic;
        if !topics.contains_key(name) {
            let (reader, kind) = reader(&message.channel);
            topics.insert(name.clone(), (reader, Topic::new(name, kind)));
        }
        let Some((reader, topic)) = topics.get_mut(name) else { continue };
        let stamp_ns = match is_asked_for(name) {
            true => read(reader, topic, store, &message.data)?,
            false => None,
        };
        topic.count(store, message.log_time, stamp_ns)?;
    }
    if topics.is_empty() {
        return Err(Problem::Nothing);
    }
    let all: Vec<String> = topics.keys().cloned().collect();
    let mut notes = Vec::new();
    let mut read = Vec::new();
    for (reader, topic) in topics.into_values() {
        let why_not =
            if let Reader::Not(why) = &reader { format!("; not read: {why}") } else { String::new() };
        if options.columns.is_empty() {
            notes.push(format!("{}{why_not}", topic.in_words(store)?));
        } else if !why_not.is_empty() && is_asked_for(&topic.name) {
            return Err(Problem::Variable {
                name: topic.name,
                why: why_not.trim_start_matches("; ").to_owned(),
            });
        }
        if !topic.fields.is_empty() {
            read.push(topic);
        }
    }
    let names: Vec<String> = read.iter().flat_map(Topic::variables).collect();
    if let Some(missing) = options.columns.iter().find(|renamed| !names.contains(&renamed.column)) {
        let present = if names.is_empty() { all.join(", ") } else { names.join(", ") };
        return Err(Problem::NoVariable { wanted: missing.column.clone(), present });
    }
    let (columns, how) = clock::on_one(read, store, options)?;
    notes.extend(how);
    let variables = columns.into_iter().map(|column| Box::new(column) as Box<dyn Variable>).collect();
    Ok(Found { variables, left_out: Vec::new(), notes })
}

/// Whether a variable is one of a topic, or the topic itself.
fn belongs(variable: &str, topic: &str) -> bool {
    variable.strip_prefix(topic).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// How the messages of a channel are read, and their type.
fn reader(channel: &mcap::Channel) -> (Reader, String) {
    let Some(schema) = &channel.schema else {
        let reader = if channel.message_encoding == "json" {
            Reader::Json
        } else {
            Reader::Not(format!("{} without a schema", channel.message_encoding))
        };
        return (reader, channel.message_encoding.clone());
    };
    let reader = match (channel.message_encoding.as_str(), schema.encoding.as_str()) {
        ("json", _) => Reader::Json,
        ("cdr", "ros2msg") => match Definition::parse(&schema.name, &String::from_utf8_lossy(&schema.data)) {
            Ok(definition) => Reader::Cdr(definition),
            Err(why) => Reader::Not(why),
        },
        (message, schema) => Reader::Not(format!("messages in {message}, described in {schema}")),
    };
    (reader, schema.name.clone())
}

/// Adds what a message holds; answers its stamp, if it has one. Unit: ns.
fn read(reader: &Reader, topic: &mut Topic, store: &mut Store, data: &[u8]) -> Result<Option<i64>, Problem> {
    let mut stamp = [None; 2];
    let message = topic.messages();
    let mut written: io::Result<()> = Ok(());
    let mut add = |path: &str, value: f64| {
        if let Some(part) = STAMP.iter().position(|part| *part == path) {
            stamp[part] = Some(value);
            return;
        }
        let item = (message as i64, value);
        let pushed = match topic.fields.get_mut(path) {
            Some(list) => store.push(list, item),
            None => store.push(topic.fields.entry(path.to_owned()).or_default(), item),
        };
        if written.is_ok() {
            written = pushed;
        }
    };
    let done = match reader {
        Reader::Cdr(definition) => cdr::read(definition, data, &mut add),
        Reader::Json => match serde_json::from_slice(data) {
            Ok(value) => {
                flatten(&value, &mut String::new(), &mut add);
                Ok(())
            }
            Err(error) => Err(error.to_string()),
        },
        Reader::Not(_) => Ok(()),
    };
    written?;
    done.map_err(|why| Problem::Variable {
        name: topic.name.clone(),
        why: format!("message {}: {why}", message + 1),
    })?;
    let [Some(seconds), Some(nanoseconds)] = stamp else { return Ok(None) };
    Ok(Some((seconds * NANOSECONDS) as i64 + nanoseconds as i64))
}

/// The numbers of a message in JSON.
fn flatten(value: &Value, path: &mut String, add: &mut impl FnMut(&str, f64)) {
    let length = path.len();
    let mut inner = |part: &str, separator: char, value: &Value, path: &mut String| {
        if !path.is_empty() {
            path.push(separator);
        }
        path.push_str(part);
        flatten(value, path, add);
        path.truncate(length);
    };
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| inner(name, '.', value, path)),
        Value::Array(values) if values.len() <= ELEMENTS => {
            values
                .iter()
                .enumerate()
                .for_each(|(place, value)| inner(&(place + 1).to_string(), '_', value, path));
        }
        Value::Number(number) => add(path, number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(is_so) => add(path, f64::from(u8::from(*is_so))),
        _ => {}
    }
}
