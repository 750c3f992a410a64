/* Bits of a number. */
static inline uint32_t PREFIX_bits(float x)
{
    union { float number; uint32_t bits; } both;
    both.number = x;
    return both.bits;
}

static inline float PREFIX_number(uint32_t x)
{
    union { float number; uint32_t bits; } both;
    both.bits = x;
    return both.number;
}

PREFIX_sin_cos_t PREFIX_sin_cos(float angle)
{
    /* Zero up to 8192 rad; NaN beyond it, for an infinity and for NaN. */
    const float within = angle * OVERFLOW * 0.0f;
    /* The nearest multiple of a quarter turn: as a number, and in the low bits. */
    const float shifted = angle * 0.63661975f + (12582912.0f + within);
    const float k = shifted - 12582912.0f;
    const uint32_t turns = PREFIX_bits(shifted);
    /* The rest, by parts of pi/2 with so few bits that the first products are exact. */
REDUCTION
    const float z = r * r;
POLYNOMIALS
    /* An odd quarter turn swaps both, and bit 1 changes both signs. */
    const uint32_t s = PREFIX_bits(sine);
    const uint32_t c = PREFIX_bits(cosine);
    const uint32_t change = ((s ^ c) & (0u - (turns & 1u))) ^ ((turns & 2u) << 30);
    PREFIX_sin_cos_t result;
    result.sin = PREFIX_number(s ^ change);
    result.cos = PREFIX_number(c ^ change ^ (turns << 31));
    return result;
}
