#!/bin/sh
# `make demo`: first a drive's bundled logs, from CSV to friction; then the paper from end to end. All is left in demo/.
set -eu
cd "$(dirname "$0")/.."
mkdir -p demo
run() { printf '\n$ %s\n' "$1"; eval "$1"; }
run "fric ingest data/strokes/*.csv --kind constant-velocity -o demo/strokes.h5 --force"
run "fric inspect demo/strokes.h5 --plot demo/strokes.png --force"
run "fric identify plant data/frequency-response.h5 -o demo/plant.yaml --plot demo/plant.png --force"
run "fric identify static demo/strokes.h5 --plant demo/plant.yaml -o demo/static.yaml --plot demo/static.png --force"
run "fric identify gms data/presliding-sine.h5 data/sliding-sine.h5 --static demo/static.yaml \
--plant demo/plant.yaml -o demo/friction.yaml --plot demo/gms.png --force"
run "fric reproduce -o demo/paper"
