//! Requests that arrive between two ticks: ranks, numbers and verdicts.

use dynamics_core::safety::{Refusal, Request};
use link::{Answer, Denial, NumberedRequest, Verdict};

/// Number of requests that are remembered with their verdicts.
pub(super) const REMEMBERED: usize = 8;

/// A request and its verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    request: NumberedRequest,
    /// `None` while the request waits for its tick.
    verdict: Option<Verdict>,
    /// True if the verdict is still to be sent.
    unsent: bool,
}

/// The request that waits for the next tick, and the last ones with their verdicts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requests {
    ring: [Option<Entry>; REMEMBERED],
    /// Index of the next entry.
    next: usize,
    /// Index of the request that waits.
    waiting: Option<usize>,
    /// True if an entry may be unsent.
    unsent: bool,
}

/// Reaction to a received request.
pub(super) enum Arrived {
    /// Send this answer.
    Answered(Answer),
    /// Nothing to do yet: the request is waiting already.
    Waits,
    /// The request has the highest rank so far and waits for the next tick.
    New,
}

const fn rank(request: NumberedRequest) -> u8 {
    match request.request.to_core() {
        Some(request) => request.rank(),
        None => 0,
    }
}

impl Requests {
    pub(super) const NONE: Self = Self { ring: [None; REMEMBERED], next: 0, waiting: None, unsent: false };

    /// Takes a request. If its number and kind equal one of the last eight, it is a repetition. Of several requests for one tick the one of
    /// highest rank wins, and the first among equals.
    pub(super) fn take(&mut self, request: NumberedRequest) -> Arrived {
        if let Some(answer) = self.known(request) {
            return answer;
        }
        let before = self.waiting.and_then(|place| self.ring.get_mut(place)).and_then(Option::as_mut);
        match before {
            Some(before) if rank(before.request) >= rank(request) => {
                self.remember(request, Some(Verdict::Superseded));
                Arrived::Answered(Answer { number: request.number, verdict: Verdict::Superseded })
            }
            before => {
                if let Some(before) = before {
                    (before.verdict, before.unsent, self.unsent) = (Some(Verdict::Superseded), true, true);
                }
                self.waiting = Some(self.remember(request, None));
                Arrived::New
            }
        }
    }

    /// Takes a request that is decided at once.
    pub(super) fn judge(&mut self, request: NumberedRequest, verdict: impl FnOnce() -> Verdict) -> Arrived {
        self.known(request).unwrap_or_else(|| {
            let verdict = verdict();
            self.remember(request, Some(verdict));
            Arrived::Answered(Answer { number: request.number, verdict })
        })
    }

    /// Returns the answer to a request that has been received before.
    fn known(&mut self, request: NumberedRequest) -> Option<Arrived> {
        let entry = self.ring.iter_mut().flatten().find(|entry| entry.request == request)?;
        Some(match entry.verdict {
            Some(verdict) => {
                entry.unsent = false;
                Arrived::Answered(Answer { number: request.number, verdict })
            }
            None => Arrived::Waits,
        })
    }

    /// Overwrites the oldest entry that neither waits nor is still to be answered; returns its index.
    fn remember(&mut self, request: NumberedRequest, verdict: Option<Verdict>) -> usize {
        // The oldest answered entry; if there is none, the oldest that does not wait.
        let waits = |place: usize| self.waiting == Some(place);
        let unsent = |place: usize| matches!(self.ring.get(place), Some(Some(entry)) if entry.unsent);
        let places = || (0..REMEMBERED).map(|offset| (self.next + offset) % REMEMBERED);
        let free = places().find(|&place| !waits(place) && !unsent(place));
        self.next = free.or_else(|| places().find(|&place| !waits(place))).unwrap_or(self.next);
        let place = self.next;
        if let Some(entry) = self.ring.get_mut(place) {
            *entry = Some(Entry { request, verdict, unsent: false });
        }
        self.next = (place + 1) % REMEMBERED;
        place
    }

    /// True if a request waits for its verdict.
    #[inline]
    pub(super) fn is_waiting(&self) -> bool {
        self.waiting.is_some()
    }

    /// Stores the tick's verdict on the request that waited, to be sent later. Returns that request.
    #[cold]
    pub(super) fn settle(&mut self, refused: Option<Refusal>) -> Option<link::Request> {
        let place = self.waiting.take()?;
        let entry = self.ring.get_mut(place)?.as_mut()?;
        let verdict = refused.map_or(Verdict::Accepted, |refusal| Verdict::Rejected(Denial::new(refusal)));
        (entry.verdict, entry.unsent, self.unsent) = (Some(verdict), true, true);
        Some(entry.request.request)
    }

    /// True if the waiting request must not be decided in the same tick as a waiting change: all but stop, hold and disarm.
    #[cold]
    pub(super) fn yields(&self) -> bool {
        let entry = self.waiting.and_then(|place| self.ring.get(place)).and_then(Option::as_ref);
        entry.is_some_and(|entry| rank(entry.request) < Request::Disarm.rank())
    }

    /// Returns the next answer to be sent, the oldest first.
    pub(super) fn say(&mut self) -> Option<Answer> {
        if !self.unsent {
            return None;
        }
        for offset in 0..REMEMBERED {
            let place = (self.next + offset) % REMEMBERED;
            if let Some(Some(entry)) = self.ring.get_mut(place)
                && entry.unsent
                && let Some(verdict) = entry.verdict
            {
                entry.unsent = false;
                return Some(Answer { number: entry.request.number, verdict });
            }
        }
        self.unsent = false;
        None
    }
}
