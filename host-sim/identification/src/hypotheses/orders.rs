//! Possible orders of the columns of a log.

/// Exchanges of two joints, the reversed order, and columns shifted by one.
pub(super) fn usual_orders(n: usize) -> Vec<Vec<usize>> {
    let own: Vec<usize> = (0..n).collect();
    let mut found: Vec<Vec<usize>> = Vec::new();
    for (a, b) in (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))) {
        let mut order = own.clone();
        order.swap(a, b);
        found.push(order);
    }
    found.push(own.iter().rev().copied().collect());
    found.push((0..n).map(|k| (k + 1) % n.max(1)).collect());
    found.push((0..n).map(|k| (k + n - 1) % n.max(1)).collect());
    // With two or three joints several of these are the same order.
    let mut seen: Vec<Vec<usize>> = vec![own];
    found.retain(|order| {
        let new = !seen.contains(order);
        seen.push(order.clone());
        new
    });
    found
}

/// Every order except the identity.
pub(super) fn all_orders(n: usize) -> Vec<Vec<usize>> {
    let mut orders: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..n {
        orders = orders
            .iter()
            .flat_map(|order| {
                (0..n).filter(|k| !order.contains(k)).map(|k| [order.as_slice(), &[k]].concat()).collect::<Vec<_>>()
            })
            .collect();
    }
    let own: Vec<usize> = (0..n).collect();
    orders.retain(|order| *order != own);
    orders
}
