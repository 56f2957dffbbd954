# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 1's points, as Python sees them: the C library's drand48, published values, cells and elementary intervals.

The core's own tests (tests/native) go further; these are about what `sample_points` hands out. All exact.
"""

import ctypes
import ctypes.util

import numpy as np
import penumbra_native as pn
import pytest

SAMPLERS = ["PRS", "SPRS", "SOBOL", "HALTON", "OWEN_SOBOL"]
REUSES = ["SAME", "CONTINUED", "ROTATED", "SCRAMBLED"]


def drand48_pairs(seed, count):
    libc = ctypes.CDLL(ctypes.util.find_library("c"))
    libc.drand48.restype = ctypes.c_double
    libc.srand48(ctypes.c_long(seed))
    return np.array([[libc.drand48(), libc.drand48()] for _ in range(count)])


@pytest.mark.parametrize("seed", [0, 1, 2**31 - 1])
def test_prs_is_the_c_librarys_drand48(seed):
    exact = np.floor(drand48_pairs(seed, 500) * 2**24) / 2**24
    np.testing.assert_array_equal(pn.sample_points("PRS", 500, seed=seed), exact)
    np.testing.assert_array_equal(
        pn.sample_points("PRS", 100, seed=seed, pixel=3, samples_per_pixel=100), exact[300:400]
    )


def test_sprs_has_one_point_a_cell():
    for side in (1, 2, 4, 9, 16):
        cells = np.floor(pn.sample_points("SPRS", side * side) * side).astype(int)
        assert len(np.unique(cells, axis=0)) == side * side


def test_sobol_and_halton_start_as_published():
    """Sobol': what IDL's manual prints for its SOBOLSEQUENCE, which is Numerical Recipes' sobseq. Halton: mirrored
    digits."""
    sobol = [(1 / 2, 1 / 2), (1 / 4, 3 / 4), (3 / 4, 1 / 4), (3 / 8, 5 / 8)]
    np.testing.assert_array_equal(pn.sample_points("SOBOL", 4), sobol)
    halton = np.array([(1 / 2, 1 / 3), (1 / 4, 2 / 3), (3 / 4, 1 / 9), (1 / 8, 4 / 9), (5 / 8, 7 / 9), (3 / 8, 2 / 9)])
    np.testing.assert_array_equal(pn.sample_points("HALTON", 6), np.floor(halton * 2**24) / 2**24)


@pytest.mark.parametrize("reuse", ["SAME", "CONTINUED", "SCRAMBLED"])
def test_owen_sobol_fills_every_elementary_interval(reuse):
    for pixel in (0, 1, 1000):
        points = pn.sample_points("OWEN_SOBOL", 256, reuse, seed=5, pixel=pixel)
        for a in range(9):
            columns = (points * [2**a, 2 ** (8 - a)]).astype(int)
            assert len(np.unique(columns, axis=0)) == 256


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize("reuse", REUSES)
def test_points_lie_in_the_unit_square(sampler, reuse):
    points = pn.sample_points(sampler, 1024, reuse, seed=3, pixel=17)
    assert points.shape == (1024, 2) and points.dtype == np.float64
    assert points.min() >= 0 and points.max() < 1
    np.testing.assert_array_equal(points * 2**24, np.floor(points * 2**24))
    np.testing.assert_array_equal(points, pn.sample_points(sampler, 1024, reuse, seed=3, pixel=17))


def test_refusals_name_what_is_wrong():
    for arguments, word in (
        (("FAURE", 4), "sampler"),
        (("SOBOL", 4, "NEVER"), "sample_reuse"),
        (("SPRS", 5), "SPRS"),
        (("SOBOL", 2**24 + 1), "count"),
    ):
        with pytest.raises(ValueError, match=word):
            pn.sample_points(*arguments)
    assert pn.sample_points("SOBOL", 0).shape == (0, 2)
