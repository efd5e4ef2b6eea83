#!/usr/bin/env bash
# Draws the READMEs' rows of in-betweens anew into assets/pictures/ (those of the report and of Blender are screenshots).
# Usage: tools/dev/make_pictures.sh FOLDER [NAME...]     FOLDER: of the real meshes; NAME: only these pictures
set -euo pipefail
meshes=$(realpath "$1")
shift
cd "$(dirname "$0")/../.."
only=" $* "
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

wanted() { [ "$only" = "  " ] || [[ "$only" == *" $1 "* ]]; }

# row NAME PICTURE...: pictures side by side.
row() {
  local name=$1
  shift
  oiiotool "$@" --mosaic:pad=6 "$#x1" --ch R,G,B -o "assets/pictures/$name.png"
  echo "assets/pictures/$name.png"
}

# sequence NAME VIEW A B [OPTION...]: six times from A to B, each as large as the picture, seen along VIEW.
sequence() {
  local name=$1 view=$2 from=$3 to=$4 frame
  shift 4
  wanted "$name" || return 0
  rm -f "$work"/*
  build/slicemorph morph "$from" "$to" -o "$work/f.####.vdb" --frames 6 --velocity none --quiet "$@"
  for frame in 1 2 3 4 5 6; do
    build/slicemorph render "$work/f.000$frame.vdb" -o "$work/p.$frame.png" --size 260x250 --view="$view" --quiet
  done
  row "$name" "$work"/p.*.png
}

# blend NAME MESH...: meshes and their blend in equal shares.
blend() {
  local name=$1 shares=1 number=0 mesh
  shift
  wanted "$name" || return 0
  rm -f "$work"/*
  for mesh in "${@:2}"; do shares+=",1"; done
  build/slicemorph morph "$@" -o "$work/f.vdb" --weights "$shares" --velocity none --quiet
  for mesh in "$@" "$work/f.vdb"; do
    number=$((number + 1))
    build/slicemorph render "$mesh" -o "$work/p.$number.png" --size 260x250 --view="$front" --quiet
  done
  row "$name" "$work"/p.*.png
}

# retimed NAME SMOKE BEFORE TRUE AFTER: a frame before and the one after, between them a cross-dissolve, what `retime` makes, and
# the true one. SMOKE: pattern of the files, whose numbers have four digits.
retimed() {
  local name=$1 smoke=$2 before=$3 true=$4 after=$5 number=0 file
  wanted "$name" || return 0
  rm -f "$work"/*
  of() { printf '%s' "${smoke/\#\#\#\#/$(printf %04d "$1")}"; }
  build/slicemorph retime "$smoke@$before,$after" -o "$work/f.####.vdb" --range "$true" --grids density --quiet
  build/slicemorph morph "$(of "$before")" "$(of "$after")" -o "$work/mean.vdb" --at 0.5 --method dissolve --grids density --quiet
  for file in "$(of "$before")" "$work/mean.vdb" "$work/f.$(printf %04d "$true").vdb" "$(of "$true")" "$(of "$after")"; do
    number=$((number + 1))
    ln -s "$(realpath "$file")" "$work/all.$number.vdb"
  done
  build/slicemorph render "$work/all.#.vdb:density" -o "$work/p.#.png" --size 260x300 --view=0,0,-1 --up y --quiet
  row "$name" "$work"/p.?.png
}

a=assets front=-0.55,-0.3,-1 side=-1,-0.2,-0.35
sequence creature_to_ring $front $a/creature.ply $a/ring.ply
sequence creature_to_ring_sdf $front $a/creature.ply $a/ring.ply --method sdf
sequence horse_gallops $side "$meshes/horse_ref.obj" "$meshes/horse-01.obj"
sequence blade_to_creature $front $a/blade.ply $a/creature.ply
sequence man_to_woman $front "$meshes/human_man.obj" "$meshes/human_woman.obj"
sequence armadillo_to_man $front "$meshes/armadillo.obj" "$meshes/human_man.obj"
sequence horse_to_spot $side "$meshes/horse_ref.obj" "$meshes/spot.obj"
sequence spot_to_bob $front "$meshes/spot.obj" "$meshes/bob_small.ply"
sequence die_to_octahedron $front $a/die.ply $a/octahedron.ply
blend five_meshes "$meshes"/{stanford-bunny,armadillo,spot,horse_ref,human_woman}.obj
retimed smoke_retimed "$meshes/../vdb/c42_gas_####.vdb" 6 8 10
