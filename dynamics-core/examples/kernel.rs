//! An arm's straight-line kernel compared with the recursion from which it was traced: the same bits.
//!
//! `kernel/planar2r.rs` is the output of `cargo newtau model kernel robots/planar2r.toml`. It needs only this crate,
//! no `std` and no allocation. A crate for a microcontroller includes it as a module, as here, and calls `Kernel` in
//! its control tick.
//!
//! ```console
//! $ cargo run -p dynamics-core --example kernel
//! ```

use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, ModelError, Rotor, Scene,
    Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};

#[allow(unreachable_pub, reason = "written for a library, whose own it would be")]
#[path = "kernel/planar2r.rs"]
mod planar2r;

/// The joints of `robots/planar2r.toml`.
fn joints() -> [JointSpec; 2] {
    [(2.0, 1.0, 0.166_666_666_666_666_66), (1.5, 0.8, 0.080_000_000_000_000_02)].map(|(mass, length, inertia)| {
        JointSpec {
            kind: JointKind::Revolute,
            frame: Frame::ClassicalDh(Dh { a: length, ..Dh::default() }),
            body: Body {
                mass,
                com: Vector3::new(-0.5 * length, 0.0, 0.0),
                inertia: Matrix3::from_diagonal(&Vector3::new(0.0, inertia, inertia)),
            },
            rotor: Rotor::default(),
            limits: Limits::none(),
        }
    })
}

fn main() -> Result<(), ModelError> {
    let model = Model::new(&joints(), &Tool::default())?.cast::<f32>();
    // On a floor: gravity along the joints' axes has no effect, and is not in the kernel.
    let recursion = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model));
    let nothing = Live::zero();
    for k in 0..1000 {
        let x = 0.01 * k as f32;
        let (q, qd, qdd) = ([x, 0.5 - x], [2.0 - x, x * x], [1.0 - 0.3 * x, x]);
        let turn = Polynomial.sin_cos_all(&q);
        let straight = planar2r::Kernel.inverse_dynamics(&turn, &q, &qd, &qdd, &nothing);
        let general = recursion.inverse_dynamics(&turn, &q, &qd, &qdd, &nothing);
        assert_eq!(straight.map(f32::to_bits), general.map(f32::to_bits), "at {q:?}");
    }
    println!("1000 states: the same bits");
    Ok(())
}
