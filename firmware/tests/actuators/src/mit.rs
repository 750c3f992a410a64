//! An actuator in MIT mode, from its own side of the wire.
//!
//! Field layout and special frames after B. Katz, `CAN_com.cpp` of the mini-cheetah motor controller, with its arithmetic:
//! `float_to_uint` cuts off, `uint_to_float` is `code span / (2^bits - 1) + min`.

/// Ranges of the fields, `(lowest, highest)`, at the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges {
    /// rad
    pub position: (f64, f64),
    /// rad/s
    pub velocity: (f64, f64),
    /// N m/rad
    pub kp: (f64, f64),
    /// N m s/rad
    pub kd: (f64, f64),
    /// N m
    pub torque: (f64, f64),
}

/// Last command to an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// rad
    pub position: f64,
    /// rad/s
    pub velocity: f64,
    /// N m/rad
    pub kp: f64,
    /// N m s/rad
    pub kd: f64,
    /// N m
    pub torque: f64,
}

/// An actuator: a shaft with inertia behind an ideal torque source.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Identifier of its commands.
    pub id: u16,
    /// Identifier of its replies.
    pub reply_id: u16,
    /// Bytes of its replies.
    pub reply_bytes: usize,
    /// Ranges of its frames' fields.
    pub ranges: Ranges,
    /// Inertia at the shaft, kg m^2.
    pub inertia: f64,
    /// Its greatest torque, for any command, N m.
    pub torque_max: f64,
    /// Seconds without a frame after which it gives no torque.
    pub timeout: f64,
    /// Shaft position, rad.
    pub position: f64,
    /// Shaft velocity, rad/s.
    pub velocity: f64,
    /// Its own error; not zero: it gives no torque.
    pub error: u8,
    /// Its temperature's byte.
    pub temperature: u8,
    enabled: bool,
    silent_for: f64,
    zero: f64,
    told: Told,
    torque: f64,
}

impl Actuator {
    /// An actuator at rest at 0, off.
    #[must_use]
    pub fn new(id: u16, ranges: Ranges) -> Self {
        Self {
            id,
            reply_id: 0,
            reply_bytes: 6,
            ranges,
            inertia: 0.01,
            torque_max: ranges.torque.1,
            timeout: 0.1,
            position: 0.0,
            velocity: 0.0,
            error: 0,
            temperature: 25,
            enabled: false,
            silent_for: 0.0,
            zero: 0.0,
            told: Told::default(),
            torque: 0.0,
        }
    }

    /// Whether it drives.
    #[must_use]
    pub fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Last command to it.
    #[must_use]
    pub fn told(&self) -> Told {
        self.told
    }

    /// Torque that it gives, N m.
    #[must_use]
    pub fn torque(&self) -> f64 {
        self.torque
    }

    /// Take a command; the reply's data. It measures now.
    pub fn receive(&mut self, data: &[u8]) -> Option<Vec<u8>> {
        let &[b0, b1, b2, b3, b4, b5, b6, b7] = data else { return None };
        self.silent_for = 0.0;
        match ([b0, b1, b2, b3, b4, b5, b6] == [0xff; 7], b7) {
            (true, 0xfc) => {
                self.enabled = true;
                self.told = Told::default();
            }
            (true, 0xfd) => {
                self.enabled = false;
                self.told = Told::default();
            }
            (true, 0xfe) => self.zero = self.position,
            _ => {
                let code = |high: u8, low: u8| u32::from(high) << 8 | u32::from(low);
                let r = &self.ranges;
                self.told = Told {
                    position: to_float(code(b0, b1), r.position, 16),
                    velocity: to_float(code(b2, b3) >> 4, r.velocity, 12),
                    kp: to_float(code(b3 & 0xf, b4), r.kp, 12),
                    kd: to_float(code(b5, b6) >> 4, r.kd, 12),
                    torque: to_float(code(b6 & 0xf, b7), r.torque, 12),
                };
            }
        }
        self.torque = self.effort();
        Some(self.reply())
    }

    /// Time goes by under a torque from outside, N m.
    pub fn step(&mut self, dt: f64, load: f64) {
        self.silent_for += dt;
        self.torque = self.effort();
        self.velocity += dt * (self.torque + load) / self.inertia;
        self.position += dt * self.velocity;
    }

    fn effort(&self) -> f64 {
        if !self.enabled || self.error != 0 || self.silent_for > self.timeout {
            return 0.0;
        }
        let Told { position, velocity, kp, kd, torque } = self.told;
        let wanted = kp * (position - (self.position - self.zero)) + kd * (velocity - self.velocity) + torque;
        wanted.clamp(-self.torque_max, self.torque_max)
    }

    fn reply(&self) -> Vec<u8> {
        let p = to_code(self.position - self.zero, self.ranges.position, 16);
        let v = to_code(self.velocity, self.ranges.velocity, 12);
        let t = to_code(self.torque, self.ranges.torque, 12);
        let mut data = vec![
            self.id as u8,
            (p >> 8) as u8,
            p as u8,
            (v >> 4) as u8,
            ((v & 0xf) << 4) as u8 + (t >> 8) as u8,
            t as u8,
            self.temperature,
            self.error,
        ];
        data.truncate(self.reply_bytes);
        data
    }
}

/// `float_to_uint`, on a value held inside the range.
#[must_use]
pub fn to_code(x: f64, (lo, hi): (f64, f64), bits: u32) -> u32 {
    let top = f64::from((1_u32 << bits) - 1);
    ((x.clamp(lo, hi) - lo) * top / (hi - lo)) as u32
}

/// `uint_to_float`.
#[must_use]
pub fn to_float(code: u32, (lo, hi): (f64, f64), bits: u32) -> f64 {
    f64::from(code) * (hi - lo) / f64::from((1_u32 << bits) - 1) + lo
}
