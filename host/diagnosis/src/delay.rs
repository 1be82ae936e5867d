//! A signal later.

/// The values later by `delay_s`, straight between rows.
pub fn delayed(values: &[f64], time_s: &[f64], delay_s: f64) -> Vec<f64> {
    delayed_at(values, time_s, time_s, delay_s)
}

/// The same at other times, which rise.
pub fn delayed_at(values: &[f64], time_s: &[f64], at_s: &[f64], delay_s: f64) -> Vec<f64> {
    let mut right = 0;
    at_s.iter()
        .map(|time| {
            let wanted = time - delay_s;
            while right < time_s.len() && time_s[right] < wanted {
                right += 1;
            }
            match (right.checked_sub(1), values.get(right)) {
                (Some(left), Some(&after)) => {
                    let share = (wanted - time_s[left]) / (time_s[right] - time_s[left]);
                    values[left] + (after - values[left]) * share
                }
                (None, Some(&first)) => first,
                (_, None) => values.last().copied().unwrap_or(0.0),
            }
        })
        .collect()
}
