//! Targets of another program, from its connection to the operator.

use std::time::{Duration, Instant};

/// Answer to targets that nobody wants.
const NOT_FOLLOWING: &str = "the arm follows no targets now: enter `follow` in its session";

/// Targets of one program at a time.
#[derive(Debug, Default)]
pub(super) struct Targets {
    open: Option<OpenTargets>,
    /// Reason why the last targets were not followed further.
    ended: Option<String>,
}

/// Targets while the arm follows them.
#[derive(Debug)]
struct OpenTargets {
    opened: Instant,
    /// The connection that sends them.
    owner: Option<u64>,
    newest: Option<Vec<f64>>,
    received: Option<Instant>,
    over: Option<Over>,
}

/// Reason for the end of the targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// The program has said so.
    Done,
    /// The connection is closed.
    Gone,
}

/// News from another program since the last look.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Received {
    /// The newest target, if one came.
    pub target: Option<Vec<f64>>,
    /// Time since the newest target; `None` before the first.
    pub silent: Option<Duration>,
    /// Time since targets are followed.
    pub waited: Duration,
    /// Set once no more targets come.
    pub over: Option<Over>,
}

impl Targets {
    /// True while the arm follows targets.
    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Follows targets from here on.
    pub(super) fn open(&mut self) {
        let open = OpenTargets { opened: Instant::now(), owner: None, newest: None, received: None, over: None };
        (self.open, self.ended) = (Some(open), None);
    }

    /// Follows no targets any longer, for this reason. The first reason stays.
    pub(super) fn close(&mut self, why: &str) {
        if self.open.take().is_some() {
            self.ended = Some(why.to_owned());
        }
    }

    /// The targets since the last call.
    pub(super) fn received(&mut self) -> Received {
        self.open.as_mut().map_or_else(Received::default, |open| Received {
            target: open.newest.take(),
            silent: open.received.map(|at| at.elapsed()),
            waited: open.opened.elapsed(),
            over: open.over,
        })
    }

    /// Takes a target of this connection. A later target replaces one that was not received yet. The error is the reason why it is not followed.
    pub(super) fn take(&mut self, connection: u64, q: Vec<f64>) -> Result<(), String> {
        let Some(open) = &mut self.open else {
            return Err(self.ended.as_ref().map_or_else(
                || NOT_FOLLOWING.to_owned(),
                |why| format!("the arm no longer follows targets: {why}; enter `follow` in its session"),
            ));
        };
        if *open.owner.get_or_insert(connection) != connection {
            return Err("the arm follows the targets of another program".into());
        }
        if open.over.is_some() {
            return Err("the targets were ended".into());
        }
        (open.newest, open.received) = (Some(q), Some(Instant::now()));
        Ok(())
    }

    /// Ends the targets of this connection.
    pub(super) fn end(&mut self, connection: u64, over: Over) {
        let Some(open) = &mut self.open else { return };
        // Who ends the targets before the first one is their program, too. A connection that only looked is not.
        let is_owner = open.owner == Some(connection) || (open.owner.is_none() && over == Over::Done);
        if is_owner {
            open.owner = Some(connection);
            open.over.get_or_insert(over);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{Over, Targets};
    use std::time::Duration;

    #[test]
    fn the_newest_target_of_one_program_is_taken_once() {
        let mut targets = Targets::default();
        assert!(targets.take(1, vec![0.0]).unwrap_err().contains("enter `follow`"), "not yet");
        targets.open();
        assert_eq!(targets.received().silent, None);
        targets.end(3, Over::Gone);
        assert_eq!(targets.received().over, None, "who only looked ends nothing");
        targets.take(1, vec![0.0]).unwrap();
        targets.take(1, vec![1.0]).unwrap();
        assert!(targets.take(2, vec![9.0]).unwrap_err().contains("another program"));
        targets.end(2, Over::Done);
        let received = targets.received();
        assert_eq!((received.target, received.over), (Some(vec![1.0]), None));
        assert!(received.silent.unwrap() < Duration::from_secs(1));
        assert_eq!(targets.received().target, None);
        targets.end(1, Over::Done);
        targets.end(1, Over::Gone);
        assert_eq!(targets.received().over, Some(Over::Done));
        assert!(targets.take(1, vec![2.0]).is_err(), "what is ended is ended");
        targets.close("a stop");
        targets.close("something later");
        assert!(targets.take(1, vec![2.0]).unwrap_err().contains("a stop"));
        assert!(!targets.is_open());
        targets.open();
        targets.end(4, Over::Done);
        assert_eq!(targets.received().over, Some(Over::Done), "before the first target");
    }
}
