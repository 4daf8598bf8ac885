"""Where the wall time goes: shells mark their work, a run reads the ledger.

This is observation, not simulation state: nothing that is marked depends on it.
"""

import time
from collections import defaultdict
from contextlib import contextmanager


class TimeLedger:
    """Exclusive wall time per name [s]: work marked inside other marked work is charged to the inner name only."""

    def __init__(self):
        self.reset()

    def reset(self) -> None:
        """Forget everything charged so far."""
        self.seconds: dict[str, float] = defaultdict(float)
        self._inner: list[float] = []

    @contextmanager
    def charge(self, name: str):
        """Charge the wall time of the ``with`` body to name."""
        start = time.perf_counter()
        self._inner.append(0.0)
        try:
            yield
        finally:
            spent = time.perf_counter() - start
            self.seconds[name] += spent - self._inner.pop()
            if self._inner:
                self._inner[-1] += spent


LEDGER = TimeLedger()
