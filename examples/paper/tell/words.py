# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers in words, and figures in Markdown."""

from .captions import CAPTIONS


def times(ratio: float) -> str:
    return f"{ratio:.0f}x" if ratio >= 20 else f"{ratio:.1f}x"


def percent(share: float) -> str:
    value = 100 * share
    return f"{value:.0f} %" if value >= 9.95 or value == 0 else f"{value:.1f} %" if value >= 0.095 else f"{value:.2g} %"


def millions(count: float) -> str:
    return f"{count / 1e6:.2f} M"


def figure(name: str) -> str:
    text = CAPTIONS[name]
    return f"![{text}](figures/{name}.png)\n\n*{text}*\n"
