//! The arm's drives, for a board with CAN.

use dynamics_core::drive::{DriveKind, Drives, MitDrive};
use firmware::joint_io::bus_time::{BusLoad, LEAD_US};
use firmware::joint_io::can::BUSES;
use firmware::joint_io::frames::{Frames as _, Packet};

/// The arm's drives. Drives of another kind cause a compile error.
pub const DRIVES: [MitDrive; arm::N] = match arm::drives() {
    Drives::Mit(drives) => drives,
    Drives::Link | Drives::Pwm(_) => {
        panic!("this board drives MIT actuators: build it with a scene whose robot has drives of the kind mit")
    }
};

/// Load of each bus.
pub const LOADS: [BusLoad; BUSES] = {
    let identifier = <arm::Frames as DriveKind>::FACTS.identifier;
    [BusLoad::of(&DRIVES, 0, identifier), BusLoad::of(&DRIVES, 1, identifier), BusLoad::of(&DRIVES, 2, identifier)]
};

/// Checks at compile time that every reply arrives before the next tick.
const _: () = {
    let mut bus = 0;
    while bus < BUSES {
        let fits = LOADS[bus].actuators == 0 || arm::RATE_HZ <= LOADS[bus].max_rate_hz(LEAD_US) as f32;
        assert!(fits, "the scene's rate is faster than its CAN buses");
        bus += 1;
    }
};

/// Returns the frames that switch off the drives of a bus.
pub fn exits(bus: u8) -> impl Iterator<Item = Packet> {
    DRIVES.iter().filter(move |drive| drive.bus == bus).map(arm::Frames::exit)
}
