/* What generated C is called by, declared before its text so that it becomes part of the contestant: no call is left that
 * others do not have. */
#include <math.h>
#include <string.h>

#ifdef CASADI
#define CASADI_SYMBOL_EXPORT static
static inline __attribute__((always_inline)) int generated(const REAL **arguments, REAL **results, long long int *integers,
                                                           REAL *numbers, int memory);
#else
struct LangCAtomicFun;
static inline __attribute__((always_inline)) void generated(REAL const *const *in, REAL *const *out,
                                                            struct LangCAtomicFun none);
#endif
