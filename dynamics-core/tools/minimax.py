#!/usr/bin/env python3
"""Constants and reference values for `dynamics-core/src/trig`.

    python3 minimax.py constants   the parts of pi/2 and the polynomial coefficients, with their approximation errors
    python3 minimax.py reference   the table that `tests/trig.rs` compares with (`tests/trig_reference.txt`)

Needs mpmath (`pip install mpmath`). Deterministic: the same output every time.

The polynomials, with z = r^2 and |r| <= pi/4 + margin:

    sin r = r + r z S(z)            S is fitted to (sin r / r - 1) / z
    cos r = 1 - z/2 + z^2 C(z)      C is fitted to (cos r - 1 + z/2) / z^2

each with the weight that makes the relative error of the sine or cosine the least. The short ones (`Polynomial5`, `Polynomial3`), fitted
for the least absolute error instead:

    sin r = r S(z)                  S is fitted to sin r / r
    cos r = 1 + z C(z)              C is fitted to (cos r - 1) / z

Each fit is a Remez exchange. A fitted coefficient is not a float; rounding all of them at once would spoil the fit, so
they are rounded one at a time, the lowest order (the one that weighs most) first, and the rest are fitted again.
"""
import random
import struct
import sys

from mpmath import mp, mpf, cos, floor, log, lu_solve, matrix, pi, sin, sqrt

mp.dps = 60

# The reduced argument passes pi/4 by the rounding of x * (2/pi): 5e-4 at |x| = 8192 in f32, far less in f64.
MARGIN = mpf(1) / 1024
LARGEST_Z = (pi / 4 + MARGIN) ** 2


# ---------------------------------------------------------------- floats

def to_f32(x):
    """The nearest f32. Rounds twice (through f64), which a script can afford: the tests measure the result."""
    return mpf(struct.unpack("<f", struct.pack("<f", float(x)))[0])


def to_f64(x):
    return mpf(float(x))


def shortest_f32(x):
    """The shortest decimal that reads back as this f32."""
    for digits in range(1, 12):
        text = f"{float(x):.{digits}e}"
        if to_f32(mpf(text)) == x:
            return text
    raise ValueError(x)


def shortest_f64(x):
    return repr(float(x))


# ---------------------------------------------------------------- Remez exchange

def sine_target(z):
    r = sqrt(z)
    return (sin(r) / r - 1) / z


def sine_weight(z):
    r = sqrt(z)
    return z * r / sin(r)


def cosine_target(z):
    return (cos(sqrt(z)) - 1 + z / 2) / z**2


def cosine_weight(z):
    return z**2 / cos(sqrt(z))


def short_sine_target(z):
    r = sqrt(z)
    return sin(r) / r


def short_sine_weight(z):
    return sqrt(z)


def short_cosine_target(z):
    return (cos(sqrt(z)) - 1) / z


def short_cosine_weight(z):
    return z


def evaluate(coefficients, z):
    value = mpf(0)
    for c in reversed(coefficients):
        value = value * z + c
    return value


def remez(target, weight, fixed, count):
    """`count` coefficients that follow the `fixed` ones, with the least largest weighted error; and that error."""
    low = len(fixed)

    def residual(z):
        return target(z) - evaluate(fixed, z)

    grid = [LARGEST_Z * mpf(i) / 600 for i in range(1, 601)]
    # Chebyshev points, kept off zero, where the weight vanishes.
    nodes = [LARGEST_Z * (1 - cos(pi * (i + 1) / (count + 1))) / 2 for i in range(count + 1)]
    free = []
    for _ in range(25):
        rows = matrix(count + 1, count + 1)
        right = matrix(count + 1, 1)
        for i, z in enumerate(nodes):
            for j in range(count):
                rows[i, j] = z ** (low + j)
            rows[i, count] = (-1) ** i / weight(z)
            right[i] = residual(z)
        solution = lu_solve(rows, right)
        free = [solution[j] for j in range(count)]
        all_coefficients = fixed + free
        errors = [weight(z) * (target(z) - evaluate(all_coefficients, z)) for z in grid]
        nodes = alternation(grid, errors, count + 1) or nodes
        largest = max(abs(e) for e in errors)
        if largest - abs(solution[count]) < mpf("1e-3") * largest:
            break
    return free, largest


def alternation(grid, errors, wanted):
    """The largest error of each run of equal sign; None if there are too few runs."""
    peaks = []
    for z, e in zip(grid, errors):
        if peaks and (peaks[-1][1] > 0) == (e > 0):
            if abs(e) > abs(peaks[-1][1]):
                peaks[-1] = (z, e)
        else:
            peaks.append((z, e))
    while len(peaks) > wanted:
        peaks.pop(0 if abs(peaks[0][1]) < abs(peaks[-1][1]) else -1)
    return [z for z, _ in peaks] if len(peaks) == wanted else None


