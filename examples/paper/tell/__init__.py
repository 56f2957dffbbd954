# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: each file turns this run's numbers into a chapter of Markdown; nothing is measured or drawn here."""
