//! Conditions of hand guiding: the limits of the first motion, the soft walls, and the error of the gravity model.

use super::torque_check::GravityError;
use super::{Operator, Stop};
use link::StateCode;

/// Time over which an arm at rest is observed before hand guiding, s.
const AT_REST: f64 = 0.12;

/// Number of observations of an arm that has not come to rest yet.
const LOOKS: u32 = 10;

/// Depth in a soft wall, rad or m, that counts as outside of it: nobody places an arm more exactly.
const DEPTH_MIN: f64 = 2e-3;

impl Operator {
    /// True if a driven arm may be hand-guided now. Otherwise says why not. The walls come last: the arm is at rest then.
    pub(super) fn may_be_led(&mut self, name: &str) -> Result<bool, Stop> {
        Ok(self.is_seen(name)? && self.gravity_is_good_enough(name)? && self.is_clear_of_walls(name)?)
    }

    /// True if a motion that begins now would begin hand guiding.
    pub(super) fn begins_guiding(&self) -> bool {
        self.arm.law.is_hand_guided() && self.state() != Some(StateCode::Running)
    }

    /// True if the law follows a motion. Under a law for hand guiding the reference is the arm's own position: a motion would only let the arm go.
    pub(super) fn follows_motions(&mut self, name: &str) -> Result<bool, Stop> {
        if !self.arm.law.is_hand_guided() {
            return Ok(true);
        }
        let why = "an arm that is guided by hand follows no motion; guide it to the place, or choose another law (`law computed-torque`) first";
        self.reject(name, why).map(|()| false)
    }

    /// True if the arm may begin a motion. Under a law for hand guiding it may not, and the limits of the first motion are then the first reason.
    pub(super) fn may_move(&mut self, name: &str) -> Result<bool, Stop> {
        Ok(!self.arm.law.is_hand_guided() || (self.is_seen(name)? && self.follows_motions(name)?))
    }

    /// True if the limits of the first motion are lifted. While they are in force, a joint that is guided too fast is a fault, and an arm without brakes
    /// then sinks.
    fn is_seen(&mut self, name: &str) -> Result<bool, Stop> {
        let Some(share) = self.limit() else { return Ok(true) };
        let percent = 100.0 * share;
        let what_to_do = match (self.arm.law.is_hand_guided(), self.arm.tunable) {
            (false, _) => "`jog` every joint a little, then lift the limits with `full-range`",
            (true, true) => {
                "choose a law that follows a reference (`law computed-torque`), `jog` every joint a little, then lift the limits with `full-range`"
            }
            // With this scene's control law, nothing moves before the limits are lifted.
            (true, false) => {
                "this scene has no law that follows a reference: give its [control] another `law`, `tunable = true` and `teach = {}`, so that the first \
                 motion uses that law and `teach` follows in the same session; `full-range` lifts the limits here although nothing was seen of the arm"
            }
        };
        self.reject(
            name,
            &format!(
                "in the first motion after homing (`first_motion` in [safety]) a hand that leads a joint faster than {percent:.0} % of its \
                 velocity bound causes fault 5; {what_to_do}"
            ),
        )?;
        Ok(false)
    }

    /// True if no joint stands in a soft wall, which would push it from the first tick on, while a hand reaches for the arm.
    pub(super) fn is_clear_of_walls(&mut self, name: &str) -> Result<bool, Stop> {
        let (Some(walls), Some(q)) = (&self.arm.walls, &self.q) else { return Ok(true) };
        let inside = self.arm.joints.iter().zip(q).zip(walls).filter_map(|(((joint, unit, _), q), (low, high))| {
            let depth = (low - q).max(q - high);
            (depth > DEPTH_MIN).then(|| format!("{joint} by {depth:.3} {unit} (no wall from {low:.2} to {high:.2})"))
        });
        let inside: Vec<String> = inside.collect();
        if inside.is_empty() {
            return Ok(true);
        }
        let way_out = match self.arm.tunable {
            true => "under a law that follows a reference, `jog` or `goto` moves them out",
            false => "`disarm` with the arm supported, bring them out by hand, and arm again",
        };
        let inside = inside.join(", ");
        let why = format!("in the soft walls of hand guiding, which would push at once, stand {inside}; {way_out}");
        self.reject(name, &why).map(|()| false)
    }

    /// Reports the error of the gravity model before hand guiding. Returns false, and leaves the arm as it is, if a joint's error exceeds its
    /// friction: that joint would drift.
    fn gravity_is_good_enough(&mut self, name: &str) -> Result<bool, Stop> {
        if !self.torque_is_believed()? {
            return Ok(false);
        }
        self.until_at_rest()?;
        self.watch(1)?;
        let mut seen = None;
        // After a motion, the torques of an arm that settles differ from those of its weight for a while.
        for _ in 0..LOOKS {
            self.wait(AT_REST)?;
            seen = self.gravity_errors();
            if seen.as_ref().is_some_and(|errors| !errors.iter().any(GravityError::drifts)) {
                break;
            }
        }
        self.watch_as_needed()?;
        let Some(errors) = seen else {
            self.reject(name, "the gravity model cannot be checked: no torque acts, or too few reports come")?;
            return Ok(false);
        };
        let in_words = |error: &GravityError| {
            let (name, _, unit) = self.arm.joint(error.joint);
            format!("{name} {:.2} {unit} (friction {:.2})", error.error.abs(), error.friction)
        };
        let share = |error: &GravityError| error.error.abs() / error.friction;
        let worst = errors.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
        let text = worst.map(in_words).unwrap_or_default();
        let drifting: Vec<String> = errors.iter().filter(|error| error.drifts()).map(in_words).collect();
        if drifting.is_empty() {
            let found =
                format!("{name}: error of the gravity model: {text} at most; `newtau identify` makes it smaller");
            self.say(name, &found)?;
            return Ok(true);
        }
        self.reject(
            name,
            &format!(
                "the error of the gravity model exceeds the friction, so the arm would drift: {}; declare what it holds with \
                 `payload`, or with `weigh` under another law, or run `newtau identify`",
                drifting.join(", ")
            ),
        )?;
        Ok(false)
    }

    /// Starts hand guiding of an arm that may be led: the arm runs, and its reference follows its position. The walls again: the arm may have
    /// moved while the law was changed.
    pub(super) fn lead(&mut self) -> Result<(), Stop> {
        if !self.is_clear_of_walls("teach")? {
            return Ok(());
        }
        let here = self.here()?;
        let denial = self.set_out(Vec::new(), &here, here.clone())?;
        self.answer("teach", denial, "; guide it by hand, then `hold`")
    }
}
