//! What the controller costs on the board with a model: the most instructions in a tick, as `cargo
//! xtask gates --bless` measures them. A model that it does not drive has none.

const MEASURED: &str = include_str!("../../instructions.toml");

/// The instructions of a tick with the model of that name, `mgpi 10/10`; None where they have not
/// been measured.
pub fn of_tick(model: &str) -> Option<u64> {
    let measured: toml::Table = MEASURED.parse().ok()?;
    u64::try_from(measured.get(model)?.as_integer()?).ok()
}

#[cfg(test)]
mod tests {
    use super::of_tick;

    #[test]
    fn the_tick_of_every_model_of_the_family_has_been_measured() {
        for model in ["cpi 10", "sgpi 10", "agpi 10", "mpi 10/10", "egpi 10", "mgpi 10/10", "mgpi-pl 10/10"] {
            let instructions = of_tick(model).unwrap_or_else(|| panic!("{model} has not been measured"));
            assert!((100..168_000).contains(&instructions), "{model}: {instructions}");
        }
        assert_eq!(of_tick("mgpi 7/3"), None);
    }
}
