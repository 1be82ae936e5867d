//! The messages of ROS 2 that a gateway speaks.
//!
//! # Design
//! | file | what it is |
//! |---|---|
//! | `messages` | the messages, field by field as ROS 2 defines them |
//! | `types` | their names, hashes and definitions, as ROS 2 publishes them |
//! | `bytes` | a message as bytes and back (CDR, as in bags and on the network) |
//!
//! # Limits
//! Written against the published definitions (common_interfaces, release Jazzy; the same in Humble
//! to Kilted) and checked by independent decoders. No ROS 2 was there to try it with.

pub mod bytes;
pub mod messages;
pub mod types;
