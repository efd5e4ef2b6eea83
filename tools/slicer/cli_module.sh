#!/bin/sh
# A command-line module of 3D Slicer, which is named as this file is. Slicer's launcher puts Slicer's own libraries before
# the system's, for which this program was built.
unset LD_LIBRARY_PATH ITK_AUTOLOAD_PATH
here=$(readlink -f "$0")
exec "${here%/*}/../slicemorph_slicer" "${here##*/}" "$@"
