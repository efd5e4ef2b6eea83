"""Progress of long calls, to a function or to a bar as tqdm makes them."""


def reporter(progress):
    """A function of a stage and a share, 0 to 1, or None.

    progress: such a function; a bar with `update` and `total` (tqdm); a class of bars; None.
    """
    if progress is None:
        return None
    if isinstance(progress, type):
        progress = progress(total=100)
    if hasattr(progress, "update") and hasattr(progress, "total"):
        return _Bar(progress)
    return progress


class _Bar:
    def __init__(self, bar):
        self.bar, self.done = bar, 0.0
        if not bar.total:
            bar.total = 100

    def __call__(self, stage, fraction):
        if hasattr(self.bar, "set_description"):
            self.bar.set_description(stage, refresh=False)
        step = fraction * self.bar.total - self.done
        if step > 0:
            self.bar.update(step)
            self.done += step