def fit_rounded(target, weight, count, to_float):
    fixed = []
    for left in range(count, 0, -1):
        free, _ = remez(target, weight, fixed, left)
        fixed.append(to_float(free[0]))
    grid = [LARGEST_Z * mpf(i) / 2000 for i in range(1, 2001)]
    error = max(abs(weight(z) * (target(z) - evaluate(fixed, z))) for z in grid)
    return fixed, error


# ---------------------------------------------------------------- pi/2 in parts

def parts_of_half_pi(lowest_bits, to_float):
    """pi/2 as a sum: each part but the last is cut off below 2^-bits, so its products with small integers are exact."""
    rest, parts = pi / 2, []
    for bits in lowest_bits:
        part = floor(rest * mpf(2) ** bits) / mpf(2) ** bits
        parts.append(part)
        rest -= part
    parts.append(to_float(rest))
    return parts, abs(pi / 2 - sum(parts))


def print_constants():
    cases = [
        # f32: |x| <= 2^13, k < 2^13: parts of 11 bits at most.
        ("f32", to_f32, shortest_f32, [10, 22], 3, 3),
        # f64: |x| <= 2^20, k < 2^20: parts of 33 bits at most.
        ("f64", to_f64, shortest_f64, [32, 53, 86], 6, 6),
    ]
    for name, to_float, shortest, lowest_bits, sine_count, cosine_count in cases:
        print(f"{name}\n  2/pi  {shortest(to_float(2 / pi))}")
        parts, error = parts_of_half_pi(lowest_bits, to_float)
        for i, part in enumerate(parts):
            print(f"  pi/2 part {i + 1}  {shortest(part)}")
        print(f"  pi/2 - sum  2^{float(log(error, 2)):.1f}")
        for label, target, weight, count in (
            ("S", sine_target, sine_weight, sine_count),
            ("C", cosine_target, cosine_weight, cosine_count),
        ):
            print_fit(label, "relative", fit_rounded(target, weight, count, to_float), shortest)
    print_short_constants()


def print_short_constants():
    """In f32, whatever the angle's precision is."""
    for name, to_float, shortest, lowest_bits in [
        ("two parts, f32", to_f32, shortest_f32, [10]),
        ("two parts, f64", to_f64, shortest_f64, [32]),
    ]:
        parts, error = parts_of_half_pi(lowest_bits, to_float)
        print(name)
        for i, part in enumerate(parts):
            print(f"  pi/2 part {i + 1}  {shortest(part)}")
        print(f"  pi/2 - sum  2^{float(log(error, 2)):.1f}")
    sine = ("S", short_sine_target, short_sine_weight)
    cosine = ("C", short_cosine_target, short_cosine_weight)
    for name, fits in [("Polynomial5", [(sine, 3), (cosine, 3)]), ("Polynomial3", [(sine, 2), (cosine, 2)])]:
        print(name)
        for (label, target, weight), count in fits:
            print_fit(label, "absolute", fit_rounded(target, weight, count, to_f32), shortest_f32)


def print_fit(label, kind, fit, shortest):
    coefficients, error = fit
    for i, c in enumerate(coefficients):
        print(f"  {label}{i}  {shortest(c)}")
    print(f"  {label} {kind} error  {mp.nstr(error, 3)} = 2^{float(log(error, 2)):.1f}")


# ---------------------------------------------------------------- reference table

def reference_angles():
    """f64 angles in [-2^20, 2^20]: spread in value and in magnitude, subnormal, and about the multiples of pi/4."""
    source = random.Random(20)
    angles = [0.0, 5e-324, 2.2250738585072014e-308, 1e-300, 1e-20, 2.0**-27, 2.0**-26, 2.0**20]
    angles += [source.uniform(-7.0, 7.0) for _ in range(500)]
    angles += [source.uniform(-(2.0**20), 2.0**20) for _ in range(400)]
    angles += [source.choice((-1, 1)) * 2.0 ** source.uniform(-30, 20) for _ in range(300)]
    multiples = list(range(1, 41)) + [source.randrange(41, 2**20) for _ in range(200)]
    for k in multiples:
        nearest = float(pi / 4 * k)
        angles.append(nearest)
        angles.append(struct.unpack("<d", struct.pack("<q", struct.unpack("<q", struct.pack("<d", nearest))[0] + 1))[0])
    return angles


def print_reference():
    print("# angle, then sin and cos, each as the nearest f64 and the f64 nearest to what is left; bits in hexadecimal.")
    print("# Written by tools/minimax.py reference (mpmath, 60 digits).")
    for angle in reference_angles():
        fields = [angle]
        for function in (sin, cos):
            value = function(mpf(angle))
            high = float(value)
            fields += [high, float(value - mpf(high))]
        print(" ".join(struct.pack(">d", f).hex() for f in fields))


if __name__ == "__main__":
    commands = {"constants": print_constants, "reference": print_reference}
    if len(sys.argv) != 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]]()
