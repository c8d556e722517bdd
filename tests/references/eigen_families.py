#!/usr/bin/env python3
"""The core's 3x3 eigen-solver beside LAPACK's ssyev, over the families of matrices that break closed forms.

Run: cargo build --release -p tests --bin decompose
     python3 eigen_families.py ../../target/release/decompose [draws] > eigen_families.json     (needs numpy and scipy)

Draws `draws` matrices (default 1,000,000) of each family, rounds them to f32, and has both programs decompose them. The
reference is numpy's eigh in f64, of the same f32 matrices, scaled by a power of two where f32 is near its ends. Errors are
in eps(f32): of eigenvalues and of |A V - V L| over the Frobenius norm of A, and of |V'V - I|. A table goes to standard
error. The JSON holds, for each family, the worst of both programs and the matrices that were hardest for the core, which
a test decomposes again.
"""

import itertools
import json
import subprocess
import sys

import numpy as np
from scipy.linalg import lapack

EPS = np.finfo(np.float32).eps
HARDEST = 8
CHUNK = 100_000


def rotations(rng, n):
    q, _ = np.linalg.qr(rng.standard_normal((n, 3, 3)))
    return q


def with_eigenvalues(rng, values):
    values = np.stack(np.broadcast_arrays(*values), axis=1)
    q = rotations(rng, len(values))
    return np.einsum("nij,nj,nkj->nik", q, values, q)


def symmetric(rng, n):
    a = rng.uniform(-1, 1, (n, 3, 3))
    return (a + np.swapaxes(a, 1, 2)) / 2


def correlation(rng, n):
    w = rng.standard_normal((n, 3, 4))
    c = np.einsum("nik,njk->nij", w, w)
    sigma = np.sqrt(np.einsum("nii->ni", c))
    c /= sigma[:, :, None] * sigma[:, None, :]
    c[:, range(3), range(3)] = 1
    return c


def correlation_near_one(rng, n):
    distance = 10 ** rng.uniform(-4, 0, (n, 1)) * 10 ** rng.uniform(-0.5, 0.5, (n, 3))
    loading = rng.choice([-1, 1], (n, 3)) / np.sqrt(1 + distance**2)
    c = loading[:, :, None] * loading[:, None, :]
    c[:, range(3), range(3)] = 1
    return c


def correlation_near_zero(rng, n):
    c = np.zeros((n, 3, 3))
    c[:, range(3), range(3)] = 1
    for i, j in [(1, 0), (2, 0), (2, 1)]:
        c[:, i, j] = c[:, j, i] = rng.choice([-1, 0, 1], n) * 10 ** rng.uniform(-12, 0, n)
    return c


def diagonal(rng, n):
    a = np.zeros((n, 3, 3))
    a[:, range(3), range(3)] = rng.choice([0, 1, 1, 2, -1, 1e-6, 1e-12, 0.3, 1 + 1.2e-7], (n, 3))
    return a


def block(rng, n):
    a = symmetric(rng, n)
    alone = rng.integers(0, 3, n)
    coupling = rng.choice([0, 1], n) * 10 ** rng.uniform(-10, -3, n)
    for i, j in [(1, 0), (2, 0), (2, 1)]:
        coupled = (alone == i) | (alone == j)
        a[coupled, i, j] *= coupling[coupled]
        a[:, j, i] = a[:, i, j]
    return a


def rank_one(rng, n):
    v = rng.standard_normal((n, 3))
    return v[:, :, None] * v[:, None, :]


def near(rng, n):
    """How far two eigenvalues are apart: from 1e-9 of their size to a tenth, and 1e-7 in a tenth of the draws."""
    return np.where(rng.random(n) < 0.1, 1e-7, 10 ** rng.uniform(-9, -1, n))


FAMILIES = {
    "correlation": correlation,
    "correlation, rho to 1": correlation_near_one,
    "correlation, rho to 0": correlation_near_zero,
    "two largest equal": lambda rng, n: with_eigenvalues(rng, [1, 1 - near(rng, n), rng.uniform(0, 0.9, n)]),
    "two smallest equal": lambda rng, n: with_eigenvalues(rng, [1, *pair(rng, n)]),
    "all equal": lambda rng, n: np.eye(3) + 10 ** rng.uniform(-12, -2, (n, 1, 1)) * symmetric(rng, n),
    "zero": lambda rng, n: np.zeros((n, 3, 3)),
    "diagonal": diagonal,
    "graded 1 : 1e-6 : 1e-12": lambda rng, n: with_eigenvalues(rng, [np.ones(n), 1e-6, 1e-12]),
    "graded": lambda rng, n: with_eigenvalues(rng, [np.ones(n), 10 ** rng.uniform(-4, -1, n), 10 ** rng.uniform(-9, -4, n)]),
    "rank one": rank_one,
    "block 2 + 1": block,
    "random": symmetric,
    "scale 1e-30": lambda rng, n: symmetric(rng, n) * 1e-30,
    "scale 1e+30": lambda rng, n: symmetric(rng, n) * 1e30,
    "near the largest f32": lambda rng, n: symmetric(rng, n) * 1e38,
}


