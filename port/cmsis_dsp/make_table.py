#!/usr/bin/env python3
"""Prints the constants of rigcal_tables.c: a table of sines and a sixty-fourth of a
turn in parts, each a float, of which the first two have 10 bits."""
import math
import struct
from fractions import Fraction

PER_TURN = 64
PI = Fraction("3.14159265358979323846264338327950288")


def to_float(x):
    """The float nearest to x."""
    return struct.unpack("f", struct.pack("f", x))[0]


def with_bits(x, bits):
    """The first bits of x > 0, the others cut off."""
    exponent = math.frexp(float(x))[1]
    unit = Fraction(2) ** (exponent - bits)
    return x // unit * unit


def literal(x):
    return f"{to_float(float(x)):.9g}" if x else "0"


def sine(k):
    """The sine of k parts of a turn; exactly 0, 1 or -1 where that is the value."""
    quarter = PER_TURN // 4
    if k % quarter == 0:
        return (0, 1, 0, -1)[k // quarter % 4]
    return math.sin(2 * math.pi * k / PER_TURN)


def main():
    step = 2 * PI / PER_TURN
    first = with_bits(step, 10)
    second = with_bits(step - first, 10)
    third = to_float(float(step - first - second))
    print(f"#define STEPS_A_RADIAN {literal(1 / step)}f")
    for name, value in (("FIRST", first), ("SECOND", second), ("THIRD", third)):
        print(f"#define STEP_{name} {literal(value)}f")
    print()
    values = [literal(sine(k)) for k in range(PER_TURN + PER_TURN // 4)]
    values = [v + ("f" if "." in v or "e" in v else "") for v in values]
    for i in range(0, len(values), 5):
        print("    " + ", ".join(values[i:i + 5]) + ",")


if __name__ == "__main__":
    main()
