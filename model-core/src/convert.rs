//! Numbers and lists in another number type or capacity, and numbers from another origin.

use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::real::Real;

/// The nearest number of the other type.
pub(crate) fn number<T: Real, U: Real>(value: T) -> U {
    U::from_f64(value.to_f64())
}

/// The same number where numbers count from an origin on.
pub(crate) fn counted_from<T: Real>(value: T, origin: f64) -> T {
    T::from_f64(value.to_f64() - origin)
}

/// The list, which `parameter` names, in the other type and capacity.
///
/// # Errors
/// The other capacity is too small.
pub(crate) fn list<T: Real, U: Real, const N: usize>(
    parameter: &'static str,
    list: &[T],
) -> Result<List<U, N>, ParameterError> {
    let mut converted = List::new();
    for &value in list {
        let too_many = |_| Check::new(parameter, "").length(list.len(), Requirement::AtMost(N as f64));
        converted.push(number(value)).map_err(too_many)?;
    }
    Ok(converted)
}
