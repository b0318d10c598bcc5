"""Counter-based random numbers: noise is a function of (key, counter), so it never depends on how worlds are run.

The generator is Philox 4x64-10 (Salmon et al. 2011, 'Parallel random numbers: as easy as 1, 2, 3'), the same stream
as ``numpy.random.Philox``; normals by Box and Muller (1958).
"""

from __future__ import annotations

from math import cos, log, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.kernels.compiled import njit

_M0 = np.uint64(0xD2E7470EE14C6C93)
_M1 = np.uint64(0xCA5A826395121157)
_W0 = np.uint64(0x9E3779B97F4A7C15)
_W1 = np.uint64(0xBB67AE8584CAA73B)
_LOW = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_TO_MANTISSA = np.uint64(11)
_UNIT = 1.0 / 9007199254740992.0  # 2^-53
_ROUNDS = 10


@njit
def _multiply_high(a, b):
    """Upper 64 bits of the 128-bit product of two unsigned 64-bit integers."""
    a_low, a_high = a & _LOW, a >> _HALF
    b_low, b_high = b & _LOW, b >> _HALF
    middle = a_high * b_low + ((a_low * b_low) >> _HALF)
    other = a_low * b_high + (middle & _LOW)
    return a_high * b_high + (middle >> _HALF) + (other >> _HALF)


@njit
def philox(key, counter):
    """Four random 64-bit integers for a key of two and a counter of four unsigned 64-bit integers."""
    k0, k1 = key
    c0, c1, c2, c3 = counter
    for _ in range(_ROUNDS):
        c0, c1, c2, c3 = (
            _multiply_high(_M1, c2) ^ c1 ^ k0,
            _M1 * c2,
            _multiply_high(_M0, c0) ^ c3 ^ k1,
            _M0 * c0,
        )
        k0 += _W0
        k1 += _W1
    return c0, c1, c2, c3


@njit
def _normal_pair(a, b):
    """Two independent standard normals from two random 64-bit integers."""
    radius = sqrt(-2.0 * log((float(a >> _TO_MANTISSA) + 0.5) * _UNIT))
    angle = 2.0 * pi * float(b >> _TO_MANTISSA) * _UNIT
    return radius * cos(angle), radius * sin(angle)


@njit
def fill_normals(key, tick, normals):
    """Fill ``normals`` (a multiple of four) with the standard normals that belong to (key, tick)."""
    zero = np.uint64(0)
    for block in range(normals.shape[0] // 4):
        a, b, c, d = philox(key, (np.uint64(tick), np.uint64(block), zero, zero))
        normals[4 * block], normals[4 * block + 1] = _normal_pair(a, b)
        normals[4 * block + 2], normals[4 * block + 3] = _normal_pair(c, d)


class Streams(NamedTuple):
    """Random numbers of an episode's beginning: what one draws moves no other, so that comparisons are paired."""

    patient: np.random.Generator
    geometry: np.random.Generator
    untold: np.random.Generator
    motors: np.random.Generator

    @classmethod
    def of(cls, key: NDArray[np.uint64]) -> Streams:
        """Streams of an episode; streams of different numbers share none."""
        counters = [np.array([0, 0, 0, number], dtype=np.uint64) for number in range(4)]
        return cls(*(np.random.Generator(np.random.Philox(key=key, counter=counter)) for counter in counters))
