#!/usr/bin/env python3
"""Goldens of the paper's chain, computed by numpy and scipy, independent of this project's code.

Run: python3 goldens.py > chain.json     (needs numpy and scipy)

A window of three correlated channels is made of integers, so that every program reads the same f32 numbers; behind
it follows a shorter stretch with a shift in one channel. For the window: mean, sigma, correlation, eigenvalues,
loadings, explained variance and retained count, for the full model and the three pairs. For the stretch: T2 (1.6)
of every sample, and the same through a Butterworth low-pass that starts at rest at 1.
"""

import json

import numpy as np
from scipy import signal

WINDOW, STRETCH, SHIFT_AT = 600, 120, 40
CUTOFF = 0.02  # of the sampling rate


def samples():
    """Three channels from a linear congruential generator (Knuth's MMIX), in steps that f32 holds exactly."""
    state = 1
    rows = []
    for k in range(WINDOW + STRETCH):
        draws = []
        for _ in range(4):
            state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
            draws.append((state >> 33) % 257 - 128)
        common = draws[3]
        shift = 300 if k >= WINDOW + SHIFT_AT else 0
        rows.append([76800 + draws[0] + common, 512 + draws[1] - common, 2560 + draws[2] + 2 * common + shift])
    return np.array(rows, dtype=np.float64) / 256.0


def model(x, channels):
    z = x[:WINDOW, channels]
    mean, sigma = z.mean(axis=0), z.std(axis=0, ddof=1)
    z = (z - mean) / sigma
    correlation = np.corrcoef(z.T)
    values, vectors = np.linalg.eigh(correlation)
    values, vectors = values[::-1], vectors[:, ::-1]
    for k in range(vectors.shape[1]):
        if vectors[np.argmax(np.abs(vectors[:, k])), k] < 0:
            vectors[:, k] *= -1
    share = np.cumsum(values) / values.sum()
    retained = int(np.searchsorted(share, 0.80) + 1)
    i, r = WINDOW, retained
    scale = i * (i - r) / (r * (i * i - 1.0))
    stretch = (x[WINDOW:, channels] - mean) / sigma
    scores = stretch @ vectors[:, :retained]
    t2 = (scores**2 / values[:retained]).sum(axis=1) * scale
    sos = signal.butter(2, 2 * CUTOFF, output="sos")
    rest = signal.sosfilt_zi(sos)
    smoothed, _ = signal.sosfilt(sos, t2, zi=rest * 1.0)
    return {
        "mean": mean.tolist(),
        "sigma": sigma.tolist(),
        "correlation": correlation.tolist(),
        "eigenvalues": values.tolist(),
        "loadings": vectors.T.tolist(),
        "explained": (values / values.sum()).tolist(),
        "retained": retained,
        "t2": t2.tolist(),
        "smoothed": smoothed.tolist(),
    }


if __name__ == "__main__":
    x = samples()
    goldens = {
        "window": WINDOW,
        "cutoff": CUTOFF,
        "samples": x.tolist(),
        "full": model(x, [0, 1, 2]),
        "speed_current": model(x, [0, 1]),
        "current_voltage": model(x, [1, 2]),
        "speed_voltage": model(x, [0, 2]),
    }
    print(json.dumps(goldens))
