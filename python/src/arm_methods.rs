//! Methods and properties of the class `Arm`, for one state and for many.

use crate::arm::Arm;
use crate::compute::compute;
use crate::kernel_source::kernel_source;
use batch_engine::Quantity;
use dynamics_core::JointKind;
use dynamics_core::regressor::PARAMETER_NAMES;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use robot_compiler::RobotJoint;

#[pymethods]
impl Arm {
    /// Computes the actuator torques that give the arm the accelerations ``qdd``.
    ///
    /// ``tau = D(q) qdd + C(q, qd) qd + G(q)``, with the rotors of the robot file; friction is not included.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (batch, n)
    ///     Joint positions, rad (revolute) or m (prismatic).
    /// qd : array_like, same shape
    ///     Joint velocities, rad/s or m/s.
    /// qdd : array_like, same shape
    ///     Joint accelerations, rad/s^2 or m/s^2.
    /// out : ndarray, optional
    ///     Array for the result: shape and dtype of the result, no memory in common with an input.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,) or (batch, n)
    ///     Torques, N m, or forces, N. float32 if the inputs promote to float32, otherwise float64.
    #[pyo3(signature = (q, qd, qdd, out=None))]
    fn inverse_dynamics<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::InverseDynamics, &[("q", q), ("qd", qd), ("qdd", qdd)], out)
    }

    /// Computes the actuator torques that hold the arm at rest: ``G(q)``.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (batch, n)
    ///     Joint positions, rad or m.
    /// out : ndarray, optional
    ///     Array for the result.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,) or (batch, n)
    ///     Torques, N m, or forces, N.
    #[pyo3(signature = (q, out=None))]
    fn gravity<'py>(&self, q: &Bound<'py, PyAny>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::Gravity, &[("q", q)], out)
    }

    /// Computes the joint-space inertia matrix ``D(q)``, with payload and rotors. It is symmetric.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (batch, n)
    ///     Joint positions, rad or m.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n, n) or (batch, n, n)
    ///     kg m^2 (two revolute joints), kg m (one of them), or kg (two prismatic joints).
    fn mass_matrix<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::MassMatrix, &[("q", q)], None)
    }

    /// Computes the joint accelerations under the actuator torques ``tau``.
    ///
    /// Solves ``D(q) qdd = tau - C(q, qd) qd - G(q)``.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (batch, n)
    ///     Joint positions, rad or m.
    /// qd : array_like, same shape
    ///     Joint velocities, rad/s or m/s.
    /// tau : array_like, same shape
    ///     Actuator torques, N m, or forces, N.
    /// out : ndarray, optional
    ///     Array for the result.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,) or (batch, n)
    ///     Joint accelerations, rad/s^2 or m/s^2.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A joint moves neither mass nor rotor, so the inertia matrix is singular. The message names state and joint.
    #[pyo3(signature = (q, qd, tau, out=None))]
    fn forward_dynamics<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::ForwardDynamics, &[("q", q), ("qd", qd), ("tau", tau)], out)
    }

    /// Computes the geometric Jacobian of the tip frame, in axes of the base frame.
    ///
    /// ``jacobian(q) @ qd`` is the velocity of the tip frame's origin (rows 0 to 2, m/s) followed by the angular velocity of the tip
    /// frame (rows 3 to 5, rad/s), both in base axes. Pinocchio calls this LOCAL_WORLD_ALIGNED.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (batch, n)
    ///     Joint positions, rad or m.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (6, n) or (batch, 6, n)
    fn jacobian<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::Jacobian, &[("q", q)], None)
    }

    /// Computes the regressor: the derivative of the torques with respect to the inertial parameters, in which they are linear.
    ///
    /// ``regressor(q, qd, qdd) @ arm.parameters + arm.rotor_inertia * qdd`` equals ``inverse_dynamics(q, qd, qdd)``.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (batch, n)
    ///     As for inverse_dynamics.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n, 10 n) or (batch, n, 10 n)
    ///     Ten columns for each link, base first, in the order of ``arm.parameter_names``. The parameters are those of the link's own
    ///     frame, whose z axis is the joint axis.
    fn regressor<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::Regressor, &[("q", q), ("qd", qd), ("qdd", qdd)], None)
    }

    /// Computes the pose of the tip frame in the base frame.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (batch, n)
    ///     Joint positions, rad or m.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (4, 4) or (batch, 4, 4)
    ///     Homogeneous transformation ``base_from_tip``: rotation matrix, and origin of the tip frame in m.
    fn tip_pose<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        compute(q.py(), self, Quantity::TipPose, &[("q", q)], None)
    }

    /// Name of the arm in its file.
    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    /// Number of joints, n.
    #[getter]
    const fn n(&self) -> usize {
        self.arm.joints()
    }

    /// Names of the joints, base first.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.robot.joints.iter().map(|joint| joint.name.as_str()).collect()
    }

    /// Kind of each joint: "revolute" or "prismatic".
    #[getter]
    fn joint_types(&self) -> Vec<&'static str> {
        let kind = |joint: &RobotJoint| match joint.spec.kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
        };
        self.robot.joints.iter().map(kind).collect()
    }

    /// Gravitational acceleration in the base frame, m/s^2, shape (3,).
    #[getter]
    fn gravity_vector<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.gravity)
    }

    /// Lowest and highest position of each joint, rad or m, shape (n, 2); infinite where the file gives none.
    #[getter]
    fn position_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let limits = self.robot.joints.iter().map(|joint| <[f64; 2]>::from(joint.spec.limits.position));
        PyArray2::from_owned_array(py, limits.collect::<Vec<_>>().into())
    }

    /// Largest velocity of each joint, rad/s or m/s, shape (n,); infinite where the file gives none.
    #[getter]
    fn velocity_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.robot.joints.iter().map(|joint| joint.spec.limits.velocity))
    }

    /// Largest torque of each joint, N m or N, shape (n,); infinite where the file gives none.
    #[getter]
    fn torque_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.robot.joints.iter().map(|joint| joint.spec.limits.torque))
    }

    /// Rotor inertia of each joint after the gear, kg m^2 (kg for a prismatic joint), shape (n,).
    #[getter]
    fn rotor_inertia<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.robot.joints.iter().map(|joint| joint.spec.rotor.reflected()))
    }

    /// Inertial parameters of the links, shape (10 n,), in the order of parameter_names: kg, kg m, kg m^2, about the origin of the link's
    /// frame. Tool and payload are part of the last link.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.arm.parameters())
    }

    /// Names of the inertial parameters, such as "elbow.mx".
    #[getter]
    fn parameter_names(&self) -> Vec<String> {
        let joints = self.robot.joints.iter();
        joints.flat_map(|joint| PARAMETER_NAMES.map(|name| format!("{}.{name}", joint.name))).collect()
    }

    /// Returns the source text of the inverse dynamics as straight-line code, under the gravity and with the payload of this arm.
    ///
    /// It is the text of ``newtau model kernel``. The code needs no library: Rust depends on the crate dynamics-core, C99 on nothing. The
    /// caller computes the sines and cosines.
    ///
    /// Parameters
    /// ----------
    /// language : {"rust", "c"}
    ///     ``"rust"`` has the type ``Kernel``, which implements ``InverseDynamics``; ``"c"`` has the function
    ///     ``arm_kernel_inverse_dynamics``.
    /// scalar : {"f32", "f64"}
    ///     Floating-point type of the code.
    ///
    /// Returns
    /// -------
    /// str
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     An unknown language or scalar.
    #[pyo3(signature = (language="rust", scalar="f32"))]
    fn kernel(&self, language: &str, scalar: &str) -> PyResult<String> {
        kernel_source(self, language, scalar)
    }

    /// Returns the arm as the text of a URDF file, without the payload. Shapes are made up: a cylinder along every link.
    fn to_urdf(&self) -> String {
        robot_compiler::emit::urdf(&self.robot)
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.gravity;
        format!("<newtau.Arm {:?}: {} joints, gravity ({x}, {y}, {z}) m/s^2>", self.robot.name, self.arm.joints())
    }
}
