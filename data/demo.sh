#!/bin/sh
# `make demo`: from bundled logs of a drive to its friction, with every file left in demo/.
set -eu
cd "$(dirname "$0")/.."
mkdir -p demo
run() { printf '\n$ %s\n' "$1"; eval "$1"; }
run "fric ingest data/strokes/*.csv --kind constant-velocity -o demo/strokes.h5 --force"
run "fric inspect demo/strokes.h5 --plot demo/strokes.png --force"
run "fric identify static demo/strokes.h5 -o demo/friction.yaml --plot demo/static-map.png --force"
printf '\nLook at demo/static-map.png; the numbers are in demo/friction.yaml.\n'
