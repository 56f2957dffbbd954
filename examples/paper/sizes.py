# SPDX-License-Identifier: GPL-3.0-or-later
"""How large the experiments are: a quick look and the paper's own size."""

from typing import NamedTuple


class Size(NamedTuple):
    """Pictures as (width, height) in pixels; counts of points on the luminaire."""

    name: str
    picture: tuple[int, int]
    """Fig. 4 to 7: the sphere's scene"""
    reference_points: int
    """Points of each of a reference's two halves, in and near the penumbra"""
    slope_points: tuple[int, ...]
    """Counts beyond the paper's 4 ... 100, all squares"""
    most_running_points: int
    """Fig. 6: how far the running means are followed"""
    running_places: int
    """Fig. 6: floor points in the lit part and in the penumbra for the statistics, each"""
    starts: tuple[int, ...]
    """Fig. 6: starting indices, as shifts of the usual one"""
    ray_budget: float
    """Fig. 9: rays of QMC-EBLS"""
    bound_picture: tuple[int, int]
    timing_rounds: int


QUICK = Size(
    name="quick", picture=(160, 120), reference_points=8192, slope_points=(256, 1024),
    most_running_points=256, running_places=3, starts=(0, 100),
    ray_budget=0.9e6, bound_picture=(160, 120), timing_rounds=3,
)  # fmt: skip
FULL = Size(
    name="full", picture=(256, 192), reference_points=16384, slope_points=(256, 1024, 4096),
    most_running_points=512, running_places=4, starts=(0, 7, 100, 1000),
    ray_budget=10.9e6, bound_picture=(400, 300), timing_rounds=5,
)  # fmt: skip
