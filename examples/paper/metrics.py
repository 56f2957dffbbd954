# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of pictures and what is read off them."""

import numpy as np


def rmse(picture: np.ndarray, reference: np.ndarray) -> float:
    """Root mean square over pixels and r, g, b: what the paper's text calls its error."""
    return float(np.sqrt(np.mean((picture - reference) ** 2)))


def mean_absolute(picture: np.ndarray, reference: np.ndarray) -> float:
    """The paper's eq. (5) and (6) as printed: the sum of sqrt((x - y)^2) over pixels / their number."""
    return float(np.mean(np.abs(picture - reference)))


def eight_bit(picture: np.ndarray) -> np.ndarray:
    """As stored in a file of 8 bits a channel."""
    return np.floor(np.clip(picture, 0, 1) * 255 + 0.5) / 255


def largest_channel_error(picture: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """(height, width): largest of |r|, |g|, |b|; relative above white, as the contract of `error_tolerance` has it."""
    return np.max(np.abs(picture - reference) / np.maximum(1.0, reference), axis=-1)


def slope(counts, errors) -> float:
    """Exponent of a power law, by least squares in logarithms."""
    return float(np.polyfit(np.log(counts), np.log(errors), 1)[0])
