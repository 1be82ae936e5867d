//! Which way an input goes.

/// What turns back by less than this share of the input's span is noise.
const LEAST_HEIGHT: f64 = 0.02;

/// Whether the input rises at each row: from a turning point on, seen afterwards, so that noise does not count.
pub fn rising(input: &[f64]) -> Vec<bool> {
    let (low, high) =
        input.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    let height = LEAST_HEIGHT * (high - low);
    let mut rising = Vec::with_capacity(input.len());
    // The way before the first turning point is known only there.
    let (mut is_rising, mut turn) =
        (first_way(input, height), (0, input.first().copied().unwrap_or_default()));
    for (row, &x) in input.iter().enumerate() {
        let way = if is_rising { x - turn.1 } else { turn.1 - x };
        if way >= 0.0 {
            turn = (row, x);
        } else if way < -height {
            is_rising = !is_rising;
            rising.truncate(turn.0 + 1);
            rising.resize(row, is_rising);
            turn = (row, x);
        }
        rising.push(is_rising);
    }
    rising
}

/// Whether the input first rises by a height, rather than falls.
fn first_way(input: &[f64], height: f64) -> bool {
    let start = input.first().copied().unwrap_or_default();
    input.iter().find(|&&x| (x - start).abs() > height).is_none_or(|&x| x > start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turning_point_ends_a_way_and_noise_does_not() {
        let input = [0.0, 1.0, 0.99, 2.0, 5.0, 4.0, 4.01, 3.0, 6.0];
        assert_eq!(rising(&input), [true, true, true, true, true, false, false, false, true]);
    }

    #[test]
    fn a_way_may_begin_by_falling_and_an_input_may_be_empty() {
        assert_eq!(rising(&[3.0, 3.0, 1.0]), [false; 3]);
        assert_eq!(rising(&[]), [] as [bool; 0]);
    }
}
