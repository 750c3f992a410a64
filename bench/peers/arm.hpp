// An arm as arm.py prints it, and as a Pinocchio model of any scalar.
#pragma once

#include "contestant.h"
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

struct Joint {
    double rotation[9], origin[3];
    double mass, centre[3], inertia[6];
};

using Arm = std::array<Joint, JOINTS>;

inline Arm read_arm(const char *path) {
    std::ifstream file(path);
    Arm arm;
    for (Joint &joint : arm)
        for (double &number : *reinterpret_cast<std::array<double, sizeof(Joint) / sizeof(double)> *>(&joint))
            if (!(file >> number)) {
                std::fprintf(stderr, "%s: not an arm of %d joints\n", path, JOINTS);
                std::exit(1);
            }
    return arm;
}

// The arm of a contestant that has its model at run time.
inline Arm arm_of_this_run() {
    const char *path = std::getenv("PEERS_ARM");
    if (!path) {
        std::fprintf(stderr, "PEERS_ARM is not set\n");
        std::exit(1);
    }
    return read_arm(path);
}

#ifdef PINOCCHIO_ARM
#include <pinocchio/multibody.hpp>

// The joints that are measured, and no others: Pinocchio compiles an algorithm for each joint of its collection, and its
// own collection takes minutes. A shorter one can only make it faster.
template <class Scalar, int options>
struct Joints {
    using JointModelRZ = pinocchio::JointModelRevoluteTpl<Scalar, options, 2>;
    using JointDataRZ = pinocchio::JointDataRevoluteTpl<Scalar, options, 2>;
    using JointModelRUBZ = pinocchio::JointModelRevoluteUnboundedTpl<Scalar, options, 2>;
    using JointDataRUBZ = pinocchio::JointDataRevoluteUnboundedTpl<Scalar, options, 2>;
    using JointModelVariant = boost::variant<JointModelRZ, JointModelRUBZ>;
    using JointDataVariant = boost::variant<JointDataRZ, JointDataRUBZ>;
};

using PinocchioModel = pinocchio::ModelTpl<double, 0, Joints>;
// Takes an angle.
using Angle = Joints<double, 0>::JointModelRZ;
// Takes its cosine and sine.
using CosineAndSine = Joints<double, 0>::JointModelRUBZ;

template <class Axis>
PinocchioModel pinocchio_arm(const Arm &arm) {
    PinocchioModel model;
    model.gravity.linear(Eigen::Vector3d(0, 0, -9.81));
    pinocchio::JointIndex parent = 0;
    for (int i = 0; i < JOINTS; ++i) {
        const Joint &joint = arm[i];
        Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(joint.rotation);
        Eigen::Vector3d origin(joint.origin), centre(joint.centre);
        const double *t = joint.inertia;
        Eigen::Matrix3d tensor;
        tensor << t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5];
        parent = model.addJoint(parent, Axis(), pinocchio::SE3(rotation, origin), "joint" + std::to_string(i));
        model.appendBodyToJoint(parent, pinocchio::Inertia(joint.mass, centre, tensor), pinocchio::SE3::Identity());
    }
    return model;
}
#endif