def pair(rng, n):
    c = rng.uniform(0.001, 0.9, n)
    return c * (1 + near(rng, n)), c


def integers():
    """Every matrix with entries from -2 to 2."""
    entries = np.array(list(itertools.product([-2, -1, 0, 1, 2], repeat=6)), dtype=np.float64)
    a = np.empty((len(entries), 3, 3))
    for k, (i, j) in enumerate([(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]):
        a[:, i, j] = a[:, j, i] = entries[:, k]
    return a


def by_core(program, a, of_correlation):
    lower = np.stack([a[:, 0, 0], a[:, 1, 0], a[:, 1, 1], a[:, 2, 0], a[:, 2, 1], a[:, 2, 2]], axis=1)
    arguments = [program] + (["correlation"] if of_correlation else [])
    answer = subprocess.run(arguments, input=lower.astype("<f4").tobytes(), stdout=subprocess.PIPE, check=True).stdout
    answer = np.frombuffer(answer, "<f4").reshape(-1, 12).astype(np.float64)
    return answer[:, :3], np.swapaxes(answer[:, 3:].reshape(-1, 3, 3), 1, 2)


def by_lapack(a):
    values, vectors = np.empty((len(a), 3)), np.empty((len(a), 3, 3))
    for k, matrix in enumerate(a):
        w, v, info = lapack.ssyev(matrix, lower=1)
        assert info == 0
        values[k], vectors[k] = w[::-1], v[:, ::-1]
    return values, vectors


def errors(a, exact, values, vectors):
    """Worst errors of each matrix in eps: eigenvalues, orthogonality, residual."""
    scale = 2.0 ** -np.floor(np.log2(np.maximum(np.abs(a).max(axis=(1, 2)), 1e-300)))
    a, exact, values = a * scale[:, None, None], exact * scale[:, None], values * scale[:, None]
    norm = np.maximum(np.sqrt((a**2).sum(axis=(1, 2))), 1e-300)
    of_values = np.abs(values - exact).max(axis=1) / norm
    gram = np.einsum("nki,nkj->nij", vectors, vectors) - np.eye(3)
    residual = np.einsum("nij,njk->nik", a, vectors) - vectors * values[:, None, :]
    return np.stack([of_values, np.abs(gram).max(axis=(1, 2)), np.abs(residual).max(axis=(1, 2)) / norm], axis=1) / EPS


def study(program, draw, draws, of_correlation):
    worst = {"core": np.zeros(3), "lapack": np.zeros(3)}
    hardest = []
    while draws > 0:
        a = draw(min(draws, CHUNK)).astype(np.float32)
        draws -= len(a)
        wide = a.astype(np.float64)
        exact = np.linalg.eigvalsh(wide)[:, ::-1]
        core = errors(wide, exact, *by_core(program, a, of_correlation))
        worst["core"] = np.maximum(worst["core"], core.max(axis=0))
        worst["lapack"] = np.maximum(worst["lapack"], errors(wide, exact, *by_lapack(a)).max(axis=0))
        for column in range(3):
            for k in np.argsort(core[:, column])[-HARDEST:]:
                hardest.append((column, core[k, column], a[k], exact[k]))
    kept = []
    for column in range(3):
        kept += sorted((row for row in hardest if row[0] == column), key=lambda row: -row[1])[:HARDEST]
    lower = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]
    return {
        "core": [round(float(x), 2) for x in worst["core"]],
        "lapack": [round(float(x), 2) for x in worst["lapack"]],
        "correlation": of_correlation,
        "hardest": [
            {"bits": [int(np.float32(a[i, j]).view(np.uint32)) for i, j in lower], "values": [float(x) for x in exact]}
            for _, _, a, exact in kept
        ],
    }


def main():
    program = sys.argv[1]
    draws = int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000
    cases = [(name, draw, draws, False) for name, draw in FAMILIES.items()]
    cases += [(f"{name}, unit diagonal", draw, draws, True) for name, draw in FAMILIES.items() if "correlation" in name]
    whole = integers()
    cases.append(("integers -2..2, all", lambda rng, n: whole, len(whole), False))
    print("worst, in eps: eigenvalue/norm, orthogonality, residual/norm; core | ssyev", file=sys.stderr)
    result = {"draws": draws, "families": {}}
    for seed, (name, draw, count, of_correlation) in enumerate(cases):
        rng = np.random.default_rng(seed)
        family = study(program, lambda n: draw(rng, n), count, of_correlation)
        result["families"][name] = family
        print(f"{name:40} {family['core']} | {family['lapack']}", file=sys.stderr)
    json.dump(result, sys.stdout, indent=1)
    print()


main()
