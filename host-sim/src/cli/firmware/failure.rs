//! Failures of a build or of a probe.

use firmware_image::BadInput;
use sim::failure::Failure;

/// The failure of a build or of a probe.
pub(super) fn failure(error: anyhow::Error) -> Failure {
    let report = miette::miette!("{error:#}");
    if error.is::<BadInput>() { Failure::Input(report) } else { Failure::Target(report) }
}
