//! `mgpi gateway`: all boards of all lines on one page.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;

use ::gateway::Gateway;
use ::gateway::lines;
use ::gateway::record::Record;
use board_client::child::WAIT_SLICE;
use board_client::stop::Stop;
use clap::Args;
use network::keys::VERSION;
use network::session::Access;
use network::{Network, Reload, Settings};

use crate::Error;
use crate::live::fleet::FleetSite;
use crate::live::serve;

/// Brings all boards of all lines together until Ctrl-C: on a page with state, fault with cause and
/// cure, contraction, pressure, bus and clock of each and a stop for all; the same figures for
/// Prometheus under /metrics and for programs under /fleet.json; and, where it is asked for, on the
/// network by Zenoh, for ROS 2, and in a recording. By itself it drives nothing: a board is started
/// for a program that then sends it set points, or trajectories and signs of life, and vents where
/// these stop. Page and network are for this machine alone unless they are told otherwise.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Which boards there are: a [[line]] with port, boards = [1, 2] or [{number = 1, name =
    /// "biceps"}], and, where they are not the usual ones, name, rate_bit_per_s, parity, answer_s,
    /// travel_mm = [0, 40], slew_mm_per_s (these two of a board too); and groups, each an entry of
    /// the list group with name and boards = ["biceps"]. Read again, without a stop, by an order to
    /// /reload
    #[arg(value_name = "LINES.toml")]
    lines: PathBuf,
    /// Where the page is served
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
    http: SocketAddr,
    /// The gateway's name on the network: the first part of its keys, its namespace in ROS 2
    #[arg(long, default_value = "lab", value_name = "NAME")]
    name: String,
    /// Be on the network by Zenoh and listen there, as tcp/127.0.0.1:7447
    #[arg(long, value_name = "END_POINT")]
    zenoh: Vec<String>,
    /// Be on the network by Zenoh and go to a router or a program there, again and again
    #[arg(long, value_name = "END_POINT")]
    zenoh_connect: Vec<String>,
    /// Be on the network by Zenoh as this file of its own configuration says: certificates,
    /// passwords, who may read and write what
    #[arg(long, value_name = "FILE.json5")]
    zenoh_config: Option<PathBuf>,
    /// Also have topics and services of ROS 2 there, as its middleware rmw_zenoh has them, in this
    /// domain
    #[arg(long, value_name = "DOMAIN", value_parser = clap::value_parser!(u32).range(0..=232))]
    ros_domain: Option<u32>,
    /// Also record everything that the boards tell, with messages of ROS 2
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
}

impl Arguments {
    /// What the gateway is on the network, if it is there.
    fn network(&self) -> Result<Option<Settings>, Error> {
        let Self { zenoh, zenoh_connect, zenoh_config, ros_domain, name, .. } = self;
        if zenoh.is_empty() && zenoh_connect.is_empty() && zenoh_config.is_none() {
            return match ros_domain {
                Some(_) => Err(Error::Usage(
                    "--ros-domain needs --zenoh, --zenoh-connect or --zenoh-config: ROS 2 is reached by Zenoh"
                        .to_owned(),
                )),
                None => Ok(None),
            };
        }
        let access =
            Access { listen: zenoh.clone(), connect: zenoh_connect.clone(), file: zenoh_config.clone() };
        Ok(Some(Settings { name: name.clone(), access, ros_domain: *ros_domain }))
    }
}

/// Reads the file again. One that is of no use leaves everything as it was.
fn reload(gateway: &Arc<Gateway>, file: PathBuf) -> Reload {
    let gateway = gateway.clone();
    Arc::new(move || match lines::read(&file) {
        Ok(lines) => {
            gateway.arrange(lines);
            Ok(())
        }
        Err(problem) => {
            eprintln!("warning: the lines stay as they were: {problem}");
            Err(problem.to_string())
        }
    })
}

/// Watches, until the user ends it.
///
/// # Errors
/// The file is of no use, the page cannot be served, the network or the recording cannot be had. A
/// port or a board that is not there is shown, and looked for again.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let lines = lines::read(&arguments.lines)?;
    let settings = arguments.network()?;
    let stop = Stop::on_signals();
    let gateway = Arc::new(Gateway::start(lines));
    let reload = reload(&gateway, arguments.lines.clone());
    let network =
        settings.as_ref().map(|settings| Network::start(&gateway, &reload, settings)).transpose()?;
    let record =
        arguments.record.as_deref().map(|file| Record::start(file, gateway.boards(), arguments.force));
    let record = record.transpose()?;
    let address = serve(arguments.http, &FleetSite::new(gateway.clone(), reload))?;
    say!("http://{address}/ shows the boards; Ctrl-C ends");
    if !address.ip().is_loopback() {
        eprintln!("warning: whoever reaches {address} sees the boards, and may stop them");
    }
    if let (Some(settings), Some(_)) = (&settings, &network) {
        let ros =
            settings.ros_domain.map_or_else(String::new, |domain| format!(", in ROS 2's domain {domain}"));
        say!("on Zenoh under {VERSION}/{}{ros}", settings.name);
    }
    while !stop.is_requested() {
        thread::sleep(WAIT_SLICE);
    }
    drop(network);
    if let (Some(record), Some(file)) = (record, &arguments.record) {
        record.finish()?;
        say!("recorded in {}", file.display());
    }
    Ok(())
}
