//! What a tick of the controller costs on the board with a model: the most instructions, as `cargo xtask gates` measures
//! them.
//!
//! They are read from the project's `gates.toml`, where they stand with their bounds, a few per cent on either side; the
//! middle of these is shown. A model that the gates do not drive has none.

const GATES: &str = include_str!("../../../../gates.toml");

/// The instructions of a tick with the model of that name, `mgpi 10/10`; None where they have not been measured.
pub fn of_tick(model: &str) -> Option<u64> {
    let gates: toml::Table = GATES.parse().ok()?;
    let bound = gates.get("figures")?.get(format!("controller with {model}, most instructions"))?;
    let [lower, upper] = ["lower", "upper"].map(|name| bound.get(name)?.as_integer());
    u64::try_from((lower? + upper?) / 2).ok()
}

#[cfg(test)]
mod tests {
    use super::of_tick;

    #[test]
    fn the_tick_of_every_model_of_the_family_has_been_measured() {
        for model in ["cpi 10", "sgpi 10", "agpi 10", "mpi 10/10", "egpi 10", "mgpi 10/10", "mgpi-pl 10/10"] {
            let instructions = of_tick(model).unwrap_or_else(|| panic!("{model} is not in gates.toml"));
            assert!((100..168_000).contains(&instructions), "{model}: {instructions}");
        }
        assert_eq!(of_tick("mgpi 7/3"), None);
    }
}
