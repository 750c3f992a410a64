//! The reference motion: the table `[motion]`.

/// The reference motion.
#[derive(Clone, Debug, PartialEq)]
pub enum MotionSpec {
    /// Rest at one position.
    Hold {
        /// Position, rad or m.
        q: Vec<f64>,
        /// Duration, s.
        duration: f64,
    },
    /// Quintic polynomials through points. Either every segment has a duration or none has. Without durations the motion is
    /// as fast as velocity, acceleration and torque limits allow.
    Quintic {
        /// The points, start first.
        points: Vec<ViaPoint>,
        /// Acceleration bounds per joint, rad/s^2 or m/s^2.
        acceleration: Option<Vec<f64>>,
        /// True if the motion starts again at its end.
        repeat: bool,
    },
    /// Trapezoidal speed along a straight line.
    Trapezoid {
        /// Start, rad or m.
        start: Vec<f64>,
        /// Goal, rad or m.
        goal: Vec<f64>,
        /// Acceleration bounds per joint, rad/s^2 or m/s^2; given if the duration is not.
        acceleration: Option<Vec<f64>>,
        /// Duration, s; given if the acceleration is not.
        duration: Option<f64>,
        /// Share of the duration spent on speeding up; the same share is spent on slowing down.
        ramp_share: f64,
    },
    /// A sine of changing frequency.
    Sine {
        /// Centre, rad or m.
        centre: Vec<f64>,
        /// Amplitude, rad or m.
        amplitude: Vec<f64>,
        /// Frequency at the start, Hz.
        frequency_start: f64,
        /// Frequency at the end, Hz.
        frequency_end: f64,
        /// Duration, s.
        duration: f64,
        /// Time in which the amplitude grows at the start and vanishes at the end, s.
        ramp: f64,
    },
    /// A finite Fourier series per joint.
    Fourier {
        /// Centre, rad or m.
        centre: Vec<f64>,
        /// Sine amplitudes of each harmonic for each joint, rad or m.
        sine: Vec<Vec<f64>>,
        /// Cosine amplitudes of each harmonic for each joint, rad or m.
        cosine: Vec<Vec<f64>>,
        /// Period of the first harmonic, s.
        period: f64,
        /// Duration, s.
        duration: f64,
        /// Time in which the series grows at the start and vanishes at the end, s.
        ramp: f64,
    },
}

/// A point of a quintic motion.
#[derive(Clone, Debug, PartialEq)]
pub struct ViaPoint {
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Duration of the segment that ends here, s.
    pub duration: Option<f64>,
    /// Time for which the arm rests here, s.
    pub dwell: f64,
}

impl MotionSpec {
    /// Start of the motion, rad or m.
    #[must_use]
    pub fn start(&self) -> &[f64] {
        match self {
            Self::Hold { q, .. } => q,
            Self::Quintic { points, .. } => points.first().map_or(&[], |point| &point.q),
            Self::Trapezoid { start, .. } => start,
            Self::Sine { centre, .. } | Self::Fourier { centre, .. } => centre,
        }
    }

    /// True if the motion starts again at its end.
    #[must_use]
    pub fn repeats(&self) -> bool {
        matches!(self, Self::Quintic { repeat: true, .. })
    }
}
