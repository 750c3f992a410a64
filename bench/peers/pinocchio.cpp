// Pinocchio's own algorithms, the model at run time.
#define PINOCCHIO_ARM
#include "arm.hpp"
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using Vector = Eigen::Map<const Eigen::Matrix<double, JOINTS, 1>>;

static PinocchioModel model = pinocchio_arm<Angle>(arm_of_this_run());
static PinocchioModel::Data data(model);

static void put(const Eigen::VectorXd &answer, double *out) {
    Eigen::Map<Eigen::Matrix<double, JOINTS, 1>>(out, JOINTS) = answer;
}

CONTESTANT(inverse) {
    for (int i = 0; i < STATES * JOINTS; i += JOINTS)
        put(pinocchio::rnea(model, data, Vector(states->q + i), Vector(states->qd + i), Vector(states->qdd + i)), out + i);
}

CONTESTANT(forward) {
    for (int i = 0; i < STATES * JOINTS; i += JOINTS)
        put(pinocchio::aba(model, data, Vector(states->q + i), Vector(states->qd + i), Vector(states->tau + i),
                           pinocchio::Convention::LOCAL),
            out + i);
}

CONTESTANT(forward_world) {
    for (int i = 0; i < STATES * JOINTS; i += JOINTS)
        put(pinocchio::aba(model, data, Vector(states->q + i), Vector(states->qd + i), Vector(states->tau + i),
                           pinocchio::Convention::WORLD),
            out + i);
}
