# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's program while it is written: registers, operations, tables, closures (see native/scene/program.h)."""

import numpy as np

EMPTY = (0.0, 0.0, 0.0)


class Program:
    """Registers hold three floats; a number is held three times. Each is named by its number; 0 is zero."""

    def __init__(self) -> None:
        self.registers: list[tuple[float, float, float]] = [EMPTY]
        self.operations: list[tuple[str, int, list[int], int, int]] = []
        self.tables: list[float] = []
        self.closures: list[tuple[str, int, int, int, int]] = []
        self.normal = 0
        self.grey_transparency = True
        """What the transparent closures let through is the same for red, green and blue."""
        self._constants: dict[tuple[float, float, float], int] = {EMPTY: 0}
        self._known: dict[int, tuple[float, float, float]] = {0: EMPTY}
        self._done: dict[tuple, int] = {}

    def constant(self, value) -> int:
        """The register of a number, or of a vector or colour (of which three components count)."""
        triple = (float(value),) * 3 if np.isscalar(value) else tuple(float(c) for c in value)[:3]
        if triple not in self._constants:
            self._constants[triple] = len(self.registers)
            self._known[len(self.registers)] = triple
            self.registers.append(triple)
        return self._constants[triple]

    def known(self, register: int) -> tuple[float, float, float] | None:
        """The value of a register that is a constant, else None."""
        return self._known.get(register)

    def add(self, name: str, *inputs: int, shift: int = 0, data: int = 0) -> int:
        """The register that an operation on others writes; its second output is in the next one."""
        key = name, inputs, shift, data
        if key not in self._done:
            self._done[key] = len(self.registers)
            self.operations.append((name, len(self.registers), list(inputs), shift, data))
            self.registers += [EMPTY, EMPTY]
        return self._done[key]

    def table(self, values) -> int:
        """The place of some numbers in the tables."""
        start = len(self.tables)
        self.tables += [float(v) for v in values]
        return start

    def multiply(self, first: int, second: int) -> int:
        """The product, component by component."""
        a, b = self.known(first), self.known(second)
        if a == (1.0, 1.0, 1.0):
            return second
        if b == (1.0, 1.0, 1.0):
            return first
        if EMPTY in (a, b):
            return 0
        if a and b:
            return self.constant([x * y for x, y in zip(a, b, strict=True)])
        return self.add("vector.MULTIPLY", first, second)

    def math(self, operation: str, *inputs) -> int:
        """An operation of the Math node on registers or numbers."""
        return self.add(f"math.{operation}", *(i if isinstance(i, int) else self.constant(i) for i in inputs))

    def clamped(self, number: int) -> int:
        """A number clamped to 0 ... 1."""
        known = self.known(number)
        if known:
            return self.constant(min(max(known[0], 0.0), 1.0))
        return self.add("clamp.MINMAX", number, self.constant(0.0), self.constant(1.0))

    def one_minus(self, number: int) -> int:
        known = self.known(number)
        return self.constant([1 - c for c in known]) if known else self.math("SUBTRACT", 1.0, number)

    def mix(self, factor: int, first: int, second: int) -> int:
        """first at factor 0, second at 1."""
        return self.add("mix.MIX", factor, first, second)

    def add_closure(self, kind: str, colour: int, roughness: int = 0, edge: int = 0, ior: int = 0) -> None:
        if self.known(colour) != EMPTY or edge:
            self.closures.append((kind, colour, edge, ior, roughness))

    def arrays(self) -> dict:
        """The arguments of the native scene's add_program, but the name."""
        return {
            "registers": np.array(self.registers, dtype=np.float32),
            "operations": self.operations,
            "tables": np.array(self.tables, dtype=np.float32),
            "closures": self.closures,
            "normal": self.normal,
        }
