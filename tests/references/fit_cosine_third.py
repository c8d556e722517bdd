#!/usr/bin/env python3
"""Polynomial for g(u) = cos(acos(u) / 3) on [0, 1], the only "transcendental" of the 3x3 eigen-solver.

Run: python3 fit_cosine_third.py     (needs mpmath)
Prints, for each degree, the coefficients from the constant upwards, rounded to f32, and the largest error
of Horner's rule in f32 against mpmath, then the coefficients of 4/sqrt(6) g(54^0.5 u), which is what the core evaluates, with
degree 3: Newton's step squares the error.
"""

import struct

import mpmath as mp

mp.mp.dps = 40


def f32(x):
    """Round to the nearest single-precision number."""
    return struct.unpack("f", struct.pack("f", float(x)))[0]


def exact(u):
    return mp.cos(mp.acos(mp.mpf(u)) / 3)


def horner_f32(coefficients, u):
    total = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = f32(f32(total * u) + c)
    return total


for degree in range(3, 8):
    descending, bound = mp.chebyfit(exact, [0, 1], degree + 1, error=True)
    coefficients = [f32(c) for c in reversed(descending)]
    worst = max(abs(horner_f32(coefficients, f32(k / 4000)) - exact(f32(k / 4000))) for k in range(4001))
    print(f"degree {degree}: fit {float(bound):.2e}, in f32 {float(worst):.2e}")
    print("   ", ", ".join(f"{c:.9}" for c in coefficients))
    scaled = [f32(c * 4 / mp.sqrt(6) * mp.sqrt(54) ** k) for k, c in enumerate(reversed(descending))]
    print("    scaled:", ", ".join(f"{c:.9}" for c in scaled))
