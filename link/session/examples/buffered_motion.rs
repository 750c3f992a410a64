//! The board's buffer of a reference motion: three points from a host become a reference for every tick.
//!
//! ```console
//! $ cargo run -p newtau-session --example buffered_motion
//! ```

use dynamics_core::Reference;
use newtau_session::trajectory::{FinitePoint, NotTaken, Trajectory, WAYS};

/// Control period, s.
const PERIOD: f32 = 1e-3;

/// Ticks from point to point.
const TICKS: u16 = 250;

fn main() {
    let mut buffer = Trajectory::<2>::new();
    // The caller holds the reference of the current tick, and the buffer updates it.
    let mut reference = None;

    // One quintic from rest to rest, 1 rad and -0.5 rad in 0.5 s. Its middle is sent as a point too.
    let start = Reference::at_rest([0.0, 0.0]);
    let middle = Reference { q: [0.5, -0.25], qd: [3.75, -1.875], qdd: [0.0, 0.0] };
    let end = Reference::at_rest([1.0, -0.5]);

    // A point without a start before it is rejected.
    assert_eq!(buffer.push(TICKS, PERIOD, &middle), Err(NotTaken::NoStart));
    let Ok(start) = FinitePoint::new(start) else { return };
    buffer.start(&start, &mut reference);
    for point in [&middle, &end] {
        assert_eq!(buffer.push(TICKS, PERIOD, point), Ok(()));
    }
    println!("{} of {WAYS} segments are free", buffer.room());

    println!("tick  q (rad)             qd (rad/s)          qdd (rad/s^2)");
    let last = 2 * TICKS;
    for tick in 0..=last {
        let now = reference.unwrap_or(end);
        if tick % 100 == 0 || tick == TICKS {
            println!("{tick:4}  {:7.4?}  {:7.4?}  {:8.3?}", now.q, now.qd, now.qdd);
        }
        // Each tick's reference is the quintic's, up to rounding.
        let s = f32::from(tick) / f32::from(last);
        let q = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        assert!((now.q[0] - q).abs() < 1e-6 && (now.q[1] + 0.5 * q).abs() < 1e-6, "tick {tick}: {now:?}");
        // In the tick of a point it is the point, to the last bit.
        assert!(tick != TICKS || now == middle);
        buffer.advance(&mut reference);
    }

    // The motion ended at rest, so the reference stays there.
    assert_eq!(reference, Some(end));
    println!("at rest at {:?} rad", end.q);
}
