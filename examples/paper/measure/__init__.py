# SPDX-License-Identifier: GPL-3.0-or-later
"""One file per experiment: `measure(data, size)` renders and writes rows and pictures; it draws and judges nothing."""
