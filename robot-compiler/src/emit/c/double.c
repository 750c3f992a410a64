/* Bits of a number. */
static inline uint64_t PREFIX_bits(double x)
{
    union { double number; uint64_t bits; } both;
    both.number = x;
    return both.bits;
}

static inline double PREFIX_number(uint64_t x)
{
    union { double number; uint64_t bits; } both;
    both.bits = x;
    return both.number;
}

PREFIX_sin_cos_t PREFIX_sin_cos(double angle)
{
    /* Of the magnitude: the sign of the angle is that of the sine. */
    const uint64_t sign = PREFIX_bits(angle) & ((uint64_t)1 << 63);
    const double x = PREFIX_number(PREFIX_bits(angle) ^ sign);
    /* Zero up to 2^20 rad; NaN beyond it, for an infinity and for NaN. */
    const double within = x * OVERFLOW * 0.0;
    /* The nearest multiple of a quarter turn: as a number, and in the low bits. */
    const double shifted = x * 0.6366197723675814 + (6755399441055744.0 + within);
    const double k = shifted - 6755399441055744.0;
    const uint64_t turns = PREFIX_bits(shifted);
    /* The rest, by parts of pi/2 with so few bits that the first products are exact. */
REDUCTION
    const double z = r * r;
POLYNOMIALS
    /* An odd quarter turn swaps both, and bit 1 changes both signs. */
    const uint64_t s = PREFIX_bits(sine);
    const uint64_t c = PREFIX_bits(cosine);
    const uint64_t change = ((s ^ c) & ((uint64_t)0 - (turns & 1u))) ^ ((turns & 2u) << 62);
    PREFIX_sin_cos_t result;
    result.sin = PREFIX_number(s ^ change ^ sign);
    result.cos = PREFIX_number(c ^ change ^ (turns << 63));
    return result;
}
