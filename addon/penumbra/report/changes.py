# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that are changed for a while: `with Changes() as changes: changes.set(owner, name, value)`."""


class Changes:
    """Remembers what properties were before they were set, and brings them back at the end, after a failure too."""

    def __init__(self) -> None:
        self._before: dict[tuple[int, str], tuple[object, str, object]] = {}

    def keep(self, owner, *names: str) -> None:
        """Remembers properties that something else is going to change; names that the owner lacks are passed over."""
        for name in names:
            if hasattr(owner, name):
                self._before.setdefault((owner.as_pointer(), f"{owner.rna_type.identifier}.{name}"),
                                        (owner, name, getattr(owner, name)))  # fmt: skip

    def set(self, owner, name: str, value) -> None:
        """Sets a property until the end, if the owner has it (not every Blender has every one) and it differs."""
        if hasattr(owner, name) and getattr(owner, name) != value:
            self.keep(owner, name)
            setattr(owner, name, value)

    def __enter__(self) -> "Changes":
        return self

    def __exit__(self, *_) -> None:
        """In the order they were kept: a file format allows its colour depths."""
        failed = []
        for owner, name, value in self._before.values():
            try:
                setattr(owner, name, value)
            except (AttributeError, TypeError, ReferenceError) as error:
                failed.append(f"{name}: {error}")
        if failed:
            raise RuntimeError(f"could not be set back: {'; '.join(failed)}")
