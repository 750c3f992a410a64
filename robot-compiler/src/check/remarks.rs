//! Remarks of a file's reader: names that it does not know, and what it had to assume.

use super::{Finding, Rule, Severity};
use crate::describe::draft::{Draft, RemarkKind};

pub(super) fn findings(draft: &Draft) -> Vec<Finding> {
    let of = draft.remarks.iter().map(|remark| {
        let kind = match remark.kind {
            RemarkKind::Unknown { misspelt: true } => (Rule::UnknownName, Severity::Wrong),
            RemarkKind::Unknown { misspelt: false } => (Rule::UnknownName, Severity::Doubt),
            RemarkKind::Held => (Rule::HeldJoint, Severity::Doubt),
            RemarkKind::Gap | RemarkKind::Base | RemarkKind::Open => (Rule::OpenQuestion, Severity::Note),
        };
        Finding::new(draft, kind, &remark.place, remark.problem.clone(), remark.advice.clone())
    });
    of.collect()
}
