"""The program as the Python tests start it, in the working directory."""
import os
import subprocess


class Program:
    def __init__(self, path):
        self.path = os.path.abspath(path)

    def start(self, *arguments, env=None):
        return subprocess.run([self.path, *map(str, arguments)], capture_output=True, text=True, errors="replace", timeout=600,
                              env=dict(os.environ, **(env or {})))

    def run(self, *arguments, code=0, env=None):
        """Ends with this code; returns what it printed."""
        result = self.start(*arguments, env=env)
        assert result.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, arguments)), result.returncode, result.stderr)
        return result

    def refused(self, *arguments, says=()):
        """A wrong input: a message that says all of `says`, exit 1 or 2, and no output. Returns the message."""
        before = set(os.listdir("."))
        result = self.start(*arguments)
        assert result.returncode in (1, 2), "%s: exit %d\n%s" % (" ".join(map(str, arguments)), result.returncode, result.stderr)
        for part in says:
            assert part in result.stderr, "%r is not in: %s" % (part, result.stderr)
        assert set(os.listdir(".")) == before, "output was left: %s" % (set(os.listdir(".")) - before)
        return result.stderr
