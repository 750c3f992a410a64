/* The results are those of IEEE 754 operations, each rounded on its own. These lines keep the compiler from changing them. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__) || \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ != 0)
#error "-ffast-math and its parts change the results; compile this file without them"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error "this processor computes with more digits than its types have (x87); compile with -msse2 -mfpmath=sse"
#endif
#if defined(__ARM_FEATURE_MVE) && (__ARM_FEATURE_MVE & 2) != 0
#error "vector operations of this processor flush small numbers to zero; compile with -mcpu=cortex-m55+nomve.fp"
#endif
#include <float.h>
#if FLT_RADIX != 2 || FLT_MANT_DIG != 24
#error "float is not the 32-bit type of IEEE 754"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
/* The statements already stand in an order that keeps few values alive; another one moves more of them to the stack. */
#pragma GCC optimize("no-tree-ter", "no-schedule-insns")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#else
#pragma STDC FP_CONTRACT OFF
#endif
