// KDL as Debian ships it, the model at run time.
#include "arm.hpp"
#include <kdl/chain.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

// KDL's joint turns at the start of its segment and the frame to the next one follows, so each placement closes the
// segment before; the first segment only places joint 1.
static KDL::Chain chain_of(const Arm &arm) {
    KDL::Chain chain;
    for (int i = 0; i <= JOINTS; ++i) {
        KDL::Frame next;
        if (i < JOINTS) {
            const double *r = arm[i].rotation, *p = arm[i].origin;
            next = KDL::Frame(KDL::Rotation(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]), KDL::Vector(p[0], p[1], p[2]));
        }
        if (i == 0) {
            chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), next));
            continue;
        }
        const Joint &joint = arm[i - 1];
        const double *t = joint.inertia, *c = joint.centre;
        // Of a segment's body KDL wants the numbers in the frame at the segment's end.
        KDL::RigidBodyInertia body(joint.mass, KDL::Vector(c[0], c[1], c[2]),
                                   KDL::RotationalInertia(t[0], t[3], t[5], t[1], t[2], t[4]));
        chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ), next, next.Inverse() * body));
    }
    return chain;
}

static KDL::Chain chain = chain_of(arm_of_this_run());
static KDL::ChainIdSolver_RNE solver(chain, KDL::Vector(0, 0, -9.81));

CONTESTANT(inverse) {
    static KDL::JntArray q(JOINTS), qd(JOINTS), qdd(JOINTS), tau(JOINTS);
    static const KDL::Wrenches none(chain.getNrOfSegments(), KDL::Wrench::Zero());
    for (int i = 0; i < STATES * JOINTS; i += JOINTS) {
        for (int j = 0; j < JOINTS; ++j)
            q(j) = states->q[i + j], qd(j) = states->qd[i + j], qdd(j) = states->qdd[i + j];
        solver.CartToJnt(q, qd, qdd, none, tau);
        for (int j = 0; j < JOINTS; ++j)
            out[i + j] = tau(j);
    }
}
