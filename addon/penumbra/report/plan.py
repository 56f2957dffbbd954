# SPDX-License-Identifier: GPL-3.0-or-later
"""What is rendered: stop rules x samplers over a range of tolerances and counts, around the user's own settings."""

from typing import NamedTuple

OWN_TOLERANCE_TIMES = (5.0, 2.0, 1.0, 0.5, 0.25)
LOOSE_TOLERANCES = 3
"""VARIANCE, whose points grow with the square, keeps to the largest so many."""

FIXED_COUNTS = (16, 64, 256, 1024)
"""Points of a pixel and luminaire; squares, for SPRS."""
POINTS_A_RAY = 4
"""With antialiasing: points at each of the pixel's primary rays."""

SETTINGS_OF_A_RUN = ("stop_rule", "sampler", "sample_reuse", "light_samples", "pixel_samples", "error_tolerance")


class Run(NamedTuple):
    """One picture to be made."""

    family: str
    """Runs of one curve in the plot: "BOUNDED, OWEN_SOBOL"."""
    setting: str
    """What distinguishes it in its family, as text."""
    tolerance: float
    """The tolerance its pixels are held against: its own, or the user's where the rule knows none."""
    settings: dict
    """The settings of the native renderer, whole."""
    is_own: bool
    """Whether these are the user's own settings."""


def tolerances(own: float) -> list[float]:
    """The tolerances to be shown, largest first."""
    return [own if times == 1 else float(f"{own * times:.3g}") for times in OWN_TOLERANCE_TIMES]


def _difference(settings: dict) -> tuple:
    """What tells two runs apart: settings that a run does not look at are left out."""
    rule = settings["stop_rule"]
    ignored = {"error_tolerance" if rule == "FIXED" else "light_samples"}
    if settings["sampler"] in ("PRS", "SPRS"):
        ignored.add("sample_reuse")
    return tuple(settings[name] for name in SETTINGS_OF_A_RUN if name not in ignored)


def _run(own: dict, changes: dict) -> Run:
    settings = own | changes
    fixed = settings["stop_rule"] == "FIXED"
    rays = f"{settings['pixel_samples']} x " if settings["pixel_samples"] > 1 else ""
    setting = f"{rays}{settings['light_samples']} points" if fixed else f"tolerance {settings['error_tolerance']:g}"
    reuse = settings["sample_reuse"]
    unusual = reuse != "SCRAMBLED" and settings["sampler"] not in ("PRS", "SPRS")
    family = f"{settings['stop_rule']}, {settings['sampler']}{f' {reuse}' if unusual else ''}"
    tolerance = own["error_tolerance"] if fixed else settings["error_tolerance"]
    return Run(family, setting, tolerance, settings, _difference(settings) == _difference(own))


def runs(own: dict, shown: list[float]) -> list[Run]:
    """All runs of a report.

    own: the native settings as the user has them. shown: the tolerances that the reference is good for, largest first.
    """
    changes: list[dict] = []

    def add(rule: str, sampler: str, values: list[dict]) -> None:
        common = {"stop_rule": rule, "sampler": sampler, "sample_reuse": "SCRAMBLED"}
        changes.extend(common | value for value in values)

    if own["pixel_samples"] > 1:
        counts = [{"pixel_samples": n // POINTS_A_RAY, "light_samples": POINTS_A_RAY} for n in FIXED_COUNTS]
    else:
        counts = [{"light_samples": n} for n in FIXED_COUNTS]
    bounds = [{"error_tolerance": tolerance} for tolerance in shown]
    add("BOUNDED", "OWEN_SOBOL", bounds)
    add("FIXED", "OWEN_SOBOL", counts)
    for sampler in ("SOBOL", "HALTON", "SPRS", "PRS"):
        add("FIXED", sampler, counts[:-1])
    if own["max_light_samples"] >= 2 * own["check_interval"]:
        for sampler in ("OWEN_SOBOL", "HALTON"):
            add("PAPER", sampler, bounds)
    for sampler in ("OWEN_SOBOL", "PRS"):
        add("VARIANCE", sampler, bounds[:LOOSE_TOLERANCES])
    planned = [_run(own, change) for change in changes]
    if not any(run.is_own for run in planned):
        planned.insert(0, _run(own, {}))
    return planned
