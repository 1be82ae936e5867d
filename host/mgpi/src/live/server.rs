//! HTTP for one page: as little of it as a browser needs, a thread each connection.
//!
//! What is served is a [`Site`]: the page of one board, or of a fleet.
//!
//! # Limits
//! At most `MOST` connections at once, requests of at most `LONGEST` bytes that come within
//! `LIMIT`; each connection serves one request.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use thiserror::Error;

/// The most connections at once.
const MOST: usize = 16;
/// The longest request. Unit: byte.
const LONGEST: u64 = 8192;
/// How long a request may take to come, and a part of an answer to go.
const LIMIT: Duration = Duration::from_secs(5);
/// A stream without news says so, and finds out whether somebody is still there.
const BEAT: Duration = Duration::from_secs(2);
/// What an order needs, and a page of another origin may not send without being asked first.
const ORDER_HEADER: &str = "x-mgpi-order: 1";

/// Why there is no page.
#[derive(Debug, Error)]
#[error("{address}: the page cannot be served there: {problem}; --http takes another address")]
pub struct LiveError {
    address: SocketAddr,
    problem: io::Error,
}

/// The kind of a page.
pub const HTML: &str = "text/html; charset=utf-8";
/// The kind of a script.
pub const SCRIPT: &str = "text/javascript; charset=utf-8";

/// What is said of an order that there is not.
pub const NO_ORDER: &str = "no order of this page";

/// A page with all that belongs to it.
pub trait Site: Clone + Send + 'static {
    /// What is at a path, its kind first.
    fn get(&self, path: &str) -> Option<(&'static str, String)>;
    /// Passes on what the page asks for by a path.
    ///
    /// # Errors
    /// There is no such order ([`NO_ORDER`]), or why it was not carried out.
    fn order(&self, path: &str) -> Result<(), String>;
    /// What there is to show beyond what was shown, as soon as there is something; none within
    /// `limit` is `None`. A call of its own for each browser, with what that has seen.
    fn events(&self) -> impl FnMut(Duration) -> Option<String>;
}

/// Serves the page until the program ends; answers the address, whose port is a free one if 0 was
/// asked for.
///
/// # Errors
/// The address is taken, or not this machine's.
pub fn serve(address: SocketAddr, site: &impl Site) -> Result<SocketAddr, LiveError> {
    let bound = TcpListener::bind(address).and_then(|listener| Ok((listener.local_addr()?, listener)));
    let (bound, listener) = bound.map_err(|problem| LiveError { address, problem })?;
    let (site, connections) = (site.clone(), Arc::new(()));
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (site, connection) = (site.clone(), connections.clone());
            if Arc::strong_count(&connections) <= MOST + 1 {
                thread::spawn(move || {
                    // A browser that went away is nobody's error.
                    let _ = answer(&stream, &site);
                    drop(connection);
                });
            }
        }
    });
    Ok(bound)
}

/// Reads a request and answers it.
fn answer(stream: &TcpStream, site: &impl Site) -> io::Result<()> {
    stream.set_read_timeout(Some(LIMIT))?;
    stream.set_write_timeout(Some(LIMIT))?;
    let head = BufReader::new(stream.take(LONGEST))
        .lines()
        .take_while(|line| line.as_ref().is_ok_and(|l| !l.is_empty()));
    let head: Vec<String> = head.collect::<io::Result<_>>()?;
    let Some((request, headers)) = head.split_first() else { return Ok(()) };
    let headers: Vec<String> = headers.iter().map(|header| header.to_ascii_lowercase()).collect();
    if !headers.iter().any(|header| is_own_host(header)) {
        return send(stream, "403 Forbidden", "text/plain", "this page has no name but its address");
    }
    let is_order = headers.iter().any(|header| header == ORDER_HEADER);
    match request.split_whitespace().collect::<Vec<_>>()[..] {
        ["GET", "/events", _] => stream_events(stream, site.events()),
        ["GET", path, _] => match site.get(path) {
            Some((kind, content)) => send(stream, "200 OK", kind, &content),
            None => send(stream, "404 Not Found", "text/plain", "there is only the page /"),
        },
        ["POST", path, _] if is_order => match site.order(path) {
            Ok(()) => send(stream, "202 Accepted", "text/plain", "passed on"),
            Err(reason) => send(stream, "403 Forbidden", "text/plain; charset=utf-8", &reason),
        },
        ["POST", ..] => send(stream, "403 Forbidden", "text/plain", NO_ORDER),
        _ => send(stream, "404 Not Found", "text/plain", "there is only the page /"),
    }
}

/// Whether a header (lower case) says that the browser was sent here by an address, not by a name
/// that may be anybody's.
fn is_own_host(header: &str) -> bool {
    header.strip_prefix("host:").is_some_and(|host| {
        let host = host.trim();
        let name = host
            .rsplit_once(':')
            .filter(|(_, port)| port.parse::<u16>().is_ok())
            .map_or(host, |(name, _)| name);
        name == "localhost" || name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok()
    })
}

fn send(mut stream: &TcpStream, status: &str, kind: &str, content: &str) -> io::Result<()> {
    let length = content.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
         Content-Security-Policy: default-src 'none'; script-src 'self'; connect-src 'self'; \
         style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'\r\n\r\n{content}"
    )
}

/// Sends what is new as it comes, until the browser has gone.
fn stream_events(mut stream: &TcpStream, mut news: impl FnMut(Duration) -> Option<String>) -> io::Result<()> {
    stream.write_all(
        b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\nCache-Control: no-store\r\n\r\n",
    )?;
    loop {
        match news(BEAT) {
            Some(news) => write!(stream, "data: {news}\n\n")?,
            None => stream.write_all(b": nothing new\n\n")?,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::feed::{Feed, Order};
    use super::*;

    #[test]
    fn a_host_is_an_address_or_this_machine() {
        for host in ["127.0.0.1:8080", "localhost", "localhost:80", "[::1]:8080", "192.168.0.7"] {
            assert!(is_own_host(&format!("host: {host}")), "{host}");
        }
        for host in ["evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil", ""] {
            assert!(!is_own_host(&format!("host: {host}")), "{host}");
        }
    }

    /// The first line that is answered to a request.
    fn asked(address: SocketAddr, request: &str) -> String {
        let mut stream = TcpStream::connect(address).expect("connected");
        stream.write_all(request.as_bytes()).expect("written");
        let mut line = String::new();
        BufReader::new(stream).read_line(&mut line).expect("answered");
        line
    }

    #[test]
    fn orders_come_from_the_page_alone() {
        let feed = Feed::default();
        let address = serve(SocketAddr::from(([127, 0, 0, 1], 0)), &feed).expect("served");
        let host = format!("Host: {address}\r\n");
        for (request, expected) in [
            (format!("GET / HTTP/1.1\r\n{host}\r\n"), "200"),
            (format!("GET /live.js HTTP/1.1\r\n{host}\r\n"), "200"),
            (format!("GET /plot.js HTTP/1.1\r\n{host}\r\n"), "200"),
            (format!("GET /etc/passwd HTTP/1.1\r\n{host}\r\n"), "404"),
            ("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n".to_owned(), "403"),
            (format!("POST /stop HTTP/1.1\r\n{host}\r\n"), "403"),
            (format!("POST /stop HTTP/1.1\r\n{host}X-Mgpi-Order: 1\r\n\r\n"), "202"),
        ] {
            assert!(asked(address, &request).contains(expected), "{request}");
        }
        assert_eq!(feed.orders(), [Order::Stop]);
        let taken = serve(address, &feed).expect_err("taken").to_string();
        assert!(taken.contains("--http takes another address"), "{taken}");
    }
}
