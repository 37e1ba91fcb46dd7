/// \file
/// The scene file: JSON with comments. One table of keys makes the reader, its errors, the
/// published schema and the listing of defaults.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/volume_file.h"
#include "tyndall/render/scene.h"

namespace tyndall::io {

struct SceneFile {
  Scene scene;
  std::vector<std::string> warnings;  ///< one line each
  std::vector<std::string> inputs;    ///< files that were read: the scene itself, then its grids
  std::vector<LoadedVolume> volumes;  ///< of these files
};

/// Reads and checks a scene. `edit` may change its text before. `overrides` replace values of the
/// file, each "path=value" as in "lights[0].power=[10, 20, 30]"; a value that is no JSON is a
/// string. \throws Error with every error of the scene, one per line, each after its place,
/// "scene.json:41:17: " or
/// "-D camera.fov=x: ": scene_invalid, or input_missing if all that is wrong are files that cannot
/// be read; usage for an override without a path.
SceneFile read_scene(const std::string& path, const std::vector<std::string>& overrides,
                     const std::function<std::string(const std::string&)>& edit = {});

/// The same of a text, which messages call `name`; files are looked for in `folder`.
SceneFile read_scene_text(const std::string& name, const std::string& text,
                          const std::string& folder, const std::vector<std::string>& overrides);

/// \return JSON Schema (draft 2020-12) of the scene file.
std::string schema();

/// \return a scene with every key at its default, and each key's unit, range and meaning in
/// comments.
std::string defaults();

}  // namespace tyndall::io
