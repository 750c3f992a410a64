int PREFIX_conditions(void)
{
    /* Volatile: computed when it is called, by the compiled operations. */
    static const volatile REAL numbers[7] = {ONE_AND_A_BIT, ITS_SQUARE, SMALLEST, HALF, ONE, ABOVE_HALF_A_STEP, BELOW_HALF_A_STEP};
    const REAL a = numbers[0], square = numbers[1], smallest = numbers[2], half = numbers[3], one = numbers[4];
    const REAL above = numbers[5], below = numbers[6];
    int broken = 0;
    /* The square rounds to this number; an operation that is fused does not round it. */
    if (a * a - square != ZERO) {
        broken += 1;
    }
    const REAL subnormal = smallest * half;
    if (subnormal + subnormal != smallest) {
        broken += 2;
    }
    const REAL up = one + above, down = -one - above;
    if (!(up > one) || !(down < -one) || one + below != one || -one - below != -one) {
        broken += 4;
    }
    return broken;
}
