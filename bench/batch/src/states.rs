//! Memory layout of the states: one list per joint and quantity.
//!
//! ```text
//! q[0]:   joint 1 of state 0, of state 1, of state 2, ..
//! q[1]:   joint 2 of state 0, of state 1, of state 2, ..
//! ```
//!
//! This is a structure of arrays: the same quantity of consecutive states is contiguous, so that a vector register can load it.

use thiserror::Error;

/// Error: a list has another length than the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{list}[{joint}] holds {found} numbers; expected {expected}, one for each state, as in q[0]")]
pub struct LengthError {
    /// Name of the list: `q`, `qd`, `qdd` or `tau`.
    pub list: &'static str,
    /// The joint, counted from 0.
    pub joint: usize,
    /// Number of states.
    pub expected: usize,
    /// Length of the list.
    pub found: usize,
}

/// Positions, velocities and desired accelerations of many states of an arm with `N` joints.
///
/// | list | quantity | unit |
/// |---|---|---|
/// | `q[joint][state]` | position | rad, m |
/// | `qd[joint][state]` | velocity | rad/s, m/s |
/// | `qdd[joint][state]` | acceleration | rad/s^2, m/s^2 |
#[derive(Clone, Copy, Debug)]
pub struct States<'a, F, const N: usize> {
    pub(crate) q: [&'a [F]; N],
    pub(crate) qd: [&'a [F]; N],
    pub(crate) qdd: [&'a [F]; N],
}

impl<'a, F, const N: usize> States<'a, F, N> {
    /// Creates states from lists, which must all be as long as the first.
    ///
    /// # Errors
    /// [`LengthError`] names the first list with another length.
    pub fn new(q: [&'a [F]; N], qd: [&'a [F]; N], qdd: [&'a [F]; N]) -> Result<Self, LengthError> {
        let states = Self { q, qd, qdd };
        for (list, all) in [("q", &q), ("qd", &qd), ("qdd", &qdd)] {
            check(list, all.each_ref().map(|one| one.len()), states.len())?;
        }
        Ok(states)
    }

    /// Returns the number of states.
    #[must_use]
    pub fn len(&self) -> usize {
        self.q.first().map_or(0, |list| list.len())
    }

    /// True if there is no state at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The first `at` states, and the others.
    pub(crate) fn split(&self, at: usize) -> (Self, Self) {
        let part = |lists: &[&'a [F]; N]| (lists.map(|list| &list[..at]), lists.map(|list| &list[at..]));
        let ((q, q_rest), (qd, qd_rest), (qdd, qdd_rest)) = (part(&self.q), part(&self.qd), part(&self.qdd));
        (Self { q, qd, qdd }, Self { q: q_rest, qd: qd_rest, qdd: qdd_rest })
    }
}

/// Checks that every list has the expected length.
pub(crate) fn check<const N: usize>(list: &'static str, found: [usize; N], expected: usize) -> Result<(), LengthError> {
    match found.into_iter().enumerate().find(|(_, found)| *found != expected) {
        Some((joint, found)) => Err(LengthError { list, joint, expected, found }),
        None => Ok(()),
    }
}
