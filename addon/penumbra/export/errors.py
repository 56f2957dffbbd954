# SPDX-License-Identifier: GPL-3.0-or-later
"""What stops an export."""


class ExportError(Exception):
    """Something in the scene that cannot be rendered; the text names the object."""


class ExportCancelled(Exception):
    """The user pressed Esc or Ctrl-C."""
