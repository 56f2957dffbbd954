# SPDX-License-Identifier: GPL-3.0-or-later
"""One file per experiment: `draw(data, folder)` turns this run's numbers into figures; nothing is measured here."""
