//! Boards on a page of this machine's browser. One board: its loop and traces as they come, its
//! faults, and a stop. Many: what each was last seen to do.
//!
//! | file | what it does |
//! |---|---|
//! | [`feed`] | what is shown, handed from the board's thread to the page's, and orders the other way |
//! | [`server`] | HTTP: a page, its script, a stream of events, orders |
//! | [`page`], `board` | the page of one board, and how it is served |
//! | [`fleet`] | the page of many boards, and their figures for Prometheus |
//!
//! # Contract
//! The page loads nothing from outside, and is served to this machine alone unless another address
//! is asked for. A page of another origin can neither read the stream nor give an order: requests
//! need a host that is an address or `localhost`, so that no name can be bent to it, and orders a
//! header that a foreign page may not send.

mod board;
pub mod feed;
pub mod fleet;
pub mod page;
pub mod server;

pub use feed::{Feed, Order, Row};
pub use server::{LiveError, serve};
