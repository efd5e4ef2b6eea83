#!/usr/bin/env bash
# Makes assets/viewer/report.html, the page that `morph --report x.html` and `pick` fill in: tools/report/viewer/ and
# the parts of npm's three that it uses, bundled, minified, with their licence. Needs node and npm; packages
# go into a scratch folder.
set -euo pipefail
cd "$(dirname "$0")/../.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
npm install --silent --no-fund --no-audit --prefix "$scratch" three@0.187.0 esbuild@0.28.2
cp tools/report/viewer/*.mjs "$scratch/"
"$scratch"/node_modules/@esbuild/*/bin/esbuild "$scratch/viewer.mjs" --bundle --minify --format=iife --target=es2020 \
  --legal-comments=inline --outfile="$scratch/viewer.js" --log-level=warning
python3 - "$scratch" <<'END'
import sys
scratch = sys.argv[1]
page = open("tools/report/viewer/page.html").read()
script = open(scratch + "/viewer.js").read().replace("</script", "<\\/script")
licence = open(scratch + "/node_modules/three/LICENSE").read()
page = page.replace("/*SCRIPT*/", "/* three.js\n" + licence + "*/\n" + script)
open("assets/viewer/report.html", "w").write(page)
END
ls -l assets/viewer/report.html
