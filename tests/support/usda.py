"""A strict reader of USD's text form, as far as stages of meshes and volumes need it: written from OpenUSD's documentation of the
format and of the schemas UsdGeom and UsdVol. What is not in it is an error.

Where npm's package `tinyusdz` (0.9.0) is installed globally, or its folder in TINYUSDZ, that reader must take each stage, too, and
find the same in it.
"""
import os
import re
import shutil
import subprocess

import numpy as np

TOKEN = re.compile(r"""\s*(?:(@@@(?:\\@@@|(?!@@@).)*@@@|@[^@\n]*@)|("(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')|(<[^>\s]*>)|"""
                   r"""(-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]))|([A-Za-z_][\w:.]*(?:\[\])?)|([(){}\[\]=:,]))""")
NAME = re.compile(r"[A-Za-z_]\w*$")
# What a schema's attributes are, and the values that tokens may have.
TYPES = {
    "Xform": {},
    "Volume": {"extent": "float3[]"},
    "OpenVDBAsset": {"fieldClass": "token", "fieldDataType": "token", "fieldIndex": "int", "fieldName": "token",
                     "filePath": "asset", "vectorDataRoleHint": "token"},
    "Mesh": {"extent": "float3[]", "faceVertexCounts": "int[]", "faceVertexIndices": "int[]", "normals": "normal3f[]",
             "points": "point3f[]", "primvars:displayColor": "color3f[]", "velocities": "vector3f[]",
             "subdivisionScheme": "uniform token", "xformOp:translate": "double3", "xformOpOrder": "uniform token[]"}}
CHOICES = {
    "fieldClass": {"levelSet", "fogVolume", "staggered", "unknown"},
    "fieldDataType": {"half", "float", "double", "int", "uint", "int64", "half2", "float2", "double2", "int2", "half3", "float3",
                      "double3", "int3", "matrix3d", "matrix4d", "quatd", "bool", "mask", "string"},
    "vectorDataRoleHint": {"None", "Point", "Normal", "Vector", "Color"},
    "subdivisionScheme": {"none", "catmullClark", "loop", "bilinear"}}
STAGE = {"defaultPrim", "endTimeCode", "framesPerSecond", "metersPerUnit", "startTimeCode", "timeCodesPerSecond", "upAxis"}


class Asset(str):
    """The name of a file."""


class Path(str):
    """The place of a prim, as `/a/b`."""


class Prim:
    def __init__(self, kind, name):
        self.kind, self.name = kind, name
        self.values, self.samples, self.interpolation, self.fields, self.children = {}, {}, {}, {}, {}
        self.metadata = {}

    def same(self, other):
        return (self.kind, self.name, self.values, self.samples, self.interpolation, self.fields, self.metadata) == (
            other.kind, other.name, other.values, other.samples, other.interpolation, other.fields, other.metadata) and (
            list(self.children) == list(other.children)) and all(c.same(other.children[n]) for n, c in self.children.items())


def unescaped(text):
    return re.sub(r"\\(.)", lambda m: {"n": "\n", "t": "\t"}.get(m.group(1), m.group(1)), text)


