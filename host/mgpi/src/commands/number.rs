//! Numbers on the command line.

/// A number above 0 that a time span can be made of.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1e6 => Ok(number),
        _ => Err("a number above 0, at most 1e6, is needed".to_owned()),
    }
}

/// A share of something, above 0 and below 1.
pub fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number < 1.0 => Ok(number),
        _ => Err("a number above 0 and below 1 is needed".to_owned()),
    }
}
