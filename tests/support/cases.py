"""Shared by the Python tests: runs each case in a folder of its own and prints its verdict and time."""
import os
import tempfile
import time


class Skip(Exception):
    """Raised by a case that cannot run here; says why."""


def named_cases(names):
    """The functions case_NAME of a module's globals() as pairs (NAME, function), in their order there."""
    return [(name[5:], function) for name, function in names.items() if name.startswith("case_")]


def within(case):
    """A case without arguments as a function of a folder, which is its working directory."""
    def run_there(folder):
        os.chdir(folder)
        try:
            case()
        finally:
            os.chdir("/")
    return run_there


def run_cases(cases, only=()):
    """Runs pairs (name, function of an empty folder); with `only`, those whose names hold one of these words.

    Returns the exit code: 1 where a case failed or none was run, else 0.
    """
    ran = failed = 0
    for name, case in cases:
        if only and not any(word in name for word in only):
            continue
        ran += 1
        start = time.time()
        with tempfile.TemporaryDirectory(prefix="slicemorph-test-") as folder:
            try:
                case(folder)
                verdict = "ok"
            except Skip as reason:
                verdict = "SKIPPED: %s" % reason
            except Exception as problem:
                failed += 1
                verdict = "FAILED: %s: %s" % (type(problem).__name__, str(problem)[:2000])
        print("%-40s %5.1f s  %s" % (name, time.time() - start, verdict), flush=True)
    print("%d cases, %d failed" % (ran, failed))
    return 1 if failed or not ran else 0


def run_within(names, only=()):
    """Runs a module's functions case_NAME(), given its globals(), each in a folder of its own; else as run_cases."""
    return run_cases([(name, within(case)) for name, case in named_cases(names)], only)
