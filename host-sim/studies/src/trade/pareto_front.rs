//! Pareto front: the points that no other point dominates.

use super::TradePoint;

/// True for each `(cost, error)` pair on the Pareto front: no other pair is at least as good in both numbers and better in one. Of equal pairs only
/// the first is on the front. A pair without an error is never on the front.
#[must_use]
pub fn pareto_front(points: &[(f64, Option<f64>)]) -> Vec<bool> {
    let beats = |a: usize, b: usize| {
        let ((cost_a, error_a), (cost_b, error_b)) = (points[a], points[b]);
        let (error_a, error_b) = (error_a.unwrap_or(f64::INFINITY), error_b.unwrap_or(f64::INFINITY));
        let no_worse = cost_a <= cost_b && error_a <= error_b;
        no_worse && (cost_a < cost_b || error_a < error_b || a < b)
    };
    (0..points.len()).map(|b| points[b].1.is_some() && !(0..points.len()).any(|a| a != b && beats(a, b))).collect()
}

/// Marks the Pareto fronts of cycles and torque error, and of cycles and tracking error.
pub(super) fn mark(points: &mut [TradePoint]) {
    let by = |error: fn(&TradePoint) -> Option<f64>| -> Vec<bool> {
        pareto_front(&points.iter().map(|point| (point.cost.cycles, error(point))).collect::<Vec<_>>())
    };
    let (torque, tracking) = (by(|point| point.torque_of_limit), by(|point| point.tracking));
    for (point, (torque, tracking)) in points.iter_mut().zip(torque.into_iter().zip(tracking)) {
        (point.on_torque_front, point.on_tracking_front) = (torque, tracking);
    }
}

#[cfg(test)]
mod tests {
    use super::pareto_front;

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
        assert_eq!(pareto_front(&points), [true, true, false, false, false, false, true]);
    }
}
