"""What the library raises."""
import builtins


class Error(Exception):
    """Base of all exceptions that the library raises on purpose.

    about: the file, option, grid or object that it is about; empty: the call as a whole.
    text: what is wrong, and what would be right, without its subject in front.
    code: a stable name, where the kind of error has one; else empty.
    """

    def __init__(self, text="", about="", code=""):
        super().__init__("%s: %s" % (about, text) if about else text)
        self.text, self.about, self.code = text, about, code

    def __reduce__(self):
        return type(self), (self.text, self.about, self.code)


class InputError(Error, ValueError):
    """An option or a call that cannot be carried out; the message names it, its value and what would be right."""


class IoError(Error, OSError):
    """A file that cannot be read or written; `about` is the file."""

    def __str__(self):
        return Exception.__str__(self)


class GeometryError(Error):
    """Data that can be read but is no usable shape: open, empty, not orientable."""


class OutOfMemory(Error, builtins.MemoryError):
    """What was asked for needs more memory than may be taken; the message says how much, and what to change."""


class Cancelled(Error):
    """The call was cancelled; Ctrl-C raises KeyboardInterrupt instead."""
