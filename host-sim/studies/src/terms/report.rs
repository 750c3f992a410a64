//! Tables of the terms.

use super::Terms;
use comfy_table::Table;
use robot_compiler::Robot;
use sim::run::joint_label::JointLabel;
use sim::table::table;

/// Tables of the terms.
#[must_use]
pub fn describe(terms: &Terms, robot: &Robot) -> String {
    let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
    let mut state = table(["joint", "q", "qd", "H = C qd", "G"], 1);
    for (i, joint) in robot.joints.iter().enumerate() {
        let label = JointLabel::from(joint);
        state.add_row([
            label.name.clone(),
            format!("{} {}", decimal(terms.q[i]), label.position_unit()),
            format!("{} {}", decimal(terms.qd[i]), label.velocity_unit()),
            format!("{} {}", decimal(terms.velocity_coupling[i]), label.torque_unit()),
            format!("{} {}", decimal(terms.gravity[i]), label.torque_unit()),
        ]);
    }
    let [gx, gy, gz] = terms.g;
    let mut text = format!("{}, by the method {}; g = ({gx}, {gy}, {gz}) m/s^2\n", terms.robot, terms.method);
    text += &format!("{state}\n\nInertia matrix D:\n{}\n", square(&names, &terms.mass_matrix));
    text += &format!("\nC, with dD/dt - 2 C skew-symmetric:\n{}\n", square(&names, &terms.coriolis_matrix));
    for (i, symbols) in terms.christoffel.iter().enumerate() {
        text += &format!(
            "\nChristoffel symbols of joint {} ({}), rows j and columns k:\n{}\n",
            i + 1,
            names[i],
            square(&names, symbols)
        );
    }
    text
}

fn square(names: &[&str], rows: &[Vec<f64>]) -> Table {
    let header: Vec<&str> = std::iter::once("").chain(names.iter().copied()).collect();
    let mut table = table(header, 1);
    for (name, row) in names.iter().zip(rows) {
        table.add_row(std::iter::once((*name).to_owned()).chain(row.iter().map(|x| decimal(*x))));
    }
    table
}

/// Number with six decimals; a value that rounds to zero has no sign.
fn decimal(x: f64) -> String {
    let text = format!("{x:.6}");
    if text == "-0.000000" { "0.000000".to_owned() } else { text }
}