class Reader:
    def __init__(self, text):
        assert text.startswith("#usda 1.0\n"), text[:20]
        text = text[len("#usda 1.0\n"):].rstrip()
        self.tokens, at = [], 0
        while at < len(text):
            match = TOKEN.match(text, at)
            assert match, "not USD: %r" % text[at:at + 60]
            asset, string, path, number, word, mark = match.groups()
            if asset is not None:
                cut = 3 if asset.startswith("@@@") else 1
                self.tokens.append(("value", Asset(asset[cut:-cut].replace("\\@@@", "@@@"))))
            elif string is not None:
                self.tokens.append(("value", unescaped(string[1:-1])))
            elif path is not None:
                self.tokens.append(("value", Path(path[1:-1])))
            elif number is not None:
                self.tokens.append(("value", float(number) if re.search("[.eE]", number) else int(number)))
            else:
                self.tokens.append(("word", word) if word else ("mark", mark))
            at = match.end()
        self.at = 0

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else ("end", "")

    def take(self, mark):
        if self.peek() != ("mark", mark):
            return False
        self.at += 1
        return True

    def need(self, mark):
        assert self.take(mark), "expected %s, not %r" % (mark, self.tokens[self.at:self.at + 5])

    def word(self):
        kind, text = self.next()
        assert kind == "word", (kind, text)
        return text

    def value(self):
        kind, value = self.next()
        if kind == "value":
            return value
        if (kind, value) == ("word", "None"):
            return None
        assert kind == "mark" and value in "([", (kind, value)
        close, items = ")" if value == "(" else "]", []
        while not self.take(close):
            items.append(self.value())
            if not self.take(","):
                self.need(close)
                break
        return tuple(items) if close == ")" else items

    def metadata(self):
        found = {}
        if self.take("("):
            while not self.take(")"):
                name = self.word()
                self.need("=")
                assert name not in found, name
                found[name] = self.value()
        return found

    def samples(self):
        found = {}
        self.need("{")
        while not self.take("}"):
            kind, time = self.next()
            assert kind == "value" and isinstance(time, (int, float)) and time not in found, (kind, time)
            self.need(":")
            found[time] = self.value()
            if not self.take(","):
                self.need("}")
                break
        assert list(found) == sorted(found)
        return found

    def prim(self):
        kind, (_, name) = self.word(), self.next()
        assert kind in TYPES and NAME.match(name), (kind, name)
        prim = Prim(kind, name)
        prim.metadata = self.metadata()
        self.need("{")
        while not self.take("}"):
            word = self.word()
            if word == "def":
                child = self.prim()
                assert child.name not in prim.children, child.name
                prim.children[child.name] = child
            elif word == "rel":
                name = self.word()
                self.need("=")
                prefix, field = name.split(":")
                assert kind == "Volume" and prefix == "field" and NAME.match(field), name
                assert field not in prim.fields, field
                prim.fields[field] = self.value()
            else:
                self.attribute(prim, word)
        return prim

    def attribute(self, prim, word):
        kind = word + " " + self.word() if word == "uniform" else word
        name = self.word()
        sampled = name.endswith(".timeSamples")
        name = name[:-len(".timeSamples")] if sampled else name
        assert TYPES[prim.kind].get(name) == kind, (prim.kind, kind, name)
        if self.take("="):
            place = prim.samples if sampled else prim.values
            assert name not in prim.values and name not in prim.samples, name
            assert not (sampled and kind.startswith("uniform")), name
            samples = self.samples() if sampled else {0: self.value()}
            for value in samples.values():
                check(kind, name, value)
            samples = {time: as_stored(kind, value) for time, value in samples.items()}
            place[name] = samples if sampled else samples[0]
        metadata = self.metadata()
        assert set(metadata) <= {"interpolation"}, metadata
        if metadata:
            assert metadata["interpolation"] == "vertex" and name not in prim.interpolation, (name, metadata)
            prim.interpolation[name] = metadata["interpolation"]


def check(kind, name, value):
    """A value is of an attribute's type; None is a value that there is not."""
    if value is None:
        return
    base = kind.split()[-1]
    if base.endswith("[]"):
        assert isinstance(value, list), name
        for item in value:
            check(base[:-2], name, item)
    elif base.endswith("3") or base.endswith("3f"):
        assert isinstance(value, tuple) and len(value) == 3 and all(isinstance(x, (int, float)) for x in value), (name, value)
    elif base == "int":
        assert isinstance(value, int), (name, value)
    elif base == "asset":
        assert isinstance(value, Asset), (name, value)
    else:
        assert base == "token" and type(value) is str, (name, value)
        assert value in CHOICES.get(name, {value}), (name, value)


def as_stored(kind, value):
    """Vectors of floats as USD keeps them: in single precision."""
    if value is None or not re.search(r"3f\[\]|float3\[\]", kind):
        return value
    return np.array(value, np.float32).reshape(-1, 3).tolist()


class Stage:
    """Metadata, and the one prim at the top."""

    def __init__(self, text):
        reader = Reader(text)
        self.metadata = reader.metadata()
        assert set(self.metadata) <= STAGE, self.metadata
        assert reader.word() == "def"
        self.root = reader.prim()
        assert reader.peek() == ("end", ""), reader.peek()
        assert self.metadata["defaultPrim"] == self.root.name
        assert self.metadata["upAxis"] in ("Y", "Z"), self.metadata

    def same(self, other):
        return self.metadata == other.metadata and self.root.same(other.root)


def tinyusdz_folder():
    """The folder of the package; None: it is not here."""
    folder = os.environ.get("TINYUSDZ")
    if not folder and shutil.which("npm"):
        folder = os.path.join(subprocess.run(["npm", "root", "-g"], capture_output=True, text=True).stdout.strip(), "tinyusdz")
    return folder if folder and shutil.which("node") and os.path.isdir(folder) else None


TINYUSDZ = tinyusdz_folder()


def by_tinyusdz(path, kind):
    """What tinyusdz reads, as text."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tinyusdz.mjs")
    result = subprocess.run(["node", script, os.path.abspath(TINYUSDZ), path, kind], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr[-2000:]
    return result.stdout


def read_stage(path, tinyusdz="scene"):
    """`tinyusdz`: what that makes of the file: a "scene", as by its schemas, only the "layer", or nothing (None)."""
    with open(path, encoding="utf-8") as file:
        stage = Stage(file.read())
    if TINYUSDZ and tinyusdz:
        assert stage.same(Stage(by_tinyusdz(path, tinyusdz))), "tinyusdz finds something else in " + path
    return stage
