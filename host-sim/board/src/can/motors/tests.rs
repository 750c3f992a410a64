//! Searches and settings, with motors that were written from the makers' documents.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::adapter::Adapter;
use super::super::damiao_motor::DamiaoMotor;
use super::super::damiao_register::{SHOWN, TORQUE_RANGE, VELOCITY_RANGE};
use super::super::frame::CanFrame;
use super::{Found, Value, search};
use dynamics_core::drive::Protocol;
use embedded_can::Frame as _;
use std::collections::{BTreeMap, VecDeque};
use std::io;

/// A Damiao motor: registers, those in flash, and whether it is on.
#[derive(Clone, Debug, Default)]
struct Motor {
    registers: BTreeMap<u8, u32>,
    flash: BTreeMap<u8, u32>,
    state: u8,
    position: u16,
    /// A motor whose flash is broken takes values and does not confirm that it stored them.
    forgetful: bool,
}

impl Motor {
    fn new(id: u32) -> Self {
        let registers: BTreeMap<u8, u32> = [
            (7, id + 16),
            (8, id),
            (9, 8000),
            (21, 12.5_f32.to_bits()),
            (22, 30.0_f32.to_bits()),
            (23, 10.0_f32.to_bits()),
        ]
        .into();
        Self { flash: registers.clone(), registers, position: 0x9000, ..Self::default() }
    }

    fn id(&self) -> u32 {
        self.registers[&8]
    }

    fn reply(&self, data: [u8; 8]) -> CanFrame {
        CanFrame::of(self.registers[&7], false, &data).unwrap()
    }

    fn report(&self) -> CanFrame {
        let [high, low] = self.position.to_be_bytes();
        self.reply([self.state << 4 | self.id() as u8 & 0xF, high, low, 0x7F, 0xF7, 0xFF, 30, 31])
    }

    fn answer(&mut self, frame: &CanFrame) -> Option<CanFrame> {
        let data: [u8; 8] = frame.data().try_into().ok()?;
        if frame.raw_id() == self.id() && !frame.is_extended() {
            match data[7] {
                0xFB => self.state = 0,
                0xFC => self.state = 1,
                0xFD => self.state = 0,
                0xFE => self.position = 0x8000,
                _ => {}
            }
            return Some(self.report());
        }
        let [low, high, what, register, value @ ..] = data;
        if frame.raw_id() != 0x7FF || u32::from(u16::from_le_bytes([low, high])) != self.id() {
            return None;
        }
        match what {
            0xCC => Some(self.report()),
            0x33 => {
                let mut data = data;
                data[4..].copy_from_slice(&self.registers.get(&register)?.to_le_bytes());
                Some(self.reply(data))
            }
            0x55 => {
                let answer = self.reply(data);
                self.registers.insert(register, u32::from_le_bytes(value));
                Some(answer)
            }
            0xAA if self.forgetful => None,
            0xAA => {
                self.flash = self.registers.clone();
                Some(self.reply(data))
            }
            _ => None,
        }
    }
}

/// A bus with Damiao motors and one RobStride.
#[derive(Default)]
struct Bus {
    motors: Vec<Motor>,
    robstride: Option<u8>,
    answers: VecDeque<CanFrame>,
    sent: Vec<CanFrame>,
    off: bool,
}

impl Adapter for Bus {
    fn begin_tick(&mut self) {}

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.sent.push(*frame);
        self.answers.extend(self.motors.iter_mut().filter_map(|motor| motor.answer(frame)));
        // Read of parameter 0x7028: kind 17, host, motor.
        let id = frame.raw_id();
        if frame.is_extended() && id >> 24 == 17 && Some(id as u8) == self.robstride {
            let host = id >> 8 & 0xFF;
            let mut data: [u8; 8] = frame.data().try_into().unwrap();
            data[4..].copy_from_slice(&400_u32.to_le_bytes());
            self.answers.push_back(CanFrame::of(17 << 24 | u32::from(id as u8) << 8 | host, true, &data).unwrap());
        }
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        Ok(self.answers.pop_front())
    }

    fn is_off(&mut self) -> bool {
        self.off
    }
}

fn bus(ids: &[u32]) -> Bus {
    Bus { motors: ids.iter().copied().map(Motor::new).collect(), ..Bus::default() }
}

#[test]
fn a_search_finds_every_motor_once_and_asks_for_nothing_but_a_setting() {
    let mut bus = Bus { robstride: Some(5), ..bus(&[1, 3, 17, 127]) };
    let found: Vec<(u8, u32, u32)> = search(&mut bus, Protocol::Damiao)
        .unwrap()
        .unwrap()
        .iter()
        .map(|it: &Found| (it.id, it.reply_id, it.timeout_us))
        .collect();
    assert_eq!(found, [(1, 17, 400_000), (3, 19, 400_000), (17, 33, 400_000), (127, 143, 400_000)]);
    assert!(bus.sent.iter().all(|frame| frame.raw_id() == 0x7FF && frame.data()[2..4] == [0x33, 9]));
    bus.sent.clear();
    let found = search(&mut bus, Protocol::RobStride).unwrap().unwrap();
    assert_eq!(found.iter().map(|it| (it.id, it.timeout_us)).collect::<Vec<_>>(), [(5, 20_000)]);
    assert!(bus.sent.iter().all(|frame| frame.is_extended() && frame.raw_id() >> 24 == 17));
    bus.sent.clear();
    for kind in [Protocol::MiniCheetah, Protocol::MyActuator] {
        assert_eq!(search(&mut bus, kind).unwrap(), None, "{kind:?}");
    }
    assert!(bus.sent.is_empty(), "such a motor would have to be commanded");
    assert!(bus.motors.iter().all(|motor| motor.state == 0));
}

