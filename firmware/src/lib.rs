//! Portable parts of the firmware.
