#!/usr/bin/env bash
# An installation by `cmake --install` works without the source tree: the program renders a picture, and another project
# finds the package, compiles a header of the core and links the renderer.
set -euo pipefail
build=${TYNDALL_BUILD_DIR:?}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cmake --install "$build" --prefix "$scratch/prefix" >/dev/null
mv "$scratch/prefix" "$scratch/moved" # nothing may depend on where it was installed
prefix=$scratch/moved

mkdir "$scratch/user"
cat >"$scratch/user/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES CXX)
find_package(tyndall 0.1 REQUIRED)
add_executable(user user.cpp)
target_link_libraries(user PRIVATE tyndall::host tyndall::io)
CMAKE
cat >"$scratch/user/user.cpp" <<'CPP'
#include <cstdio>

#include "tyndall/medium/noise.h"
#include "tyndall/render/render.h"

int main() {
  tyndall::Scene scene;
  scene.medium.components.resize(1);
  scene.medium.components[0].extinction = 5;
  scene.lights = {tyndall::scene::PointLight{{0.5, 2.0, 0.5}, glm::dvec3(10.0)}};
  scene.camera.resolution = {8, 8};
  scene.photons = 1000;
  scene.samples = 1;
  const auto result = tyndall::render(scene, *tyndall::make_cpu_backend(1));
  std::printf("%lld photons, noise %g\n", static_cast<long long>(result.ledger.shot),
              tyndall::gradient_noise({0.3f, 0.4f, 0.5f}, 1));
  return result.ledger.shot == 1000 ? 0 : 1;
}
CPP
cmake -S "$scratch/user" -B "$scratch/user/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS=-O1 >"$scratch/log" \
  || { cat "$scratch/log" >&2; exit 1; }
cmake --build "$scratch/user/build" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
"$scratch/user/build/user"

source=${TYNDALL_SOURCE_DIR:-$(dirname "${BASH_SOURCE[0]}")/../..}
cmake -S "$source/docs/example" -B "$scratch/example" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CUDA_COMPILER=NOTFOUND \
  -DCMAKE_CXX_FLAGS=-O1 >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
cmake --build "$scratch/example" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
"$scratch/example/free_paths" | grep "^100000 photons: 0 through, the others fly 0.131631 on average$"

cat >"$scratch/fog.json" <<'JSON'
{"tyndall": 1, "medium": {"components": [{"field": {"type": "homogeneous"}, "extinction": 3}]}, "background": 0.2,
 "lights": [{"type": "point", "position": [0.5, 2, 0.5], "power": 10}],
 "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "resolution": [8, 8]},
 "photons": {"count": 1000, "illumination": {"resolution": 4}}, "gather": {"samples": 1}}
JSON
outputs=()
for format in exr png pfm; do
  if "$prefix/bin/tyndall" --version | grep -q "^pictures .*\.$format"; then outputs+=(-o "$scratch/fog.$format"); fi
done
"$prefix/bin/tyndall" render "$scratch/fog.json" "${outputs[@]}"
for ((i = 1; i < ${#outputs[@]}; i += 2)); do [[ -s ${outputs[i]} ]]; done
volumes=${TYNDALL_TEST_VOLUMES:-}
if [[ -e $volumes/ball.vdb ]]; then # its reader is installed, too, and found
  cp "$volumes/ball.vdb" "$scratch"
  "$prefix/bin/tyndall" info "$scratch/ball.vdb" | grep -q '^  active voxels  4139$'
fi
echo "the installed package works: $((${#outputs[@]} / 2)) picture formats"
