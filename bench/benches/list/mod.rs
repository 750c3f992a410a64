//! Benchmarks on the desk: one list for both times and instruction counts.

use bench::kernels as k;
use bench::plain;
use bench::states::{DESK, States};
use dynamics_batch::{Float, inverse_dynamics_batch};
use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{Dynamics, InverseDynamics, Live, Real, SinCos, Trig};
use std::cell::RefCell;
use std::hint::black_box;
use std::rc::Rc;

/// A benchmark and its name: `ARM_WHAT_SCALAR`.
pub struct Work {
    pub name: String,
    /// Runs the benchmark in this many states, one after another.
    pub run: Box<dyn Fn(usize)>,
}

/// A state, and the sine and cosine of its joints.
struct Inputs<S> {
    turn: [SinCos<S>; 6],
    q: [S; 6],
    qd: [S; 6],
    qdd: [S; 6],
}

type All<S> = Rc<[Inputs<S>]>;

fn inputs<S: Real>() -> All<S>
where
    Polynomial: Trig<S>,
{
    let states = States::first::<S, DESK>();
    states.iter().map(|s| Inputs { turn: Polynomial.sin_cos_all(&s.q), q: s.q, qd: s.qd, qdd: s.qdd }).collect()
}

/// All benchmarks, in the order of the report.
pub fn all() -> Vec<Work> {
    let (double, single) = (inputs::<f64>(), inputs::<f32>());
    let mut list = vec![
        trig("trig_polynomial_f64", Polynomial, &double),
        trig("trig_libm_f64", Libm, &double),
        trig("trig_polynomial_f32", Polynomial, &single),
        trig("trig_libm_f32", Libm, &single),
    ];
    macro_rules! arm {
        ($arm:literal: $exact_f64:ident $regrouped_f64:ident $exact_f32:ident $regrouped_f32:ident
         $any:ident $forward:ident $gravity:ident $mass_matrix:ident $($argument:ident)*) => {
            torques(&mut list, concat!($arm, "_generic_f64"), generic::<f64>($arm), &double);
            torques(&mut list, concat!($arm, "_exact_f64"), k::$exact_f64::Kernel, &double);
            torques(&mut list, concat!($arm, "_regrouped_f64"), k::$regrouped_f64::Kernel, &double);
            torques(&mut list, concat!($arm, "_generic_f32"), generic::<f32>($arm), &single);
            torques(&mut list, concat!($arm, "_exact_f32"), k::$exact_f32::Kernel, &single);
            torques(&mut list, concat!($arm, "_regrouped_f32"), k::$regrouped_f32::Kernel, &single);
            list.push(batch(concat!($arm, "_batch_f64"), k::$any::Kernel, &double));
            list.push(batch(concat!($arm, "_batch_f32"), k::$any::Kernel, &single));
            list.push(each(concat!($arm, "_forward_dynamics_f64"), &double, |i| {
                // The torques are arbitrary: no branch depends on them.
                k::$forward::forward_dynamics(&i.turn, $(&i.$argument,)* &i.qd, &i.qdd)
            }));
            list.push(each(concat!($arm, "_gravity_f64"), &double, |i| {
                k::$gravity::gravity(&i.turn $(, &i.$argument)*)
            }));
            list.push(each(concat!($arm, "_mass_matrix_f64"), &double, |i| {
                k::$mass_matrix::mass_matrix(&i.turn $(, &i.$argument)*)
            }));
        };
    }
    arm!("ur5": ur5_inverse_dynamics_exact_f64 ur5_inverse_dynamics_regrouped_f64 ur5_inverse_dynamics_exact_f32
        ur5_inverse_dynamics_regrouped_f32 ur5_inverse_dynamics_regrouped_any ur5_forward_dynamics_regrouped_f64 ur5_gravity_regrouped_f64 ur5_mass_matrix_regrouped_f64);
    arm!("puma560": puma560_inverse_dynamics_exact_f64 puma560_inverse_dynamics_regrouped_f64
        puma560_inverse_dynamics_exact_f32 puma560_inverse_dynamics_regrouped_f32 puma560_inverse_dynamics_regrouped_any puma560_forward_dynamics_regrouped_f64 puma560_gravity_regrouped_f64
        puma560_mass_matrix_regrouped_f64);
    arm!("stanford": stanford_inverse_dynamics_exact_f64 stanford_inverse_dynamics_regrouped_f64
        stanford_inverse_dynamics_exact_f32 stanford_inverse_dynamics_regrouped_f32 stanford_inverse_dynamics_regrouped_any stanford_forward_dynamics_regrouped_f64 stanford_gravity_regrouped_f64
        stanford_mass_matrix_regrouped_f64 q);
    list
}

