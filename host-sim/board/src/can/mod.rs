//! CAN adapters of a computer, as the buses of the joints' driver.
//!
//! | module | holds |
//! |---|---|
//! | [`adapter`] | interface to an adapter |
//! | [`adapter_name`] | adapters by name: opening one, and the line between it and the computer |
//! | [`damiao_motor`] | registers, state and settings of a Damiao motor |
//! | [`frame`] | a classic CAN frame |
//! | [`host_bus`] | an adapter as a bus of [`CanJoints`](joint_io::can::CanJoints) |
//! | `socket` | SocketCAN of Linux |
//! | [`motors`] | search for motors on a bus |
//! | [`motor`] | a motor of any kind: its state, changes of its settings |
//! | [`robstride_motor`] | parameters, state and settings of a RobStride motor |
//! | [`robstride_parameter`], [`robstride_state`] | its parameters, and its state in a reply |
//! | [`setup`] | which motor moves which joint |
//! | [`slcan`] | adapters that speak the text protocol of Lawicel on a serial port |
//! | [`damiao_usb`] | Damiao's own USB adapter |
//! | `gs_usb` | USB adapters with the protocol of candleLight, without a driver of the system |
//! | `serial_adapter` | serial ports of both: a thread that reads, and writing without waiting |
//! | [`simulated`] | a simulated arm at the other end of the buses |

pub mod adapter;
pub mod adapter_name;
pub mod damiao_motor;
pub mod damiao_register;
pub mod damiao_usb;
pub mod frame;
mod gs_usb;
pub mod host_bus;
pub mod motor;
pub mod motors;
pub mod robstride_motor;
pub mod robstride_parameter;
pub mod robstride_state;
mod serial_adapter;
pub mod settings;
pub mod setup;
pub mod simulated;
pub mod slcan;
#[cfg(target_os = "linux")]
mod socket;
