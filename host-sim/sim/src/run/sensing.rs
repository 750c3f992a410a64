//! Measurement at the start of a tick, from the sensors of ideal drives or from the replies of simulated ones.

use crate::plant::sensor::{Reading, Sample};
use dynamics_core::{Measurement, Real, Sensed};
use link::DriveFaultReport;
use session::readings::{JointFaults, Readings};

/// Measurement at the start of a tick, and further reports of the drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensing<S, const N: usize> {
    /// Positions and velocities, or counts.
    pub measurement: Measurement<S, N>,
    /// Joints whose drive has a fault.
    pub drive_fault: [bool; N],
    /// Highest temperature that the drives report, degrees Celsius.
    pub temperature: Option<f32>,
    /// Report of the first joint with a fault.
    pub fault_report: Option<DriveFaultReport>,
}

impl<S: Real, const N: usize> Sensing<S, N> {
    /// The reading of the sensors. Ideal drives report nothing.
    pub(crate) fn of_sensors(reading: &Reading<N>) -> Self {
        let measurement = measurement(reading);
        Self { measurement, drive_fault: [false; N], temperature: None, fault_report: None }
    }

    /// The readings of simulated drives, and their highest temperature, degrees Celsius.
    pub(crate) fn of_drives((readings, temperature): (Option<Readings<N>>, Option<f32>)) -> Self {
        // These drives always give readings. If there were none, the measurement would have the greatest age.
        let never = Sensed::State { q: [S::zero(); N], qd: [S::zero(); N] };
        let fault_report = readings.as_ref().and_then(Readings::drive_fault);
        let (sensed, age_ticks, faults) = readings.map_or((never, u32::MAX, [JointFaults::NONE; N]), |readings| {
            let oldest = readings.age_ticks.into_iter().fold(0, u32::max);
            (cast(&readings.sensed), oldest, readings.faults)
        });
        Self {
            measurement: Measurement { sensed, age_ticks },
            drive_fault: faults.map(|faults| faults.intersects(JointFaults::OF_DRIVE)),
            temperature,
            fault_report,
        }
    }
}

/// Converts the sensors' reading to the controller's scalar.
pub fn measurement<S: Real, const N: usize>(reading: &Reading<N>) -> Measurement<S, N> {
    let sensed = match &reading.sample {
        Sample::State(state) => Sensed::State { q: state.q.map(S::literal), qd: state.qd.map(S::literal) },
        Sample::Counts(counts) => Sensed::Counts(*counts),
    };
    Measurement { sensed, age_ticks: reading.age_ticks }
}

/// Converts the drives' reading to the controller's scalar.
fn cast<S: Real, const N: usize>(sensed: &Sensed<f32, N>) -> Sensed<S, N> {
    let literal = |values: &[f32; N]| values.map(|x| S::literal(f64::from(x)));
    match sensed {
        Sensed::State { q, qd } => Sensed::State { q: literal(q), qd: literal(qd) },
        Sensed::Counts(counts) => Sensed::Counts(*counts),
    }
}
