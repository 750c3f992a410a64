//! Remarks of a file's reader: unknown names and assumptions.

use super::{CheckRule, Finding, Severity};
use crate::describe::draft::{Draft, RemarkKind};

pub(super) fn findings(draft: &Draft) -> Vec<Finding> {
    let of = draft.remarks.iter().map(|remark| {
        let kind = match remark.kind {
            RemarkKind::Unknown { misspelt: true } => (CheckRule::UnknownName, Severity::Wrong),
            RemarkKind::Unknown { misspelt: false } => (CheckRule::UnknownName, Severity::Doubt),
            RemarkKind::Held => (CheckRule::HeldJoint, Severity::Doubt),
            RemarkKind::Gap | RemarkKind::Base | RemarkKind::Open => (CheckRule::OpenQuestion, Severity::Note),
        };
        Finding::new(draft, kind, &remark.place, remark.problem.clone(), remark.advice.clone())
    });
    of.collect()
}
