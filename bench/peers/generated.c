/* A contestant around generated C, which is included so that the compiler sees through the call.
 *
 *   SOURCE            the file, quoted
 *   ENTRY             the contestant's name
 *   CASADI or CPPADCG whose convention it has
 *   KERNEL            cosines and sines are inputs (else angles)
 *   FORWARD           accelerations from torques (else torques from accelerations)
 *   MANY              leave the loop over the states open, for the compiler to put several states into one vector; else it
 *                     must do one after the other, as a controller does
 */
#define REAL double
#include "contestant.h"
#include "generated.h"
#include SOURCE

#ifdef MANY
#define ONE_BY_ONE
#else
#define ONE_BY_ONE __asm__ volatile("" : : : "memory")
#endif

#ifdef KERNEL
#define POSITIONS (2 * JOINTS)
#define POSITION turn
#define ROWS kernel_rows
#else
#define POSITIONS JOINTS
#define POSITION q
#define ROWS inverse_rows
#endif

#ifdef FORWARD
#undef ROWS
#define ROWS forward_rows
#define THIRD tau
#else
#define THIRD qdd
#endif

CONTESTANT(ENTRY) {
    for (int i = 0; i < STATES; ++i) {
        ONE_BY_ONE;
        double *answer = out + i * JOINTS;
#ifdef CASADI
        const double *arguments[] = {states->POSITION + i * POSITIONS, states->qd + i * JOINTS, states->THIRD + i * JOINTS};
        /* The generated code asks of every input whether it is there: say that they all are. */
        if (!arguments[0] || !arguments[1] || !arguments[2] || !answer)
            __builtin_unreachable();
        generated(arguments, &answer, 0, 0, 0);
#else
        const double *row = states->ROWS + i * (POSITIONS + 2 * JOINTS);
        struct LangCAtomicFun none = {0};
        generated(&row, &answer, none);
#endif
    }
}
