//! The keys under which boards are found, and the version of what stands there.

use std::sync::{Arc, PoisonError, RwLock};

use gateway::boards::Board;
use gateway::lines::is_name;

use crate::NetworkError;

/// The version of keys and payloads. What is added to a payload leaves it; what is changed or
/// removed raises it.
pub const VERSION: &str = "mgpi/1";

/// The keys of a gateway; what is cloned of it stays the same.
#[derive(Clone, Debug)]
pub struct Keys {
    root: String,
    /// Of each board at its place among all; none of one that is gone.
    boards: Arc<RwLock<Vec<Option<String>>>>,
}

impl Keys {
    /// Of a gateway with these boards.
    ///
    /// # Errors
    /// The gateway's name cannot be part of a key. Those of lines can.
    pub fn of(gateway: &str, boards: &[Board]) -> Result<Self, NetworkError> {
        if !is_name(gateway) {
            return Err(NetworkError::Name { name: gateway.to_owned() });
        }
        let keys = Self { root: format!("{VERSION}/{gateway}"), boards: Arc::default() };
        keys.arrange(boards);
        Ok(keys)
    }

    /// The boards are these from now on.
    pub fn arrange(&self, boards: &[Board]) {
        let root = &self.root;
        let key = |board: &Board| (!board.is_gone).then(|| format!("{root}/{}/{}", board.line, board.number));
        // What a thread that panicked left is whole.
        *self.boards.write().unwrap_or_else(PoisonError::into_inner) = boards.iter().map(key).collect();
    }

    /// What all boards have in common: a put there is for all of them.
    pub fn of_all(&self, what: &str) -> String {
        format!("{}/{what}", self.root)
    }

    /// All keys of a gateway of this name in any version.
    pub fn of_any_version(&self) -> String {
        // Its name has no slash.
        let name = self.root.rsplit('/').next().unwrap_or_default();
        format!("mgpi/*/{name}/**")
    }

    /// The same key of any board.
    pub fn of_any(&self, what: &str) -> String {
        format!("{}/*/*/{what}", self.root)
    }

    /// The same key of any group.
    pub fn of_any_group(&self, what: &str) -> String {
        format!("{}/*/{what}", self.root)
    }

    /// A key of a group.
    pub fn of_group(&self, group: &str, what: &str) -> String {
        format!("{}/{group}/{what}", self.root)
    }

    /// The group that has this key; none if it is a pattern.
    pub fn group<'a>(&self, key: &'a str, what: &str) -> Option<&'a str> {
        let group = key.strip_prefix(&self.root)?.strip_prefix('/')?.strip_suffix(what)?.strip_suffix('/')?;
        is_name(group).then_some(group)
    }

    /// A key of the board at this place among all; none of one that is gone.
    pub fn of_board(&self, index: usize, what: &str) -> Option<String> {
        Some(format!("{}/{what}", self.boards().get(index)?.as_ref()?))
    }

    /// The place of the board that has this key; none if it is a pattern, or nobody's.
    pub fn index(&self, key: &str, what: &str) -> Option<usize> {
        let board = key.strip_suffix(what)?.strip_suffix('/')?;
        self.boards().iter().position(|own| own.as_deref() == Some(board))
    }

    /// The places of the boards, with this key of each.
    pub fn all(&self, what: &str) -> Vec<(usize, String)> {
        let boards = self.boards();
        let key =
            |(index, board): (usize, &Option<String>)| Some((index, format!("{}/{what}", board.as_ref()?)));
        boards.iter().enumerate().filter_map(key).collect()
    }

    fn boards(&self) -> std::sync::RwLockReadGuard<'_, Vec<Option<String>>> {
        self.boards.read().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_would_be_a_pattern_or_two_parts_is_refused() {
        assert!(Keys::of("a/b", &[]).is_err());
        let keys = Keys::of("lab", &[]).expect("a name");
        assert_eq!(keys.of_all("stop"), "mgpi/1/lab/stop");
        assert_eq!(keys.of_any("setpoint"), "mgpi/1/lab/*/*/setpoint");
    }

    #[test]
    fn a_key_is_that_of_one_board() {
        let boards = Arc::new(RwLock::new(vec![None, Some("mgpi/1/lab/arm/1".to_owned())]));
        let keys = Keys { root: "mgpi/1/lab".to_owned(), boards };
        assert_eq!(keys.index("mgpi/1/lab/arm/1/setpoint", "setpoint"), Some(1));
        for other in
            ["mgpi/1/lab/arm/2/setpoint", "mgpi/1/lab/*/1/setpoint", "mgpi/1/lab/arm/1/order", "setpoint"]
        {
            assert_eq!(keys.index(other, "setpoint"), None, "{other}");
        }
        assert_eq!(keys.group("mgpi/1/lab/left/setpoint", "setpoint"), Some("left"));
        assert_eq!(keys.group(&keys.of_group("left", "order"), "order"), Some("left"));
        for other in ["mgpi/1/lab/arm/1/setpoint", "mgpi/1/lab/*/setpoint", "mgpi/1/lab/setpoint"] {
            assert_eq!(keys.group(other, "setpoint"), None, "{other}");
        }
    }
}
