"""Command-line modules as 3D Slicer 5 runs them: known by their description alone, fed through files of its own making, heard
by the tags on their standard output."""
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree

OF_THE_SCENE = {"image": ".nrrd", "geometry": ".vtp"}
WHERE_GIVEN = ("string", "file", "directory")
TAGS = ("filter-progress", "filter-stage-progress", "filter-name", "filter-comment", "filter-time", "filter-start", "filter-end")


class Result:
    """What a run printed, as Slicer takes it apart."""

    def __init__(self, code, output, errors, answers):
        self.code, self.errors, self.answers = code, errors, answers
        self.progress = [float(text) for text in re.findall("<filter-progress>(.*?)</filter-progress>", output)]
        self.comments = re.findall("<filter-comment>(.*?)</filter-comment>", output)
        self.names = re.findall("<filter-name>(.*?)</filter-name>", output)
        self.ended = "<filter-end>" in output
        self.time = [float(text) for text in re.findall("<filter-time>(.*?)</filter-time>", output)]
        for tag in TAGS:
            output = re.sub(r"<%s>[^<]*</%s>\s*" % (tag, tag), "", output)
        self.text = output


class Module:
    def __init__(self, path, env=None):
        """Asks for the description in the module's own folder, as Slicer does."""
        self.path, self.env = path, dict(os.environ, **(env or {}))
        told = subprocess.run([path, "--xml"], cwd=os.path.dirname(path), env=self.env, capture_output=True, text=True, timeout=60)
        assert told.returncode == 0 and not told.stderr, told
        assert told.stdout.startswith('<?xml version="1.0" encoding="utf-8"?>'), told.stdout[:80]
        self.xml = told.stdout
        self.root = ElementTree.fromstring(told.stdout.encode())
        self.name = os.path.basename(path)

    def parameters(self):
        return [element for group in self.root.findall("parameters") for element in group
                if element.tag not in ("label", "description")]

    def parameter(self, name):
        return next(element for element in self.parameters() if element.findtext("name") == name)

    def extensions(self, name):
        listed = self.parameter(name).get("fileExtensions")
        return listed.split(",") if listed else [OF_THE_SCENE[self.parameter(name).tag]]

    def file_for(self, name, node):
        """The temporary file of a node of the scene, whose digits become letters."""
        made = "%d_%s" % (os.getpid(), node)
        return os.path.join(os.getcwd(), "".join(chr(ord("A") + int(c)) if c.isdigit() else c for c in made) + self.extensions(name)[0])

    def answers(self):
        """Names of what the module answers by --returnparameterfile."""
        return [e.findtext("name") for e in self.parameters()
                if e.findtext("channel") == "output" and e.tag in ("string", "integer", "double")
                and all(e.find(way) is None for way in ("flag", "longflag", "index"))]

    def command(self, given):
        """The command line for values by parameter name: of objects of the scene their files, of points a list of triples. What is
        not given has its default."""
        unknown = set(given) - {e.findtext("name") for e in self.parameters()}
        assert not unknown, unknown
        words, placed = [self.path], {}
        if self.answers():
            words += ["--returnparameterfile", os.path.join(os.getcwd(), "answers.params")]
        for element in self.parameters():
            name, flag = element.findtext("name"), (element.findtext("longflag") or "").lstrip("-")
            if element.tag == "point":
                for point in given.get(name, []):
                    words += ["--" + flag, ",".join("%.8g" % x for x in point)]
                continue
            value = str(given.get(name, element.findtext("default") or ""))
            if element.find("index") is not None:
                placed[int(element.findtext("index"))] = value
            elif not flag:
                continue
            elif element.tag == "boolean":
                words += ["--" + flag] if value == "true" else []
            elif element.tag in OF_THE_SCENE or element.tag in WHERE_GIVEN:
                words += ["--" + flag, value] if value else []
            else:
                words += ["--" + flag, value]
        return words + [placed[index] for index in sorted(placed)]

    def start(self, given):
        return subprocess.Popen(self.command(given), env=self.env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run(self, given, code=0):
        process = self.start(given)
        output, errors = process.communicate(timeout=300)
        answers = {}
        if os.path.exists("answers.params"):
            for line in open("answers.params"):
                key, _, value = line.partition("=")
                answers[key.strip()] = value.strip()
            os.remove("answers.params")
        assert process.returncode == code, "%s: exit %d\n%s%s" % (" ".join(process.args), process.returncode, errors, output)
        return Result(process.returncode, output, errors, answers)
