"""Options of the program's commands as keyword arguments: the table is the program's own."""
import difflib
import json
import os

from . import _core
from ._errors import InputError

_tables = {}


def table(command):
    """The options of a command, by the names that they have in Python.

    Each is a dict of `name` (as on the command line), `type`, `form` (what a value looks like), `choices`, `help`, `group`.
    """
    if command not in _tables:
        _tables[command] = {python_name(row["name"]): row for row in _core._option_rows(command)}
    return _tables[command]


def python_name(name):
    """--voxel-size is voxel_size; what is a word of Python has an underscore behind it: from_."""
    name = name.replace("-", "_")
    return name + "_" if name in ("from", "in", "as") else name


def texts_of(command, options, ours=()):
    """Keyword arguments as pairs of names and texts; None is an option that is not given. `ours`: names that are no options."""
    known, pairs, tables = table(command), [], []
    for name, value in options.items():
        if value is None:
            continue
        if known.get(name, {}).get("type") == "tables" and _are_tables(value):
            tables += ["%s = %s" % (name, _toml(value))]
            continue
        if name not in known:
            near = difflib.get_close_matches(name, [*known, *ours], 1)
            raise InputError("there is no such option%s; slicemorph.options(%r) lists them" %
                             ("; %s is meant?" % near[0] if near else "", command), name)
        texts = _texts(known[name], value)
        if texts is not None:
            pairs.append((known[name]["name"], texts))
    if tables:
        if options.get("config") is not None:
            raise InputError("tables stand in the job file or are given, not both", "config")
        pairs.append(("options", ["\n".join(tables) + "\n"]))
    return pairs


def describe(command):
    """The options of a command as text, for help()."""
    lines, group = [], None
    for name, row in table(command).items():
        if row["group"] != group:
            group = row["group"]
            lines += ["", "    %s:" % group]
        form = " | ".join(row["choices"]) or row["form"] or row["type"]
        lines.append("    %s: %s\n        %s" % (name, form, row["help"]))
    return "\n".join(lines)


def _are_tables(value):
    return isinstance(value, (list, tuple)) and value and all(isinstance(item, dict) for item in value)


def _toml(value):
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{%s}" % ", ".join("%s = %s" % (json.dumps(str(key)), _toml(item)) for key, item in value.items())
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value))
    if hasattr(value, "__len__") and getattr(value, "ndim", 1) > 0:
        return "[%s]" % ", ".join(map(_toml, value))
    return _one(value)


def _texts(row, value):
    kind = row["type"]
    if kind == "flag":
        if not isinstance(value, (bool,)) and value not in (0, 1):
            raise InputError("expected True or False, not %r" % (value,), row["name"])
        return ["true"] if value else None
    if kind == "texts":
        return [_one(v) for v in value] if isinstance(value, (list, tuple)) else [_one(value)]
    if kind == "landmarks" and not isinstance(value, (str, os.PathLike)):
        if all(isinstance(item, (str, os.PathLike)) for item in value):
            return [",".join(map(_one, value))]
        return [";".join("=".join(",".join(map(_one, position)) for position in landmark) for landmark in value)]
    if kind == "tables" and row["form"] == "":
        raise InputError("expected a list of dicts, one a table, not %r" % (value,), row["name"])
    if kind == "tables" and not isinstance(value, str):
        return [" ".join("%s@%s" % (_one(name), _one(time)) for name, time in value)]
    return [_one(value)]


def _one(value):
    """A value as the command line has it: numbers so that they are read back as they are, rows of them with commas."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if hasattr(value, "__index__"):
        return str(value.__index__())
    if hasattr(value, "__len__") and getattr(value, "ndim", 1) > 0:
        return ",".join(map(_one, value))
    number = float(value)
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
