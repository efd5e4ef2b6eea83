#!/usr/bin/env python3
"""Command-line cases of slicemorph, one table line each.

usage: command_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

A case is (name, arguments, exit code, text on stderr, text on stdout); a text may be a list of texts. In an
argument `{d}` is the folder of the inputs, `{o}` a fresh folder for outputs. A case that fails must leave `{o}`
empty; no case may be ended by a signal or take longer than two minutes. Cases that need a file system of their
own are skipped, with a message, where mounting is not allowed.
"""
import json
import math
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

if len(sys.argv) < 2:
    sys.exit(__doc__)
PROGRAM = os.path.abspath(sys.argv[1])
ONLY = sys.argv[2:]

USAGE = [
    ("no command", "", 2, "subcommand", ""),
    ("unknown command", "melt", 2, "slicemorph:", ""),
    ("version", "--version", 0, "", "slicemorph "),
    ("help", "--help", 0, "", ["morph", "convert", "compare", "info", "render", "slice"]),
    ("exr options elsewhere", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --fov 30", 2, ["--fov", ".exr", "m.####.vdb"], ""),
    ("exr slice options of a picture", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.exr --exr-slices 4", 2, ["--exr-slices", "--exr slices"], ""),
    ("exr picture options of slices", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.exr --exr slices --fov 30", 2, ["--fov", "slices"], ""),
    ("grids of a mesh", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.ply --grids density", 2, ["--grids density", "surface alone"], ""),
    ("exr slices of png", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.png --exr slices", 2, ["--exr slices", ".png"], ""),
    ("exr content", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.exr --exr depth", 2, "--exr", ""),
    ("exr slices none", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.exr --exr slices --exr-slices 0", 2, ["--exr-slices 0", "1 to"], ""),
    ("exr plane", "morph {d}/a.obj {d}/b.obj -o {o}/m.exr --at 0.5 --resolution 24 --exr slices --exr-plane 0,0,99/0,0,1", 2, "0,0,99", ""),
    ("exr size", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.exr --size 0x10", 2, "--size 0x10", ""),
    ("exr one file", "morph {d}/a.obj {d}/b.obj -o {o}/m.exr", 2, "####", ""),
    ("exr folder", "morph {d}/a.obj {d}/b.obj -o {o}/no/m.####.exr", 1, "{o}/no", ""),
    ("morph help", "morph --help", 0, "", ["--frames", "--resolution", "--quiet", "--help-all", "Inputs:", "Farm:"]),
    ("quiet and verbose", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --quiet --verbose", 2, ["--quiet", "--verbose", "exclude"], ""),
    ("empty value", "convert {d}/a.obj -o {o}/m.vdb --iso=", 2, "--iso", ""),
    ("unknown option", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frmes 3", 2, "--frmes", ""),
    ("one input", "morph {d}/a.obj -o {o}/m.####.vdb", 2, "at least two inputs", ""),
    ("frames negative", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames -3", 2, ["--frames -3", "1 to"], ""),
    ("frames zero", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 0", 2, "--frames 0", ""),
    ("frames text", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames many", 2, "--frames", ""),
    ("frames huge", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 99999999999999", 2, "--frames", ""),
    ("resolution 100000", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --resolution 100000", 2,
     ["--resolution 100000", "8 to 4096"], ""),
    ("resolution 0", "convert {d}/a.obj -o {o}/m.vdb --resolution 0", 2, "--resolution 0", ""),
    ("voxel size 0", "convert {d}/a.obj -o {o}/m.vdb --voxel-size 0", 2, "--voxel-size 0", ""),
    ("voxel size nan", "convert {d}/a.obj -o {o}/m.vdb --voxel-size nan", 2, "--voxel-size", ""),
    ("voxel size tiny", "convert {d}/a.obj -o {o}/m.vdb --voxel-size 1e-9", 2, ["a.obj", "voxel"], ""),
    ("voxel size and resolution", "convert {d}/a.obj -o {o}/m.vdb --voxel-size 0.1 --resolution 64", 2, "exclude", ""),
    ("frames without ####", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb", 2, "####", ""),
    ("at outside", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --at 1.5", 2, ["1.5", "0 to 1"], ""),
    ("at text", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --at half", 2, "half", ""),
    ("at twice without ####", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --at 0.2,0.4", 2, "####", ""),
    ("at and frames", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --at 0.2 --frames 3", 2, "exclude", ""),
    ("weights count", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --weights 0.2,0.3,0.5", 2, "3 numbers for 2 inputs", ""),
    ("weights zero", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --weights 0,0", 2, ["--weights 0,0", "all 0"], ""),
    ("weights not finite", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --weights nan,1", 2, ["--weights nan,1", "not a number"], ""),
    ("weights and ease", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --weights 1,0 --ease in", 2, ["--ease", "--frames or --at"], ""),
    ("keys unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --keys a@0,x@1", 2, ["--keys", "'x' is no input", "2 'b'"], ""),
    ("keys fall", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --keys a@0.5,b@0.2", 2, ["'b@0.2'", "rise"], ""),
    ("keys of levelset", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset --keys a@0,b@1", 2, ["--keys", "levelset"], ""),
    ("timing unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --timing cubic", 2, "--timing", ""),
    ("ease unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --ease bounce", 2, ["--ease bounce", "in-out"], ""),
    ("interpolation unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --interpolation cubic", 2, "--interpolation", ""),
    ("interpolation of sdf", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method sdf --interpolation hermite", 2,
     ["--interpolation hermite", "--method slices", "sdf"], ""),
    ("weights negative", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --weights -1,2", 2, "negative", ""),
    ("slices few", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --slices 2", 2, "--slices 2", ""),
    ("samples many", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --samples 100000", 2, "--samples 100000", ""),
    ("axis letter", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --axis w", 2, "--axis w", ""),
    ("axis zero", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --axis 0,0,0", 2, "no length", ""),
    ("spine unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --spine bent", 2, "--spine", ""),
    ("grids", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --grids density", 2, ["'density'", "surface"], ""),
    ("grids empty", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --grids ,", 2, ["--grids ,", "commas"], ""),
    ("method unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method melt", 2, "--method", ""),
    ("method without parameters", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method sdf{{x=1}}", 2,
     ["--method sdf{{x=1}}", "no parameter 'x'", "sdf has no parameters"], ""),
    ("method parameter unknown", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{speed=1}}", 2,
     ["no parameter 'speed'", "parameters of levelset are steps", "default 2000"], ""),
    ("method parameter out of range", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{steps=0}}", 2,
     ["--method levelset{{steps=0}}", "steps must be a whole number from 1 to 1000000, not 0"], ""),
    ("method parameter fraction", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{steps=1.5}}", 2, "whole number", ""),
    ("method parameter text", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{steps=many}}", 2, "not many", ""),
    ("method parameter without value", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{steps}}", 2, "no value is given", ""),
    ("method parameter twice", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{steps=1,steps=2}}", 2, "given twice", ""),
    ("method braces empty", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{}}", 2, "nothing stands in the braces", ""),
    ("method braces open", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method levelset{{steps=1", 2, ["levelset{{steps=1:", "{{NAME=VALUE,...}}"], ""),
    ("method unknown in braces", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --method melt{{x=1}}", 2, ["melt{{x=1}}", "levelset"], ""),
    ("radial of two parts", "morph {d}/a.obj {d}/two.obj -o {o}/m.####.vdb --resolution 24 --method radial", 2,
     ["'two' is not star-shaped", "--method slices"], ""),
    ("radial tangents of three", "morph {d}/a.obj {d}/b.obj {d}/a.obj -o {o}/m.vdb --weights 1,1,1 --resolution 24 --method radial{{tangent=1}}", 2,
     "choose tangent=0", ""),
    ("cylindrical of two parts", "morph {d}/a.obj {d}/two.obj -o {o}/m.####.vdb --resolution 24 --method cylindrical", 2,
     "'two' is not star-shaped about its axis", ""),
    ("warp without features", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --resolution 24 --method feature-warp", 2,
     ["needs features", "slicemorph pick"], ""),
    ("features of radial", "morph --config {d}/warp.toml --method radial -o {o}/m.####.vdb", 2,
     ["[[feature]] is for --method slices or feature-warp", "not for radial"], ""),
    ("dissolve of meshes", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.ply --method dissolve", 2, "makes no surface", ""),
    ("velocity unit", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --velocity-unit hour", 2, "--velocity-unit", ""),
    ("no sequence", "morph {d}/none.####.vdb {d}/b.obj -o {o}/m.####.vdb", 1, ["none.####.vdb", "no such files"], ""),
    ("levelset at", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --method levelset --at 0.5", 2, "--frames", ""),
    ("fps zero", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --fps 0", 2, "--fps 0", ""),
    ("threads zero", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --threads 0", 2, "--threads 0", ""),
    ("report extension", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --report {o}/r.txt", 2, ".json", ""),
    ("report folder", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --report {o}/no/r.json", 1, "does not exist", ""),
]

MORPH_OPTIONS = ("--frames --start --range --at --weights --voxel-size --resolution --slices --samples --axis --spine --align --iso --method --fps "
                 "--threads --report --config --quiet --verbose --resume --dump-slices --keys --timing --ease --interpolation "
                 "--print-config --glb-up --glb-unit --grids --conserve --velocity --velocity-unit --add-velocity").split()

BAD_INPUT = [
    ("missing file", "convert {d}/no.obj -o {o}/m.vdb", 1, "no.obj", ""),
    ("missing second file", "morph {d}/a.obj {d}/no.obj -o {o}/m.####.vdb", 1, "no.obj", ""),
    ("input a folder", "convert {d} -o {o}/m.vdb", (1, 2), "slicemorph: ", ""),
    ("input extension", "convert {d}/text.txt -o {o}/m.vdb", 2, "text.txt", ""),
    ("output extension", "convert {d}/a.obj -o {o}/m.xyz", 2, ".xyz", ""),
    ("output without extension", "convert {d}/a.obj -o {o}/m", 2, "{o}/m", ""),
    ("empty obj", "convert {d}/empty.obj -o {o}/m.vdb", 1, "empty.obj", ""),
    ("empty vdb", "convert {d}/empty.vdb -o {o}/m.obj", 1, "empty.vdb", ""),
    ("no triangles", "convert {d}/points.obj -o {o}/m.vdb", 1, "points.obj", ""),
    ("truncated obj", "convert {d}/cut.obj -o {o}/m.vdb", 1, "cut.obj", ""),
    ("obj cut after a face", "convert {d}/half.obj -o {o}/m.vdb --resolution 40", 0, ["half.obj", "the surface is open"], "m.vdb"),
    ("obj cut before its points", "convert {d}/early.obj -o {o}/m.vdb", 1, ["early.obj", "refers to vertex"], ""),
    ("one sheet", "convert {d}/sheet.obj -o {o}/m.vdb --resolution 40 --shell 0.12", 0, "its only shell is a sheet", "m.vdb"),
    ("truncated ply", "convert {d}/cut.ply -o {o}/m.vdb", 1, "cut.ply", ""),
    ("truncated stl", "convert {d}/cut.stl -o {o}/m.vdb", 1, "cut.stl", ""),
    ("truncated vdb", "convert {d}/cut.vdb -o {o}/m.obj", 1, "cut.vdb", ""),
    ("text as vdb", "convert {d}/text.vdb -o {o}/m.obj", 1, "text.vdb", ""),
    ("nan vertices", "convert {d}/nan.obj -o {o}/m.vdb", 1, "nan.obj", ""),
    ("sheet", "convert {d}/sheet.obj -o {o}/m.vdb --resolution 40", 1, ["sheet.obj", "the surface is open", "encloses nothing", "--shell 0.12"], ""),
    ("sheet with thickness", "convert {d}/sheet.obj -o {o}/m.vdb --resolution 40 --shell 0.12", 0, "made 0.12 thick", "m.vdb"),
    ("sheet too thin", "convert {d}/sheet.obj -o {o}/m.vdb --resolution 40 --shell 0.01", 2, ["--shell 0.01", "use at least"], ""),
    ("thickness 0", "convert {d}/sheet.obj -o {o}/m.vdb --shell 0", 2, "--shell 0", ""),
    ("open bowl", "convert {d}/bowl.obj -o {o}/m.vdb --resolution 40", 0, ["bowl.obj", "the surface is open", "winding number"], "m.vdb"),
    ("bowl and sheet", "convert {d}/bowl_and_sheet.obj -o {o}/m.vdb --resolution 40", 0, ["1 of 2 shells is a sheet", "left out; --shell"], "m.vdb"),
    ("index out of range", "convert {d}/index.obj -o {o}/m.vdb", 1, "index.obj", ""),
    ("grid not there", "convert {d}/a.vdb:density -o {o}/m.obj", 2, ["density", "surface"], ""),
    ("iso outside", "convert {d}/a.vdb --iso 1000 -o {o}/m.obj", (1, 2), "a.vdb", ""),
    ("output folder missing", "convert {d}/a.obj -o {o}/no/m.vdb", 1, "{o}/no", ""),
    ("output is a folder", "convert {d}/a.obj -o {o}", (1, 2), "{o}", ""),
    ("info missing", "info {d}/no.vdb", 1, "no.vdb", ""),
    ("info truncated", "info {d}/cut.stl", 1, "cut.stl", ""),
    ("compare missing", "compare {d}/a.obj {d}/no.obj", 1, "no.obj", ""),
    ("render missing sequence", "render {d}/no.####.vdb -o {o}/r.####.png", 1, "no.####.vdb", ""),
    ("render size", "render {d}/a.vdb -o {o}/r.png --size big", 2, "--size big", ""),
    ("render extension", "render {d}/a.vdb -o {o}/r.bmp", 2, [".bmp", ".png"], ""),
    ("render zero size", "render {d}/a.vdb -o {o}/r.png --size 0x480", 2, ["--size 0x480", "1 to 16384"], ""),
    ("render zero resolution", "render {d}/a.vdb -o {o}/r.png --resolution 0x480", 2, "--resolution 0x480", ""),
    ("render no resolution", "render {d}/a.vdb -o {o}/r.png --resolution big", 2, ["--resolution big", "640x480"], ""),
    ("render voxels", "render {d}/a.obj -o {o}/r.png --resolution 4", 2, ["--resolution 4", "8 to"], ""),
    ("render fov", "render {d}/a.vdb -o {o}/r.png --fov 180", 2, ["--fov 180", "1 to 170"], ""),
    ("render fov and ortho", "render {d}/a.vdb -o {o}/r.png --fov 30 --ortho", 2, ["--fov", "--ortho", "exclude"], ""),
    ("render camera inside", "render {d}/a.vdb -o {o}/r.png --camera 0,0,0.01", 2, ["a.vdb", "[0, 0, 0.01]", "inside"], ""),
    ("render camera text", "render {d}/a.vdb -o {o}/r.png --camera here", 2, "--camera here", ""),
    ("render camera and view", "render {d}/a.vdb -o {o}/r.png --camera 0,0,9 --view x", 2, "exclude", ""),
    ("render look-at alone", "render {d}/a.vdb -o {o}/r.png --look-at 0,0,9", 2, "--camera", ""),
    ("render view along up", "render {d}/a.vdb -o {o}/r.png --view z --up z", 2, ["--view z", "--up z"], ""),
    ("render light", "render {d}/a.vdb -o {o}/r.png --light 0,0,0", 2, "--light 0,0,0", ""),
    ("render light intensity", "render {d}/a.vdb -o {o}/r.png --light-intensity -1", 2, "--light-intensity -1", ""),
    ("render albedo", "render {d}/a.vdb -o {o}/r.png --albedo 2", 2, ["--albedo 2", "0 to 1"], ""),
    ("render extinction", "render {d}/a.vdb -o {o}/r.png --extinction 0", 2, "--extinction 0", ""),
    ("render emission", "render {d}/a.vdb -o {o}/r.png --emission nan", 2, "--emission nan", ""),
    ("render turntable", "render {d}/a.vdb -o {o}/r.####.png --turntable 0", 2, "--turntable 0", ""),
    ("render turntable of one file", "render {d}/a.vdb -o {o}/r.png --turntable 4", 2, ["4 pictures", "####"], ""),
    ("render fps", "render {d}/a.vdb -o {o}/r.png --fps 0", 2, "--fps 0", ""),
    ("render numbered film", "render {d}/a.vdb -o {o}/r.####.gif", 2, "leave out the ####", ""),
    ("render folder missing", "render {d}/a.vdb -o {o}/no/r.png", 1, "{o}/no", ""),
    ("render missing grid", "render {d}/a.vdb:wood -o {o}/r.png", 2, "'wood'", ""),
    ("slice none", "slice {d}/a.vdb -o {o}/s.####.exr --slices 0", 2, ["--slices 0", "1 to"], ""),
    ("slice outside", "slice {d}/a.vdb -o {o}/s.exr --plane 0,0,50/0,0,1", 2, ["0,0,50", "does not cut"], ""),
    ("slice plane", "slice {d}/a.vdb -o {o}/s.exr --plane 0,0,1", 2, ["--plane 0,0,1", "OX,OY,OZ/NX,NY,NZ"], ""),
    ("slice plane file", "slice {d}/a.vdb -o {o}/s.exr --planes {d}/syntax.toml", 2, "syntax.toml", ""),
    ("slice grid", "slice {d}/a.vdb -o {o}/s.exr --grids density", 2, ["a.vdb", "'density'", "surface"], ""),
    ("slice compression", "slice {d}/a.vdb -o {o}/s.exr --compression lzw", 2, ["--compression", "lzw"], ""),
    ("slice tiles", "slice {d}/a.vdb -o {o}/s.exr --tiles 1", 2, "--tiles 1", ""),
    ("slice folder", "slice {d}/a.vdb -o {o}/no/s.exr", 1, "{o}/no", ""),
    ("slice ways", "slice {d}/a.vdb -o {o}/s.exr --axis x --spine", 2, "exclude", ""),
    ("slice voxels", "slice {d}/a.vdb -o {o}/s.exr --voxel-size 1", 2, "--pixel-size", ""),
    ("reconstruct no slices", "reconstruct {d}/no.####.exr -o {o}/m.vdb", 1, ["no.####.exr", "no such files"], ""),
    ("reconstruct plain exr", "reconstruct {d}/plain.exr -o {o}/m.vdb", 1, ["plain.exr", "sliceOrigin"], ""),
    ("reconstruct cut exr", "reconstruct {d}/cut.exr -o {o}/m.vdb", 1, "cut.exr", ""),
    ("reconstruct unknown grid", "reconstruct {d}/s.exr -o {o}/m.vdb --grids heat", 2, ["'heat'", "surface"], ""),
    ("reconstruct large voxels", "reconstruct {d}/s.exr -o {o}/m.vdb --voxel-size 1", 2, ["s.exr", "at most"], ""),
]

CONFIG = [
    ("config missing", "morph --config {d}/no.toml", 1, "no.toml", ""),
    ("config syntax", "morph --config {d}/syntax.toml", 2, "syntax.toml:2:", ""),
    ("config unknown key", "morph --config {d}/unknown.toml", 2, ["unknown.toml:2:1", "sices", "slices"], ""),
    ("config wrong type", "morph --config {d}/type.toml", 2, ["type.toml:1:10", "whole number"], ""),
    ("config wrong choice", "morph --config {d}/choice.toml", 2, ["choice.toml:3:", "method"], ""),
    ("config wrong parameter", "morph --config {d}/parameter.toml", 2, ["parameter.toml:3:", "steps", "1 to 1000000"], ""),
    ("config runs", "morph --config {d}/job.toml -o {o}/c.####.obj", 0, "", ["c.0001.obj", "c.0002.obj"]),
    ("command line wins", "morph --config {d}/job.toml --at 0.5 -o {o}/c.ply", 0, "", "c.ply"),
]

WORKS = [
    ("convert to vdb", "convert {d}/a.obj -o {o}/m.vdb --resolution 32", 0, "", "m.vdb"),
    ("convert to stl", "convert {d}/a.vdb -o {o}/m.stl", 0, "", "m.stl"),
    ("morph", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 3 --resolution 24", 0, "",
     ["m.0001.vdb", "m.0002.vdb", "m.0003.vdb"]),
    ("morph quiet", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --at 0.5 --resolution 24 --method sdf --quiet", 0, "^$", "^$"),
    ("morph of three", "morph {d}/a.obj {d}/b.obj {d}/a.vdb -o {o}/m.obj --weights 0.2,0.3,0.5 --resolution 24", 0, "",
     "m.obj"),
    ("weights sum", "morph {d}/a.obj {d}/b.obj -o {o}/m.obj --weights 1,3 --resolution 24 --method sdf", 0,
     "note: --weights 1,3 sum to 4: taken as 0.25,0.75", "m.obj"),
    ("morph by keys", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.obj --keys b@0,a@0.5,b@1 --timing catmull-rom --ease in-out "
     "--frames 3 --resolution 24 --method sdf", 0, "", ["m.0001.obj", "m.0003.obj"]),
    ("sdf", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.stl --frames 2 --resolution 24 --method sdf", 0, "", "m.0002.stl"),
    ("levelset", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.ply --frames 3 --resolution 24 --method levelset", 0, "",
     "m.0003.ply"),
    ("levelset of few steps", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.ply --frames 3 --resolution 24 --method levelset{{steps=2}}", 0,
     "came to rest after 2 steps", "m.0003.ply"),
    ("radial", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.stl --frames 2 --resolution 24 --method radial", 0, "", "m.0002.stl"),
    ("radial by tangents", "morph {d}/a.obj {d}/b.obj -o {o}/m.stl --at 0.5 --resolution 24 --method radial{{tangent=1}}", 0, "", "m.stl"),
    ("contour-mean", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.stl --frames 2 --resolution 24 --slices 24 --axis z --method contour-mean", 0, "",
     "m.0002.stl"),
    ("contour-median of three", "morph {d}/a.obj {d}/two.obj {d}/b.obj -o {o}/m.stl --weights 1,1,1 --resolution 24 --method contour-median", 0, "",
     "m.stl"),
    ("contour-mode", "morph {d}/a.obj {d}/b.obj -o {o}/m.stl --at 0.5 --resolution 24 --method contour-mode{{width=0.2}}", 0, "", "m.stl"),
    ("slices-plain", "morph {d}/a.obj {d}/two.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method slices-plain", 0, "", "m.0002.vdb"),
    ("cylindrical", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.stl --frames 2 --resolution 24 --method cylindrical", 0, "", "m.0002.stl"),
    ("feature-warp", "morph --config {d}/warp.toml -o {o}/m.####.vdb", 0, "", "m.0002.vdb"),
    ("morphology", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method morphology", 0, "", "m.0002.vdb"),
    ("minkowski", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method minkowski{{directions=16}}", 0, "", "m.0002.vdb"),
    ("minkowski of two parts", "morph {d}/a.obj {d}/two.obj -o {o}/m.vdb --at 0.5 --resolution 16 --method minkowski", 0, "", "m.vdb"),
    ("fourier", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method fourier{{fade=0.4,cutoff=8}}", 0, "", "m.0002.vdb"),
    ("wavelet", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method wavelet{{levels=3}}", 0, "", "m.0002.vdb"),
    ("bounded-blend", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method bounded-blend{{gap=0.2,stay=0.3}}", 0, "", "m.0002.vdb"),
    ("variational", "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 2 --resolution 24 --method variational{{points=60}}", 0, "", "m.0002.vdb"),
    ("compare", "compare {d}/a.obj {d}/b.obj --resolution 24", 0, "", ["distance", "volume", "dice"]),
    ("info mesh", "info {d}/a.obj", 0, "", ["points", "closed"]),
    ("info vdb", "info {d}/a.vdb", 0, "", ["surface", "level set"]),
    ("render", "render {d}/a.vdb {d}/b.obj --resolution 24 -o {o}/r.####.png --contact-sheet {o}/all.png --size 40x30",
     0, "", ["r.0001.png", "r.0002.png", "all.png"]),
    ("render turntable", "render {d}/a.vdb -o {o}/r.####.exr --turntable 3 --resolution 40x30 --up z --ortho --quiet", 0,
     "^$", "^$"),
    ("render from a place", "render {d}/a.vdb -o {o}/r.png --camera 4,1,5 --look-at 0,0,0 --fov 60 --size 40x30 "
     "--light -1,-1,-1 --light-intensity 2 --transparent", 0, "", "r.png"),
    ("slice", "slice {d}/a.vdb -o {o}/s.####.exr --slices 3 --axis y", 0, "", ["s.0001.exr", "s.0003.exr"]),
    ("slice parts", "slice {d}/a.vdb -o {o}/s.exr --slices 3 --half --tiles 32 --compression piz", 0, "", "s.exr"),
    ("slice mesh", "slice {d}/a.obj -o {o}/s.####.exr --slices 2 --resolution 24 --spine", 0, "", "s.0002.exr"),
    ("reconstruct slices", "reconstruct {d}/s.exr -o {o}/m.vdb", 0, "", "m.vdb"),
    ("reconstruct slices to mesh", "reconstruct {d}/s.exr -o {o}/m.ply", 0, "", "m.ply"),
    ("dump slices", "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --at 0.5 --resolution 24 --dump-slices {o}/svg", 0, "", ""),
]


def ellipsoid(rx, ry, rz, n=16):
    """Points and triangles, wound outwards."""
    points = [(0, 0, rz), (0, 0, -rz)]
    for i in range(1, n):
        for j in range(2 * n):
            a, b = math.pi * i / n, math.pi * j / n
            points.append((rx * math.sin(a) * math.cos(b), ry * math.sin(a) * math.sin(b), rz * math.cos(a)))
    ring = lambda i, j: 2 + (i - 1) * 2 * n + j % (2 * n)
    faces = []
    for j in range(2 * n):
        faces += [(0, ring(1, j), ring(1, j + 1)), (1, ring(n - 1, j + 1), ring(n - 1, j))]
        for i in range(1, n - 1):
            a, b, c, d = ring(i, j), ring(i + 1, j), ring(i + 1, j + 1), ring(i, j + 1)
            faces += [(a, b, c), (a, c, d)]
    return points, faces


def volume_of(points, faces):
    total = 0
    for f in faces:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (points[i] for i in f)
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6


def obj_text(points, faces):
    vertices = "".join("v %.6f %.6f %.6f\n" % p for p in points)
    return vertices + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)


def write(path, data):
    with open(path, "wb") as f:
        f.write(data if isinstance(data, bytes) else data.encode())


def make_inputs(d):
    points, faces = ellipsoid(1, 0.8, 0.6)
    a = obj_text(points, faces)
    write(d + "/a.obj", a)
    write(d + "/b.obj", obj_text(*ellipsoid(0.5, 0.7, 1.1)))
    beside = [(x + 3, y, z) for x, y, z in points]
    write(d + "/two.obj", obj_text(points + beside, faces + [tuple(i + len(points) for i in f) for f in faces]))
    write(d + "/empty.obj", "")
    write(d + "/empty.vdb", "")
    write(d + "/text.txt", "not a shape\n")
    write(d + "/text.vdb", "not a volume, but long enough to hold a header of one\n" * 20)
    write(d + "/points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    # Cut in the list of faces, within a line: half the surface is missing.
    write(d + "/cut.obj", a[: a.index("f ") + (len(a) - a.index("f ")) // 2])
    # After a whole face, which looks like an open surface; and faces of points that are not there.
    write(d + "/half.obj", a[: a.index("\n", a.index("f ") + (len(a) - a.index("f ")) // 2) + 1])
    write(d + "/early.obj", a[: a.index("v ", len(a) // 4)] + a[a.index("f "):])
    sheet = ([(0, 0, 2), (2, 0, 2), (2, 1, 2), (0, 1, 2)], [(0, 1, 2), (0, 2, 3)])
    bowl = [f for f in faces if all(points[i][2] < 0.2 for i in f)]
    write(d + "/sheet.obj", obj_text(*sheet))
    write(d + "/bowl.obj", obj_text(points, bowl))
    both = [tuple(i + len(points) for i in f) for f in sheet[1]]
    write(d + "/bowl_and_sheet.obj", obj_text(points + sheet[0], bowl + both))
    write(d + "/nan.obj", re.sub(r"v \S+", "v nan", a, count=5))
    write(d + "/index.obj", a + "f 1 2 999999\n")
    ply = b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(points)
    ply += b"property float x\nproperty float y\nproperty float z\n"
    ply += b"element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(faces)
    ply += b"".join(struct.pack("<3f", *p) for p in points)
    ply += b"".join(struct.pack("<B3i", 3, *f) for f in faces)
    write(d + "/cut.ply", ply[: len(ply) * 2 // 3])
    stl = bytes(80) + struct.pack("<I", len(faces))
    for f in faces:
        stl += struct.pack("<12fH", 0, 0, 0, *[c for i in f for c in points[i]], 0)
    write(d + "/cut.stl", stl[: len(stl) // 2])
    run("convert {d}/a.obj -o {d}/a.vdb --resolution 24", {"d": d}).check_returncode()
    with open(d + "/a.vdb", "rb") as f:
        vdb = f.read()
    write(d + "/cut.vdb", vdb[: len(vdb) // 2])
    run("slice {d}/a.vdb -o {d}/s.exr --slices 24", {"d": d}).check_returncode()
    run("render {d}/a.vdb -o {d}/plain.exr --size 8x8", {"d": d}).check_returncode()
    with open(d + "/s.exr", "rb") as f:
        exr = f.read()
    write(d + "/cut.exr", exr[: len(exr) // 2])
    write(d + "/syntax.toml", "frames = 3\nresolution = = 24\n")
    write(d + "/unknown.toml", "frames = 3\nsices = 24\n")
    write(d + "/type.toml", 'frames = "three"\n')
    write(d + "/parameter.toml", 'inputs = ["a.obj", "b.obj"]\noutput = "m.####.vdb"\nmethod = "levelset{steps=0}"\n')
    write(d + "/choice.toml", 'inputs = ["a.obj", "b.obj"]\noutput = "m.####.vdb"\nmethod = "magic"\n')
    write(d + "/warp.toml", 'inputs = ["%s/a.obj", "%s/b.obj"]\nframes = 2\nresolution = 24\nmethod = "feature-warp"\n'
          "[[feature]]\npoint = [[0, 0, 0.5], [0, 0, 1]]\n[[feature]]\nline = [[[0, 0, 0], [0, 0.5, 0]], [[0, 0, 0], [0, 0.7, 0]]]\n" % (d, d))
    job = 'inputs = ["%s/a.obj", "%s/b.obj"]\nframes = 2\nresolution = 24\nquiet = false\n' % (d, d)
    write(d + "/job.toml", job)


def run(arguments, folders, **more):
    words = [w.format(**folders) for w in arguments.split()]
    return subprocess.run([PROGRAM] + words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=120,
                          universal_newlines=True, errors="replace", **more)


def problems_of(result, code, err, out, folders):
    problems = []
    if result.returncode not in (code if isinstance(code, tuple) else (code,)):
        problems.append("exit code %s, expected %s" % (result.returncode, code))
    for stream, name, texts in ((result.stderr, "stderr", err), (result.stdout, "stdout", out)):
        for text in texts if isinstance(texts, list) else [texts]:
            text = text.format(**folders)
            if (text == "^$" and stream) or (text != "^$" and text not in stream):
                problems.append("%s lacks '%s'" % (name, text))
    if result.returncode and not result.stderr.startswith("slicemorph: ") and "note: " not in result.stderr:
        problems.append("stderr does not start with 'slicemorph: '")
    if result.returncode and os.listdir(folders["o"]):
        problems.append("left behind: %s" % os.listdir(folders["o"]))
    if problems:
        problems.append("stderr: %s" % result.stderr.strip()[:500])
    return problems


def table_case(case, d, o):
    name, arguments, code, err, out = case
    folders = {"d": d, "o": o}
    try:
        return problems_of(run(arguments, folders), code, err, out, folders)
    except subprocess.TimeoutExpired:
        return ["took longer than two minutes"]


class Skip(Exception):
    pass


def mount_small(folder, options):
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder],
                                           stderr=subprocess.DEVNULL).returncode:
        raise Skip("mounting is not allowed here")


def read_only_folder(d, o):
    """A folder that cannot be written to; for root that takes a read-only file system."""
    mounted = os.geteuid() == 0
    if mounted:
        mount_small(o, "ro,size=64k")
    else:
        os.chmod(o, 0o555)
    try:
        folders = {"d": d, "o": o}
        return problems_of(run("morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb", folders), 1, "{o}", "", folders)
    finally:
        subprocess.run(["umount", o]) if mounted else os.chmod(o, 0o755)


def disk_full(d, o):
    """On a full disk neither a volume nor a mesh leaves a partial file."""
    mount_small(o, "size=48k")
    try:
        folders = {"d": d, "o": o}
        result = run("convert {d}/a.obj --resolution 64 -o {o}/m.vdb", folders)
        problems = problems_of(result, 1, ["m.vdb", "space"], "", folders)
        result = run("convert {d}/a.obj --resolution 64 -o {o}/m.obj", folders)
        return problems + problems_of(result, 1, "m.obj", "", folders)
    finally:
        subprocess.run(["umount", o])


def empty_grid(d, o):
    """A VDB file whose only grid has no active voxel."""
    script = "import pyopenvdb as v, sys; v.write(sys.argv[1], grids=[v.FloatGrid(1.0)])"
    # Debian's module belongs to Debian's interpreter.
    command = ["/usr/bin/python3", "-c", script, d + "/hollow.vdb"]
    if subprocess.run(command, stderr=subprocess.DEVNULL).returncode:
        raise Skip("python3-openvdb is not there to write the file")
    folders = {"d": d, "o": o}
    return problems_of(run("convert {d}/hollow.vdb -o {o}/m.obj", folders), 1, "hollow.vdb", "", folders)


def options_of(help_text):
    """The text of every option in a help, and its groups in order."""
    options, groups, name = {}, [], None
    for line in help_text.split("\n"):
        start = re.match(r"  (-\w,)?(--[\w-]+)", line)
        if start:
            name = start.group(2)
        elif not line.startswith("  "):
            groups += re.findall(r"^(\w+):$", line)
            name = None
        if name:
            options[name] = options.get(name, "") + " " + line.strip()
    return options, groups


def help_of_all_options(d, o):
    """Help has groups; --help-all has all options with defaults, --help some of them in the same words."""
    problems = []
    order = ["Inputs", "Shape", "Matching", "Outputs", "Images", "Pictures", "Farm", "Methods", "Help"]
    for command in ("morph", "slice", "reconstruct", "convert", "render", "compare", "info", "pick"):
        short, all_of_it = (options_of(run(command + word, {}).stdout) for word in (" --help", " --help-all"))
        for options, groups in (short, all_of_it):
            if groups != [g for g in order if g in groups] or "Inputs" not in groups:
                problems.append("%s: groups %s" % (command, groups))
        for name, text in all_of_it[0].items():
            # Only required options have no default.
            if "default " not in text and name not in ("--help", "--help-all") and "REQUIRED" not in text:
                problems.append("%s: no default: %s" % (command, text))
        if any(all_of_it[0].get(name) != text for name, text in short[0].items()):
            problems.append("%s: --help is no part of --help-all" % command)
    if "steps: " not in run("morph --help-all", {}).stdout.partition("\nMethods:\n")[2]:
        problems.append("morph --help-all lacks the parameters of methods")
    morph = [len(options_of(run("morph " + word, {}).stdout)[0]) for word in ("--help", "--help-all")]
    for option in MORPH_OPTIONS:
        if option not in options_of(run("morph --help-all", {}).stdout)[0]:
            problems.append("morph --help-all lacks " + option)
    return problems + (["%d of %d options are not few" % tuple(morph)] if 2 * morph[0] > morph[1] else [])


def version_is_the_projects(d, o):
    """The version that the program prints is that of the CMake project."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../CMakeLists.txt")) as f:
        version = re.search(r"project\(slicemorph VERSION (\S+)", f.read()).group(1)
    said = run("--version", {}).stdout
    return [] if said == "slicemorph %s\n" % version else ["%s is not %s" % (said, version)]


def verbose_says_more(d, o):
    """Every note that is printed by default is printed with --verbose, and --quiet prints none."""
    words = "morph {d}/a.obj {d}/b.obj -o {o}/m.vdb --at 0.5 --resolution 24 "
    usual, verbose, quiet = (run(words + w, {"d": d, "o": o}).stderr.split("\n")[:-1] for w in ("", "--verbose", "--quiet"))
    problems = ["not with --verbose: " + line for line in usual if line not in verbose]
    return problems + (["with --quiet: %s" % quiet] if quiet else [])


def report_holds(d, o):
    """The report's figures of a morph whose end frames are the inputs."""
    folders = {"d": d, "o": o}
    words = "morph {d}/a.obj {d}/b.obj -o {o}/m.####.obj --frames 3 --resolution 32"
    result = run(words + " --report {o}/r.json", folders)
    problems = problems_of(result, 0, "", "", folders)
    if problems:
        return problems
    with open(o + "/r.json") as f:
        report = json.load(f)
    for key in ("settings", "inputs", "notes", "frames", "summary", "plan", "seconds", "peakMemoryBytes"):
        if key not in report:
            problems.append("report lacks " + key)
    for i, frame in enumerate(report["frames"]):
        if frame["frame"] != i + 1 or frame["t"] != i / 2 or frame["pieces"] != 1 or frame["genus"] != 0:
            problems.append("frame %d: %s" % (i + 1, frame))
    # Ellipsoids morph without crumpling, and their map stretches no part threefold.
    for frame in report["frames"]:
        if frame["areaRatio"] > 1.02 or frame["stretch"]["shareBeyond3"] > 0 or not 1 <= frame["stretch"]["mean"] < 1.5:
            problems.append("stretch of frame %d: %s" % (frame["frame"], frame["stretch"]))
    if not 0.9 < report["plan"]["overlap"] <= 1:
        problems.append("overlap %s" % report["plan"])
    # Vertices lie at most h^2 / 4 R below a surface of curvature radius R, facets h^2 / 6 R more in the mean.
    for index, axes in ((0, (1, 0.8, 0.6)), (2, (0.5, 0.7, 1.1))):
        frame, exact = report["frames"][index], volume_of(*ellipsoid(*axes))
        depth = 5 / 12 * frame["voxelSize"] ** 2 / (min(axes) ** 2 / max(axes))
        if abs(frame["volume"] - exact) > frame["area"] * depth:
            problems.append("volume %g of a polyhedron of %g" % (frame["volume"], exact))
    return problems


def resume_keeps_frames(d, o):
    """An interrupted sequence is continued: only missing frames are made, and the log is removed."""
    folders = {"d": d, "o": o}
    words = "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 60 --resolution 48 --method sdf"
    command = [PROGRAM] + [w.format(**folders) for w in words.split()]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               universal_newlines=True)
    deadline = time.time() + 100
    while process.poll() is None and not os.path.exists(o + "/m.0003.vdb") and time.time() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    err = process.communicate(timeout=100)[1]
    if process.returncode == 0:
        raise Skip("the morph was over before it could be interrupted")
    problems = []
    if process.returncode != 1 or "slicemorph: cancelled" not in err:
        problems.append("interrupted: exit code %s, stderr %s" % (process.returncode, err))
    if [n for n in os.listdir(o) if ".tmp" in n]:
        problems.append("interrupted, left behind: %s" % os.listdir(o))
    if not os.path.exists(o + "/m.0001.vdb"):
        raise Skip("no frame was made in time")
    first = os.stat(o + "/m.0001.vdb").st_mtime_ns
    result = run(words + " --resume", folders)
    problems += problems_of(result, 0, "", ["m.0001.vdb (kept)", "m.0060.vdb\n"], folders)
    if os.stat(o + "/m.0001.vdb").st_mtime_ns != first:
        problems.append("frame 1 was made again")
    if len(os.listdir(o)) != 60:
        problems.append("expected 60 files: %s" % sorted(os.listdir(o)))
    result = run(words.replace("resolution 48", "resolution 40") + " --resume", folders)
    if "(kept)" in result.stdout:
        problems.append("frames of other settings were kept")
    return problems


def parameters_of_methods_count(d, o):
    """--resume keeps frames of the same parameters alone, and reports name them, defaults too."""
    folders = {"d": d, "o": o}
    words = "morph {d}/a.obj {d}/b.obj -o {o}/m.####.ply --frames 4 --range 1-2 --resolution 24 --report {o}/r.json --method levelset"
    problems = problems_of(run(words + "{{steps=5}}", folders), 0, "", ["m.0001.ply", "m.0002.ply"], folders)
    problems += problems_of(run(words + "{{steps=5}} --resume", folders), 0, "", ["m.0001.ply (kept)", "m.0002.ply (kept)"], folders)
    with open(o + "/r.json") as file:
        if json.load(file)["settings"].get("parameters") != {"steps": 5}:
            problems.append("the report does not say steps = 5")
    result = run(words + "{{steps=6}} --resume", folders)
    problems += problems_of(result, 0, "other settings", "m.0001.ply", folders)
    if "(kept)" in result.stdout:
        problems.append("frames of other parameters were kept")
    run(words, folders)
    with open(o + "/r.json") as file:
        if json.load(file)["settings"].get("parameters") != {"steps": 2000}:
            problems.append("the report does not say the default")
    return problems


def resume_of_another_program(d, o):
    """Frames of another version or build are made again, and a note says why."""
    folders = {"d": d, "o": o}
    words = "morph {d}/a.obj {d}/b.obj -o {o}/m.####.vdb --frames 40 --resolution 24 --method sdf"
    process = subprocess.Popen([PROGRAM] + [w.format(**folders) for w in words.split()],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    log = o + "/.m.####.vdb.slicemorph"
    deadline = time.time() + 100
    while process.poll() is None and not os.path.exists(log) and time.time() < deadline:
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    process.wait(timeout=100)
    if not os.path.exists(log):
        raise Skip("the morph was over before it could be interrupted")
    with open(log) as file:
        lines = [json.loads(line) for line in file if line.strip()]
    with open(log, "w") as file:
        for line in lines:
            file.write(json.dumps({**line, "program": "0.0.1"}) + "\n")
    result = run(words + " --resume", folders)
    if "(kept)" in result.stdout:
        return ["frames of version 0.0.1 were kept"]
    return problems_of(result, 0, "made by version 0.0.1", "m.0040.vdb\n", folders)


def threads_do_not_matter(d, o):
    """The same bytes for one and for two threads."""
    for threads in (1, 2):
        os.mkdir("%s/%d" % (o, threads))
        words = "morph {d}/a.obj {d}/b.obj -o {o}/%d/m.####.vdb --frames 3 --resolution 32 --threads %d"
        result = run(words % (threads, threads), {"d": d, "o": o})
        if result.returncode:
            return [result.stderr]
    differing = []
    for name in sorted(os.listdir(o + "/1")):
        with open("%s/1/%s" % (o, name), "rb") as f, open("%s/2/%s" % (o, name), "rb") as g:
            if f.read() != g.read():
                differing.append(name)
    return ["differ: %s" % differing] if differing else []


def render_empty_fog(d, o):
    """Fog without an active voxel is refused: there is nothing to see."""
    script = "import pyopenvdb as v, sys; g = v.FloatGrid(); g.name = 'density'; v.write(sys.argv[1], grids=[g])"
    if subprocess.run(["/usr/bin/python3", "-c", script, d + "/clear.vdb"], stderr=subprocess.DEVNULL).returncode:
        raise Skip("python3-openvdb is not there to write the file")
    folders = {"d": d, "o": o}
    return problems_of(run("render {d}/clear.vdb -o {o}/r.png", folders), 1, ["clear.vdb", "nothing to see"], "", folders)


def render_preview_without_ffmpeg(d, o):
    folders = {"d": d, "o": o}
    result = run("render {d}/a.vdb -o {o}/r.mp4", folders, env=dict(os.environ, PATH=o))
    return problems_of(result, 1, ["{o}/r.mp4", "ffmpeg", "{o}/r.####.png"], "", folders)


def render_preview_that_fails(d, o):
    """An error of ffmpeg is passed on, and no file is left."""
    tools = d + "/broken"
    os.mkdir(tools)
    write(tools + "/ffmpeg", "#!/bin/sh\necho no such coder >&2\nexit 1\n")
    os.chmod(tools + "/ffmpeg", 0o755)
    folders = {"d": d, "o": o}
    result = run("render {d}/a.vdb -o {o}/r.mp4 --size 40x30", folders, env=dict(os.environ, PATH=tools))
    return problems_of(result, 1, ["{o}/r.mp4", "no such coder"], "", folders)


def render_previews(d, o):
    """Both kinds of video hold all pictures, have the given size and
    rate, and are the same bytes every time."""
    if not shutil.which("ffmpeg") or not shutil.which("ffprobe"):
        raise Skip("ffmpeg is not installed")
    problems = []
    for name in ("r.gif", "r.mp4"):
        kept = []
        for threads in (1, 2):
            words = "render {d}/a.vdb -o {o}/%s --turntable 5 --fps 10 --size 41x30 --threads %d" % (name, threads)
            problems += problems_of(run(words, {"d": d, "o": o}), 0, "", name, {"d": d, "o": o})
            with open(o + "/" + name, "rb") as f:
                kept.append(f.read())
        if kept[0] != kept[1]:
            problems.append(name + " differs from run to run")
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-of", "json",
                                "-show_entries", "stream=width,height,nb_read_frames,r_frame_rate", o + "/" + name],
                               stdout=subprocess.PIPE, universal_newlines=True).stdout
        # MP4 needs even sides, so there is one more black column.
        wanted = {"width": 42 if name == "r.mp4" else 41, "height": 30, "r_frame_rate": "10/1", "nb_read_frames": "5"}
        if json.loads(probe)["streams"] != [wanted]:
            problems.append("%s is %s" % (name, probe))
    return problems


SPECIAL = [help_of_all_options, version_is_the_projects, verbose_says_more, render_empty_fog, render_preview_without_ffmpeg, render_preview_that_fails, render_previews, read_only_folder, disk_full, empty_grid, report_holds, resume_keeps_frames, parameters_of_methods_count, resume_of_another_program, threads_do_not_matter]


def main():
    root = tempfile.mkdtemp(prefix="slicemorph-command-test-")
    d = root + "/in"
    os.mkdir(d)
    failed = run_count = skipped = 0
    try:
        make_inputs(d)
        cases = [(c[0], lambda o, c=c: table_case(c, d, o)) for c in USAGE + BAD_INPUT + CONFIG + WORKS]
        cases += [(f.__name__.replace("_", " "), lambda o, f=f: f(d, o)) for f in SPECIAL]
        for number, (name, check) in enumerate(cases):
            if ONLY and not any(word in name for word in ONLY):
                continue
            o = "%s/out%d" % (root, number)
            os.mkdir(o)
            run_count += 1
            try:
                problems = check(o)
            except Skip as reason:
                skipped += 1
                print("SKIPPED %s: %s" % (name, reason))
                continue
            if problems:
                failed += 1
                print("FAILED  %s" % name)
                for problem in problems:
                    print("        " + problem)
    finally:
        shutil.rmtree(root, ignore_errors=True)
    print("%d cases, %d failed, %d skipped" % (run_count, failed, skipped))
    return 1 if failed or not run_count else 0


if __name__ == "__main__":
    sys.exit(main())
