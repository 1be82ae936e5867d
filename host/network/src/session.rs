//! How a gateway is on the network.

use std::path::PathBuf;

use zenoh::{Config, Session, Wait};

use crate::NetworkError;

/// Where a gateway is found.
#[derive(Clone, Debug, Default)]
pub struct Access {
    /// Where it listens, as `tcp/127.0.0.1:7447`.
    pub listen: Vec<String>,
    /// To which routers or programs it goes by itself, and again if they were away.
    pub connect: Vec<String>,
    /// A file of Zenoh's own configuration: certificates, passwords, who may read and write what.
    pub file: Option<PathBuf>,
}

impl Access {
    /// Opens a session. Nothing is looked for by multicast: a gateway is where it was put.
    ///
    /// # Errors
    /// The file is of no use, or an end point is.
    pub fn open(&self) -> Result<Session, NetworkError> {
        let mut config = match &self.file {
            Some(file) => Config::from_file(file)
                .map_err(|problem| NetworkError::File { file: file.clone(), problem: problem.to_string() })?,
            None => Config::default(),
        };
        let mut set = |key: &str, value: String| {
            config
                .insert_json5(key, &value)
                .map_err(|problem| NetworkError::Access { words: format!("{key} = {value}: {problem}") })
        };
        let list = |ends: &[String]| serde_json::Value::from(ends).to_string();
        if self.file.is_none() {
            set("scouting/multicast/enabled", "false".to_owned())?;
        }
        // Without a file also if it is empty: Zenoh's own default is every address.
        if self.file.is_none() || !self.listen.is_empty() {
            set("listen/endpoints", list(&self.listen))?;
        }
        if !self.connect.is_empty() {
            set("connect/endpoints", list(&self.connect))?;
        }
        // What is kept for late joiners is ordered by time.
        set("timestamping/enabled", "true".to_owned())?;
        zenoh::open(config).wait().map_err(|problem| NetworkError::Access { words: problem.to_string() })
    }
}
