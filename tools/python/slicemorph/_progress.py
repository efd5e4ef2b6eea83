"""Progress of long calls, to a function or to a bar as tqdm makes them."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Any, Iterator


@contextmanager
def reporting(progress: Any) -> Iterator[Any]:
    """Gives a function of a stage and a share, 0 to 1, or None. A bar is full where the call ends well.

    progress: such a function; a bar with `update` and `total` (tqdm); a class of bars, of which one is made, and closed; None.
    """
    own = isinstance(progress, type)
    if own:
        progress = progress(total=100)
    if not (hasattr(progress, "update") and hasattr(progress, "total")):
        yield progress
        return
    bar = _Bar(progress)
    try:
        yield bar
        bar.advance(1.0)
    finally:
        if own:
            progress.close()


class _Bar:
    def __init__(self, bar: Any):
        self.bar, self.done = bar, 0
        if not bar.total:
            bar.total = 100

    def __call__(self, stage: str, fraction: float) -> None:
        if hasattr(self.bar, "set_description"):
            self.bar.set_description(stage, refresh=False)
        self.advance(fraction)

    def advance(self, fraction: float) -> None:
        step = int(fraction * self.bar.total) - self.done
        if step > 0:
            self.bar.update(step)
            self.done += step