/// The recursion with an arm that is read at run time.
fn generic<S: Real>(arm: &str) -> Dynamics<S, 6> {
    let file = plain::scene(arm).unwrap();
    let model = file.robot.model::<6>().unwrap();
    black_box(Dynamics::new(model.cast(), file.scene(&model).cast()))
}

/// Adds inverse dynamics with given sine and cosine, with this project's own, and with libm's.
fn torques<S: Real, D: InverseDynamics<S, 6> + Copy + 'static>(list: &mut Vec<Work>, name: &str, d: D, inputs: &All<S>)
where
    Polynomial: Trig<S>,
    Libm: Trig<S>,
{
    let live = Live::zero();
    list.push(each(name, inputs, move |i| d.inverse_dynamics(&i.turn, &i.q, &i.qd, &i.qdd, &live)));
    list.push(each(&format!("{name}_with_trig"), inputs, move |i| {
        d.inverse_dynamics(&Polynomial.sin_cos_all(&i.q), &i.q, &i.qd, &i.qdd, &live)
    }));
    list.push(each(&format!("{name}_with_libm"), inputs, move |i| {
        d.inverse_dynamics(&Libm.sin_cos_all(&i.q), &i.q, &i.qd, &i.qdd, &live)
    }));
}

/// Inverse dynamics of all states in lanes, with this project's sine and cosine, on one core.
fn batch<F: Float, D: InverseDynamics<F::Lanes, 6> + 'static>(name: &str, d: D, inputs: &All<F>) -> Work
where
    Polynomial: Trig<F>,
{
    let list = |of: fn(&Inputs<F>) -> [F; 6]| -> [Vec<F>; 6] {
        std::array::from_fn(|joint| inputs.iter().map(|i| of(i)[joint]).collect())
    };
    let (q, qd, qdd) = (list(|i| i.q), list(|i| i.qd), list(|i| i.qdd));
    let tau = RefCell::new(list(|i| i.q));
    let live = Live::zero();
    let run = move |count: usize| {
        let states = dynamics_batch::States::new(first(&q, count), first(&qd, count), first(&qdd, count)).unwrap();
        let mut tau = tau.borrow_mut();
        let out = tau.each_mut().map(|one| &mut one[..count]);
        inverse_dynamics_batch(&d, &Polynomial, black_box(&states), &live, out).unwrap();
        black_box(&mut *tau);
    };
    Work { name: name.to_owned(), run: Box::new(run) }
}

fn first<F>(all: &[Vec<F>; 6], count: usize) -> [&[F]; 6] {
    all.each_ref().map(|one| &one[..count])
}

fn trig<S: Real, T: Trig<S> + 'static>(name: &str, trig: T, inputs: &All<S>) -> Work {
    each(name, inputs, move |i| trig.sin_cos_all(&i.q))
}

fn each<S: Real, R>(name: &str, inputs: &All<S>, f: impl Fn(&Inputs<S>) -> R + 'static) -> Work {
    let inputs = Rc::clone(inputs);
    let run = move |count: usize| {
        for state in inputs.iter().cycle().take(count) {
            black_box(f(black_box(state)));
        }
    };
    Work { name: name.to_owned(), run: Box::new(run) }
}
