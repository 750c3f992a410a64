//! Which choices nothing beats.

use super::Point;

/// Of `(cost, error)` pairs, which no other is at least as good as in both and better in one; of equals the first. An error
/// that is none is beaten by every other.
#[must_use]
pub fn front(points: &[(f64, Option<f64>)]) -> Vec<bool> {
    let beats = |a: usize, b: usize| {
        let ((cost_a, error_a), (cost_b, error_b)) = (points[a], points[b]);
        let (error_a, error_b) = (error_a.unwrap_or(f64::INFINITY), error_b.unwrap_or(f64::INFINITY));
        let no_worse = cost_a <= cost_b && error_a <= error_b;
        no_worse && (cost_a < cost_b || error_a < error_b || a < b)
    };
    (0..points.len()).map(|b| points[b].1.is_some() && !(0..points.len()).any(|a| a != b && beats(a, b))).collect()
}

/// Mark the points that nothing beats, by cycles and torque error, and by cycles and tracking error.
pub(super) fn mark(points: &mut [Point]) {
    let by = |error: fn(&Point) -> Option<f64>| -> Vec<bool> {
        front(&points.iter().map(|point| (point.cost.cycles, error(point))).collect::<Vec<_>>())
    };
    let (torque, tracking) = (by(|point| point.torque_of_limit), by(|point| point.tracking));
    for (point, (torque, tracking)) in points.iter_mut().zip(torque.into_iter().zip(tracking)) {
        (point.on_torque_front, point.on_tracking_front) = (torque, tracking);
    }
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn what_is_beaten_in_both_goes_and_of_equals_the_first_stays() {
        let points = [
            (10.0, Some(1.0)),
            (20.0, Some(0.5)),
            (20.0, Some(0.5)),
            (15.0, Some(2.0)),
            (5.0, None),
            (30.0, Some(0.5)),
            (30.0, Some(0.1)),
        ];
        assert_eq!(front(&points), [true, true, false, false, false, false, true]);
    }
}
