#!/usr/bin/env python3
"""Polynomial q for tan(pi x) = x q(x^2) on [0, 1/4], with which the core designs its low-pass filters.

Run: python3 fit_tangent.py     (needs mpmath)
Prints, for each degree of q, the coefficients from the constant upwards, rounded to f32, and the largest relative error
of Horner's rule in f32 against mpmath. The core uses degree 6; beyond 1/4 it takes 1 / tan(pi (1/2 - x)).
"""

import struct

import mpmath as mp

mp.mp.dps = 40


def f32(x):
    """Round to the nearest single-precision number."""
    return struct.unpack("f", struct.pack("f", float(x)))[0]


def exact(w):
    x = mp.sqrt(mp.mpf(w))
    return mp.pi if x == 0 else mp.tan(mp.pi * x) / x


def horner_f32(coefficients, w):
    total = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = f32(f32(total * w) + c)
    return total


for degree in range(4, 9):
    descending, bound = mp.chebyfit(exact, [0, mp.mpf(1) / 16], degree + 1, error=True)
    coefficients = [f32(c) for c in reversed(descending)]
    worst = 0
    for k in range(1, 4001):
        x = f32(k / 16000)
        w = f32(x * x)
        tangent = f32(x * horner_f32(coefficients, w))
        true = mp.tan(mp.pi * mp.mpf(x))
        worst = max(worst, abs(tangent / true - 1))
    print(f"degree {degree}: fit {float(bound):.2e}, in f32 {float(worst):.2e} relative")
    print("   ", ", ".join(f"{c:.9}" for c in coefficients))
