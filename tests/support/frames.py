"""Shared by the Python tests: folders of frames, compared by what is in them."""
import hashlib
import os


def folder(parent, name):
    """A new folder; its path."""
    path = os.path.join(parent, name)
    os.mkdir(path)
    return path


def sums(path, ending):
    """Names and SHA-256 of the files of a folder that end so."""
    return {name: hashlib.sha256(open(os.path.join(path, name), "rb").read()).hexdigest()
            for name in sorted(os.listdir(path)) if name.endswith(ending)}
