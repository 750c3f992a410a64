//! Targets that compute the torques: the desk, the chip, or both for comparison.

use dynamics_core::control::{ArmBuild, Protection as _};
use dynamics_core::{Command, Controller, Live, Measurement, Real, Reference};

/// Outcome of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ticked<S, const N: usize> {
    /// Command for the actuators.
    pub command: Command<S, N>,
    /// Instructions of the tick, if the target counts them.
    pub instructions: Option<u64>,
}

/// Interface between the loop and a target: measurement in, command out.
pub trait Torques<S, const N: usize> {
    /// Sets the live inputs of the scene, which act on the arm from the next tick on.
    ///
    /// # Errors
    /// As [`Torques::tick`].
    fn set_live(&mut self, live: &Live<S, N>) -> miette::Result<()>;

    /// Computes one tick.
    ///
    /// # Errors
    /// The target cannot be reached or sends an invalid answer; the desk's own controller never fails.
    fn tick(&mut self, reference: &Reference<S, N>, measurement: &Measurement<S, N>) -> miette::Result<Ticked<S, N>>;

    /// Estimate of the external torque on each joint, N m or N; `None` if it is not estimated.
    fn external(&self) -> Option<[f64; N]> {
        None
    }
}

impl<S: Real, const N: usize, A: ArmBuild<S, N>> Torques<S, N> for Controller<S, N, A> {
    fn set_live(&mut self, live: &Live<S, N>) -> miette::Result<()> {
        *self.live_mut() = *live;
        Ok(())
    }

    fn tick(&mut self, reference: &Reference<S, N>, measurement: &Measurement<S, N>) -> miette::Result<Ticked<S, N>> {
        Ok(Ticked { command: Controller::tick(self, reference, measurement), instructions: None })
    }

    fn external(&self) -> Option<[f64; N]> {
        self.protection().external().map(|external| external.map(Real::to_f64))
    }
}

/// The chip's commands, each compared with the command that the desk's controller computes from the same inputs.
///
/// Torques, limits and faults must agree to the last bit.
#[derive(Clone, Debug)]
pub struct CommandComparison<C, D> {
    chip: C,
    desk: D,
    seen: Parity,
    instructions: Option<(u64, u64)>,
}

/// Counts of the comparison between desk and chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize)]
pub struct Parity {
    /// Ticks compared.
    pub ticks: u64,
    /// Ticks in which a torque, a limit or a fault differed by any bit.
    pub mismatches: u64,
}

impl<C, D> CommandComparison<C, D> {
    /// A comparison in which `chip` drives the arm and `desk` checks its commands.
    pub fn new(chip: C, desk: D) -> Self {
        Self { chip, desk, seen: Parity::default(), instructions: None }
    }

    /// Result of the comparison so far.
    pub fn parity(&self) -> Parity {
        self.seen
    }

    /// Fewest and most instructions in a tick, if the chip counts them.
    pub fn instructions(&self) -> Option<(u64, u64)> {
        self.instructions
    }
}

impl<const N: usize, C: Torques<f32, N>, D: Torques<f32, N>> Torques<f32, N> for CommandComparison<C, D> {
    fn set_live(&mut self, live: &Live<f32, N>) -> miette::Result<()> {
        self.chip.set_live(live)?;
        self.desk.set_live(live)
    }

    fn tick(
        &mut self,
        reference: &Reference<f32, N>,
        measurement: &Measurement<f32, N>,
    ) -> miette::Result<Ticked<f32, N>> {
        let chip = self.chip.tick(reference, measurement)?;
        let desk = self.desk.tick(reference, measurement)?;
        self.seen.ticks += 1;
        if !same_bits(&chip.command, &desk.command) {
            self.seen.mismatches += 1;
        }
        if let Some(count) = chip.instructions {
            let (least, most) = self.instructions.unwrap_or((count, count));
            self.instructions = Some((least.min(count), most.max(count)));
        }
        Ok(chip)
    }

    /// Returns the desk's estimate, because the chip does not send its own in lock step.
    fn external(&self) -> Option<[f64; N]> {
        self.desk.external()
    }
}

fn same_bits<const N: usize>(a: &Command<f32, N>, b: &Command<f32, N>) -> bool {
    match (a, b) {
        (Command::Drive { torque: ta, limits: la }, Command::Drive { torque: tb, limits: lb }) => {
            ta.map(f32::to_bits) == tb.map(f32::to_bits) && la == lb
        }
        (Command::Brake(fa), Command::Brake(fb)) => fa == fb,
        (Command::Drive { .. }, Command::Brake(_)) | (Command::Brake(_), Command::Drive { .. }) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics_core::control::LimitFlags;
    use dynamics_core::{Fault, Sensed};

    /// A target that always returns the same command.
    struct Says(Command<f32, 1>);

    impl Torques<f32, 1> for Says {
        fn set_live(&mut self, _: &Live<f32, 1>) -> miette::Result<()> {
            Ok(())
        }

        fn tick(&mut self, _: &Reference<f32, 1>, _: &Measurement<f32, 1>) -> miette::Result<Ticked<f32, 1>> {
            Ok(Ticked { command: self.0, instructions: Some(700) })
        }
    }

    fn mismatches(chip: Command<f32, 1>, desk: Command<f32, 1>) -> u64 {
        let mut both = CommandComparison::new(Says(chip), Says(desk));
        let reference = Reference { q: [0.0], qd: [0.0], qdd: [0.0] };
        let measurement = Measurement { sensed: Sensed::State { q: [0.0], qd: [0.0] }, age_ticks: 0 };
        assert!(both.tick(&reference, &measurement).is_ok_and(|ticked| ticked.command == chip));
        assert_eq!(both.instructions(), Some((700, 700)));
        assert_eq!(both.parity().ticks, 1);
        both.parity().mismatches
    }

    #[test]
    fn any_bit_of_torque_limits_or_fault_is_a_mismatch() {
        let drive = |torque, bits| Command::Drive { torque: [torque], limits: [LimitFlags::from_bits(bits)] };
        assert_eq!(mismatches(drive(1.0, 0), drive(1.0, 0)), 0);
        assert_eq!(mismatches(drive(1.0, 0), drive(1.0 + f32::EPSILON, 0)), 1);
        assert_eq!(mismatches(drive(0.0, 0), drive(-0.0, 0)), 1);
        assert_eq!(mismatches(drive(1.0, 4), drive(1.0, 0)), 1);
        assert_eq!(mismatches(drive(1.0, 0), Command::Brake(Fault::Overrun)), 1);
        assert_eq!(mismatches(Command::Brake(Fault::StaleMeasurement), Command::Brake(Fault::Overrun)), 1);
        assert_eq!(mismatches(Command::Brake(Fault::Overrun), Command::Brake(Fault::Overrun)), 0);
    }
}
