/* As generated.c, for the chip: single precision, one state a call.
 *
 *   SOURCE, ENTRY, CASADI or CPPADCG, KERNEL    as there
 *   OUR_TRIG                                    with KERNEL: cosines and sines from the project's polynomials, counted
 */
#define REAL float
#include "chip.h"
#include "generated.h"
#define sin sinf
#define cos cosf
#include SOURCE

void ENTRY(struct state *state, float *torques) {
#ifdef OUR_TRIG
    our_trig(state->q, state->turn);
#endif
#ifdef KERNEL
    const float *q = state->turn;
#else
    const float *q = state->q;
#endif
#ifdef CASADI
    /* The generated code asks of every input whether it is there: say that they all are. */
    if (!state || !torques)
        __builtin_unreachable();
    const float *arguments[] = {q, state->qd, state->qdd};
    generated(arguments, &torques, 0, 0, 0);
#else
    /* What it wants lies behind the angles or their cosines and sines. */
    struct LangCAtomicFun none = {0};
    generated(&q, &torques, none);
#endif
}
