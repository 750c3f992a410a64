#if DBL_MANT_DIG != 53
#error "double is not the 64-bit type of IEEE 754"
#endif
/* A negative size here: the compiler reads literals in single precision (-fsingle-precision-constant). */
typedef char arm_literals_are_double[(int)16777217.0 == 16777217 ? 1 : -1];
