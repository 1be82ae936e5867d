//! The keys under which boards are found, and the version of what stands there.

use gateway::boards::Board;

use crate::NetworkError;

/// The version of keys and payloads. What is added to a payload leaves it; what is changed or
/// removed raises it.
pub const VERSION: &str = "mgpi/1";

/// The keys of a gateway.
#[derive(Clone, Debug)]
pub struct Keys {
    root: String,
    boards: Vec<String>,
}

impl Keys {
    /// Of a gateway with these boards.
    ///
    /// # Errors
    /// A name cannot be part of a key.
    pub fn of(gateway: &str, boards: &[Board]) -> Result<Self, NetworkError> {
        let root = format!("{VERSION}/{}", part(gateway)?);
        let board = |board: &Board| Ok(format!("{root}/{}/{}", part(&board.line)?, board.number));
        let boards = boards.iter().map(board).collect::<Result<_, NetworkError>>()?;
        Ok(Self { root, boards })
    }

    /// What all boards have in common: a put there is for all of them.
    pub fn of_all(&self, what: &str) -> String {
        format!("{}/{what}", self.root)
    }

    /// The same key of any board.
    pub fn of_any(&self, what: &str) -> String {
        format!("{}/*/*/{what}", self.root)
    }

    /// A key of the board at this place among all.
    pub fn of_board(&self, index: usize, what: &str) -> String {
        self.boards.get(index).map_or_else(|| self.of_all(what), |board| format!("{board}/{what}"))
    }

    /// The place of the board that has this key; none if it is a pattern, or nobody's.
    pub fn index(&self, key: &str, what: &str) -> Option<usize> {
        let board = key.strip_suffix(what)?.strip_suffix('/')?;
        self.boards.iter().position(|own| own == board)
    }

    /// The places of the boards.
    pub fn indices(&self) -> std::ops::Range<usize> {
        0..self.boards.len()
    }
}

/// A name as a part of a key.
fn part(name: &str) -> Result<&str, NetworkError> {
    let is_forbidden = |letter: char| "/*$#?".contains(letter) || letter.is_whitespace();
    if name.is_empty() || name.starts_with('@') || name.contains(is_forbidden) {
        return Err(NetworkError::Name { name: name.to_owned() });
    }
    Ok(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_would_be_a_pattern_or_two_parts_is_refused() {
        for name in ["", "a/b", "*", "a*", "$x", "a#", "a?", "a b", "@ros2_lv"] {
            assert!(Keys::of(name, &[]).is_err(), "{name}");
        }
        let keys = Keys::of("lab", &[]).expect("a name");
        assert_eq!(keys.of_all("stop"), "mgpi/1/lab/stop");
        assert_eq!(keys.of_any("setpoint"), "mgpi/1/lab/*/*/setpoint");
    }

    #[test]
    fn a_key_is_that_of_one_board() {
        let keys = Keys { root: String::new(), boards: vec!["mgpi/1/lab/arm/1".to_owned()] };
        assert_eq!(keys.index("mgpi/1/lab/arm/1/setpoint", "setpoint"), Some(0));
        for other in
            ["mgpi/1/lab/arm/2/setpoint", "mgpi/1/lab/*/1/setpoint", "mgpi/1/lab/arm/1/order", "setpoint"]
        {
            assert_eq!(keys.index(other, "setpoint"), None, "{other}");
        }
    }
}
