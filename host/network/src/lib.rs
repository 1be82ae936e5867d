//! The boards of a gateway on Zenoh, for every program on every computer.
//!
//! # Design
//! | file | what it is |
//! |---|---|
//! | `keys` | the keys under which boards are found |
//! | `session` | how a gateway is on the network |
//! | `publish` | telemetry, states and liveliness |
//! | `orders` | starts, stops, trajectories and set points that come in |
//! | `ros` | the same for ROS 2, as its middleware `rmw_zenoh` sees it |
//! | `lib` | all of them together |
//!
//! # Timing contract
//! Telemetry goes out as soon as a line has it, in the order in which it came, each with the time
//! at which it was measured and the bound of that; a subscriber that is too slow holds up the
//! publishing, not the lines, and what is then lost after ten seconds is counted.
//!
//! # Safety
//! See the contract of [`gateway`]: nothing here sends a sign of life. Who may write is decided by
//! Zenoh's access control; without a configuration a gateway is reached from its own machine alone.

pub mod keys;
pub mod orders;
pub mod publish;
pub mod ros;
pub mod session;

use std::path::PathBuf;
use std::sync::Arc;

use gateway::Gateway;
use gateway::lines::NO_NAME;
use thiserror::Error;
use zenoh::{Session, Wait};

use crate::keys::Keys;
use crate::session::Access;

/// Why a gateway is not on the network.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum NetworkError {
    #[error("the name \"{name}\": {NO_NAME}")]
    Name { name: String },
    #[error("{}: {problem}", file.display())]
    File { file: PathBuf, problem: String },
    #[error("Zenoh: {words}")]
    Access { words: String },
}

impl NetworkError {
    fn of(problem: &zenoh::Error) -> Self {
        Self::Access { words: problem.to_string() }
    }
}

/// Reads the gateway's file again; why it is of no use, if so.
pub type Reload = Arc<dyn Fn() -> Result<(), String> + Send + Sync>;

/// What a gateway is on the network.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Its name, the first part of all keys, and the namespace in ROS 2.
    pub name: String,
    /// Where it is found.
    pub access: Access,
    /// The domain of ROS 2 in which it has its topics, if it shall have any.
    pub ros_domain: Option<u32>,
}

/// A gateway on the network, until it is dropped.
#[derive(Debug)]
pub struct Network {
    session: Session,
    _publisher: publish::Publisher,
    _orders: orders::Orders,
    _ros: Option<ros::Face>,
}

impl Network {
    /// Brings a gateway on the network; `reload` reads its file again.
    ///
    /// # Errors
    /// The name is no name, or the session cannot be opened.
    pub fn start(gateway: &Arc<Gateway>, reload: &Reload, settings: &Settings) -> Result<Self, NetworkError> {
        let keys = Keys::of(&settings.name, &gateway.boards().all())?;
        let session = settings.access.open()?;
        let (orders, refusals) = orders::Orders::start(&session, gateway, reload, &keys)?;
        let publisher = publish::Publisher::start(&session, gateway.boards(), &keys, refusals)?;
        let face = |domain| ros::Face::start(&session, gateway, &settings.name, domain);
        let ros = settings.ros_domain.map(face).transpose()?;
        Ok(Self { session, _publisher: publisher, _orders: orders, _ros: ros })
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        // It ends in any case; the threads see that their queues are closed.
        let _ = self.session.close().wait();
    }
}
