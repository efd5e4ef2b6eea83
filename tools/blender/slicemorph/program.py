"""The program, as a process in the background. Knows nothing of Blender."""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import threading

try:
    import pty  # not on Windows
except ImportError:
    pty = None

kProgress = re.compile(r"(\S.*?) (\d+)%(?:, (.+) left)?\s*")


class Unusable(Exception):
    """Why a morph cannot be made, for the user."""


def find_program(preferred):
    """Path of the program: `preferred` (a file, or empty), else beside this add-on, else on the PATH."""
    if preferred:
        if not os.access(preferred, os.X_OK) or os.path.isdir(preferred):
            raise Unusable(f"{preferred}: no program is there; correct it in the add-on's preferences")
        return preferred
    beside = shutil.which("slicemorph", path=pathlib.Path(__file__).parent)
    found = beside or shutil.which("slicemorph")
    if not found:
        raise Unusable("the program slicemorph is not found: install it, or name its file in the add-on's preferences")
    return found


class Process:
    """A run of the program. `stage`, `percent` and `left` are its progress, `lines` what else it says."""

    def __init__(self, command):
        self.stage, self.percent, self.left, self.lines = "starting", 0, "", []
        # The program tells its progress to terminals only.
        ours, its = pty.openpty() if pty else os.pipe()
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=its)
        except OSError as problem:
            os.close(ours)
            raise Unusable(f"{command[0]}: cannot be started: {problem.strerror}") from None
        finally:
            os.close(its)
        self.reader = threading.Thread(target=self._read_messages, args=(ours,), daemon=True)
        self.reader.start()

    def _read_messages(self, descriptor):
        rest = b""
        while True:
            try:
                data = os.read(descriptor, 65536)
            except OSError:  # how a terminal ends whose other side is closed
                data = b""
            *whole, rest = re.split(rb"[\r\n]", rest + data)
            self._take(whole)
            # A line of progress ends with the beginning of the next, so it is read before.
            self._read_progress(rest)
            if not data:
                self._take([rest])
                os.close(descriptor)
                return

    def _read_progress(self, line):
        """Whether the line is one of progress."""
        progress = kProgress.fullmatch(line.decode(errors="replace").strip())
        if progress:
            self.stage, self.percent, self.left = progress[1], int(progress[2]), progress[3] or ""
        return progress is not None

    def _take(self, lines):
        for line in lines:
            if line.strip() and not self._read_progress(line):
                self.lines.append(line.decode(errors="replace").strip())

    def ended(self):
        """True when the program has ended and all that it said has been read."""
        return self.process.poll() is not None and not self.reader.is_alive()

    def cancel(self):
        """Asks the program to end after what it is writing; asked again, it ends at once."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT if os.name == "posix" else signal.SIGTERM)

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def notes(self):
        return [line for line in self.lines if line.startswith(("note: ", "warning: "))]

    def complaint(self):
        """What the program ended with: its last lines that are no notes."""
        errors = [line for line in self.lines if not line.startswith(("note: ", "warning: "))]
        return "\n".join(errors[-5:]) or f"slicemorph ended with exit code {self.process.returncode}"