#[test]
fn an_adapter_that_is_off_the_bus_ends_a_search() {
    let mut bus = Bus { off: true, ..bus(&[1]) };
    bus.motors.clear();
    assert!(search(&mut bus, Protocol::Damiao).is_err());
}

#[test]
fn state_and_registers_are_read() {
    let mut bus = bus(&[3]);
    bus.motors[0].state = 0xC;
    let mut motor = DamiaoMotor::new(&mut bus, 3);
    let state = motor.state().unwrap().unwrap();
    assert_eq!((state.text(), state.temperatures), ("winding too hot", [30, 31]));
    assert!(
        (state.shares[0] - (2.0 * f64::from(0x9000) / 65535.0 - 1.0)).abs() < 1e-12 && state.shares[2].abs() < 1e-3
    );
    let values: Vec<_> = SHOWN.iter().filter_map(|&register| motor.read(register).unwrap()).collect();
    let ranges = [12.5, 30.0, 10.0].map(Value::Float);
    assert_eq!(values, [&[3, 19, 8000].map(Value::Integer)[..], &ranges].concat());
    assert_eq!(DamiaoMotor::new(&mut bus, 4).state().unwrap(), None, "silent");
}

#[test]
fn settings_are_read_back_and_stored_only_while_the_motor_is_off() {
    let mut bus = bus(&[1, 2]);
    DamiaoMotor::new(&mut bus, 1).set_timeout(400).unwrap();
    assert_eq!((bus.motors[0].flash[&9], bus.motors[1].flash[&9]), (400, 8000));
    DamiaoMotor::new(&mut bus, 1).set_id(9, 16).unwrap();
    assert_eq!((bus.motors[0].flash[&8], bus.motors[0].flash[&7]), (9, 25));
    assert!(DamiaoMotor::new(&mut bus, 2).set_zero().unwrap().1.abs() < 1e-4);
    let why = DamiaoMotor::new(&mut bus, 9).set_id(2, 16).unwrap_err().to_string();
    assert_eq!(why, "motor 2 is on this bus already: nothing was changed");

    bus.motors[1].state = 1;
    let why = DamiaoMotor::new(&mut bus, 2).set_timeout(400).unwrap_err().to_string();
    assert!(why.starts_with("motor 2 is on: nothing was changed"), "{why}");
    assert!(DamiaoMotor::new(&mut bus, 2).set_zero().is_err() && DamiaoMotor::new(&mut bus, 2).set_id(5, 16).is_err());
    assert_eq!((bus.motors[1].registers[&9], bus.motors[1].id()), (8000, 2));

    bus.motors[1].state = 0;
    bus.motors[1].forgetful = true;
    let why = DamiaoMotor::new(&mut bus, 2).set_timeout(400).unwrap_err().to_string();
    assert!(why.contains("did not confirm that it stored it"), "{why}");
    let why = DamiaoMotor::new(&mut bus, 7).set_timeout(400).unwrap_err().to_string();
    assert_eq!(why, "motor 7 does not answer");
}

#[test]
fn ranges_are_set_together_and_stored_at_the_end() {
    let mut bus = bus(&[4]);
    let set = |bus: &mut Bus, torque| {
        DamiaoMotor::new(bus, 4)
            .set_ranges(&[(VELOCITY_RANGE, 45.0), (TORQUE_RANGE, torque)])
            .map_err(|why| why.to_string())
    };
    set(&mut bus, 28.0).unwrap();
    let stored = |bus: &Bus| [21, 22, 23].map(|register| bus.motors[0].flash[&register]);
    let ranges = [12.5_f32, 45.0, 28.0].map(f32::to_bits);
    assert_eq!(stored(&bus), ranges);
    let stores = bus.sent.iter().filter(|frame| frame.data()[2] == 0xAA).count();
    assert_eq!(stores, 1);
    bus.motors[0].state = 1;
    assert!(set(&mut bus, 10.0).unwrap_err().starts_with("motor 4 is on: nothing was changed"));
    bus.motors[0].state = 0;
    bus.motors[0].forgetful = true;
    let why = set(&mut bus, 10.0).unwrap_err();
    assert!(
        why.starts_with(
            "torque range of the frames: 10 is set, and the motor did not confirm that it stored it: switch "
        ),
        "{why}"
    );
    assert!(why.ends_with("; the ranges before it are set, too"), "{why}");
    assert_eq!(stored(&bus), ranges);
}

#[test]
fn an_error_is_cleared_and_the_motor_stays_off() {
    let mut bus = bus(&[6]);
    bus.motors[0].state = 0xE;
    assert_eq!(DamiaoMotor::new(&mut bus, 6).clear().unwrap().text(), "off");
    let enables = bus.sent.iter().filter(|frame| frame.data()[7] == 0xFC && frame.raw_id() == 6).count();
    assert_eq!(enables, 0);
}
