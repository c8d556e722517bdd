#!/usr/bin/env python3
"""Upper quantiles of the normal, chi-square and F distributions, computed by mpmath, independent of this project's code.

Run: python3 quantiles.py > quantiles.json     (needs mpmath; a minute or two)

Each tail probability is first rounded to single precision, so that every program reads the same number. A quantile is the
root of tail(x) = p by bisection of ln x; the tails are mpmath's erfc, incomplete gamma and incomplete beta at 30 digits.
Rows: [p, quantile], [p, degrees of freedom, quantile], [p, numerator's, denominator's degrees of freedom, quantile].
"""

import json
import struct

import mpmath as mp

mp.mp.dps = 30

PROBABILITIES = [0.1, 0.05, 0.03, 0.01, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12]
CHI_SQUARE = [1, 1.5, 2, 2.7, 3, 4, 5.3, 8, 10, 17.5, 30, 44.4, 50]
NUMERATOR = [1, 2, 3, 5.5, 12, 50]
DENOMINATOR = [10, 11.5, 20, 57, 300, 4000, 14997, 1e6, 1e9]


def f32(x):
    """Round to the nearest single-precision number."""
    return struct.unpack("f", struct.pack("f", float(x)))[0]


def root(tail, p):
    """The x with tail(x) = p, for a falling tail."""
    low, high = mp.mpf(-3), mp.mpf(9)  # of ln x
    for _ in range(64):
        middle = (low + high) / 2
        low, high = (middle, high) if tail(mp.exp(middle)) > p else (low, middle)
    return float(mp.exp((low + high) / 2))


def normal(p):
    return root(lambda z: mp.erfc(z / mp.sqrt(2)) / 2, p)


def chi_square(p, degrees):
    return root(lambda x: mp.gammainc(mp.mpf(degrees) / 2, x / 2, regularized=True), p)


def f(p, numerator, denominator):
    a, b = mp.mpf(denominator) / 2, mp.mpf(numerator) / 2
    return root(lambda x: mp.betainc(a, b, 0, a / (a + b * x), regularized=True), p)


if __name__ == "__main__":
    probabilities = [f32(p) for p in PROBABILITIES]
    # Degrees of freedom as single precision holds them.
    chi, over, under = ([f32(d) for d in degrees] for degrees in (CHI_SQUARE, NUMERATOR, DENOMINATOR))
    goldens = {
        "normal": [[p, normal(p)] for p in probabilities],
        "chi_square": [[p, d, chi_square(p, d)] for d in chi for p in probabilities],
        "f": [[p, n, d, f(p, n, d)] for n in over for d in under for p in probabilities],
    }
    print(json.dumps(goldens))
