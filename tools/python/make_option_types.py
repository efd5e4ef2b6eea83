#!/usr/bin/env python3
"""Writes the types of all options, from the program's table. usage: make_option_types.py MODULE OUTPUT

MODULE: the compiled module, in its package.
"""
import os
import sys

module, output = sys.argv[1:]
sys.path.insert(0, os.path.dirname(os.path.dirname(module)))
import slicemorph

NAMES = {"morph": "MorphOptions", "compare": "CompareOptions", "render": "RenderOptions", "slice": "SliceOptions",
         "reconstruct": "ReconstructOptions", "convert": "ConvertOptions"}
TYPES = {"flag": "bool", "integer": "int", "number": "float", "text": "Union[str, PathLike, float, Sequence[float]]",
         "texts": "Union[str, PathLike, Sequence[str]]", "numbers": "Union[str, float, Sequence[float]]",
         "tables": "Union[str, Sequence[Tuple[Union[str, int], float]], Sequence[Dict[str, Any]]]", "landmarks": "Union[str, PathLike, Sequence[Any]]"}

lines = ['"""Options of the functions, for type checkers; made by make_option_types.py."""',
         "from os import PathLike", "from typing import Any, Dict, Literal, Sequence, Tuple, TypedDict, Union"]
for command, name in NAMES.items():
    lines += ["", "", "class %s(TypedDict, total=False):" % name]
    for option, row in slicemorph.options(command).items():
        kind = "Literal[%s]" % ", ".join(map(repr, row["choices"])) if row["choices"] else TYPES[row["type"]]
        lines.append("    %s: %s  # %s" % (option, kind, row["help"]))
with open(output, "w") as file:
    file.write("\n".join(lines) + "\n")
