/* What every contestant on the chip is: one C function of one state. */
#ifndef CHIP_H
#define CHIP_H

#define JOINTS 6
#define STATES 64

struct state {
    float q[JOINTS], qd[JOINTS], qdd[JOINTS];
    /* cosine and sine of each joint, in turn: for contestants that are measured without trigonometry; and once more what
     * follows the angles, because CppADCodeGen wants one array */
    float turn[2 * JOINTS], qd_again[JOINTS], qdd_again[JOINTS];
};

typedef void contestant(struct state *state, float *torques);

/* Of the project's library: the states that everybody is measured in, and cosine and sine of all joints in turn. */
void bench_chip_states(struct state *states);
void our_trig(const float *angles, float *turn);

#endif
