#!/usr/bin/env bash
# The GLSL code that a bake writes beside its textures compiles without warnings for desktop GL and for WebGL 2. Exits
# with 77 (skipped) without glslangValidator (scripts/setup --dev).
set -euo pipefail
cd "${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}"
if ! command -v glslangValidator >/dev/null; then
  echo "SKIPPED: no glslangValidator here"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
compile() { # HEAD TEXT
  printf '%s\n%s\n%s\n' "$1" "$2" '
in vec3 p;
in vec3 w;
out vec4 color;
void main() {
  vec3 scattered = scattered_light(p, normalize(w), vec3(0.9), 0.5)
      + scattered_once(p, normalize(w), vec3(0.0, 1.0, 0.0), vec3(3.0), vec3(0.9), 0.5, 32);
  color = vec4(emitted(p) + extinction(p) * scattered, 1.0);
}' >"$scratch/bake.frag"
  glslangValidator "$scratch/bake.frag" >"$scratch/log" 2>&1 && ! grep -qi warning "$scratch/log"
}
text=$(<src/io/look/light.glsl)
desktop='#version 330 core'
web='#version 300 es
precision highp float;
precision highp sampler3D;'
for head in "$desktop" "$web"; do
  compile "$head" "$text" || { echo "after ${head%%$'\n'*}:"; cat "$scratch/log"; exit 1; }
done
# The compiler finds a mistake in the code.
if compile "$desktop" "${text/density_max - density_min/density_max - light}"; then
  echo "a text that cannot compile did" && exit 1
fi
echo "light.glsl compiles as GLSL 3.30 and as ES 3.00"
