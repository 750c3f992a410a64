//! A simulated arm at a SocketCAN interface, for `cargo xtask vcan`: `vcan-arm SCENE INTERFACE`. Ends when the interface goes away.

#[cfg(target_os = "linux")]
fn main() -> miette::Result<()> {
    use board::can::frame::CanFrame;
    use board::can::simulated::SimulatedArm;
    use robot_compiler::SceneFile;
    use sim::failure::Failure;
    use socketcan::{CanFrame as Received, CanSocket, EmbeddedFrame as _, Frame as _, Socket as _};
    use std::io::ErrorKind;
    use std::path::Path;
    use std::time::Duration;

    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [scene, interface] = arguments.as_slice() else { miette::bail!("expected: vcan-arm SCENE INTERFACE") };
    let scene = SceneFile::load(Path::new(scene)).map_err(|error| miette::miette!("{error}"))?;
    let arm = SimulatedArm::new(&scene).map_err(Failure::report)?;
    let failed = |error: std::io::Error| miette::miette!("{interface}: {error}");
    let socket = CanSocket::open(interface).map_err(failed)?;
    socket.set_read_timeout(Duration::from_millis(1)).map_err(failed)?;
    println!("the arm is at {interface}");
    loop {
        arm.advance();
        let frame = match socket.read_frame() {
            Ok(Received::Data(frame)) => frame,
            Ok(_) => continue,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => continue,
            Err(error) => return Err(failed(error)),
        };
        let Some(frame) = CanFrame::of(frame.raw_id(), frame.is_extended(), frame.data()) else { continue };
        for reply in arm.deliver(&frame) {
            use embedded_can::Frame as _;
            if let Some(reply) = socketcan::CanDataFrame::new(reply.id(), reply.data()) {
                socket.write_frame(&reply).map_err(failed)?;
            }
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn main() {
    eprintln!("vcan-arm: only Linux has SocketCAN");
}
