/* What every contestant on the desk is: one C function over all states. */
#ifndef CONTESTANT_H
#define CONTESTANT_H

#define JOINTS 6
#define STATES 1024

/* All states, state by state and, for batches, joint by joint ([joint * STATES + state]). */
struct states {
    const double *q, *qd, *qdd, *tau;
    /* cosine and sine of each joint, in turn: for contestants that are measured without trigonometry */
    const double *turn;
    /* The same in one row a state, as CppADCodeGen wants it: q, qd, qdd; turn, qd, qdd; q, qd, tau. */
    const double *inverse_rows, *kernel_rows, *forward_rows;
    const double *q_by_joint, *qd_by_joint, *qdd_by_joint;
};

/* Torques, or accelerations, of all states; by state or, for batches, by joint. */
typedef void contestant(const struct states *states, double *out);

#ifdef __cplusplus
#define EXPORT extern "C" __attribute__((visibility("default")))
#else
#define EXPORT __attribute__((visibility("default")))
#endif
/* All else is hidden, so that compilers may inline across functions in a shared library. */
#define CONTESTANT(name) EXPORT void name(const struct states *states, double *out)

#endif
