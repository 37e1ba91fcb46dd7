/// \file
/// The scene file: JSON with comments. One table of keys makes the reader, its errors, the
/// published schema and the listing of defaults.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "io/volume_file.h"
#include "tyndall/render/error.h"
#include "tyndall/render/resolved_scene.h"

namespace tyndall::io {

struct SceneFile {
  ResolvedScene scene;
  std::vector<std::string> warnings;  ///< of reading and of `scene`, one line each
  std::vector<std::string> inputs;    ///< files that were read: the scene itself, then its grids
  std::vector<LoadedVolume> volumes;  ///< of these files
  /// \return what `warnings` would be for a scene that a command makes of this one.
  std::function<std::vector<std::string>(const ResolvedScene&)> warnings_of{};
};

/// A file that a scene names.
struct NamedFile {
  std::string key;   ///< "medium.components[0].field.file"
  std::string path;  ///< from the current folder
};

/// What the frames of a sequence have in common, for the reader of each of them.
struct SequenceFiles {
  struct Fit {
    std::string file;
    scene::SparseGrid::Bounds box;
  };

  /// By key: the file of each frame, in order, where these differ.
  std::map<std::string, std::vector<std::string>> numbered;
  /// By key, what is fitted in all frames: the first of its files that has something in it, or no
  /// file where none has. The reader finds it.
  std::map<std::string, Fit> fits;
  /// Grids that some frame has, by key and name; found by the reader, too.
  std::map<std::string, bool> is_somewhere;
};

/// All that is wrong with a scene are files of one frame.
class UnreadableFrame : public Error {
 public:
  explicit UnreadableFrame(const std::string& message) : Error(ExitCode::input_missing, message) {}
};

/// \return the files that a scene names, none of which is read. \throws as read_scene(), but for
/// what these files would bring.
std::vector<NamedFile> scene_files(const std::string& path,
                                   const std::vector<std::string>& overrides,
                                   const std::function<std::string(const std::string&)>& edit);

/// Reads and checks a scene. `edit` may change its text before. `overrides` replace values of the
/// file, each "path=value" as in "lights[0].power=[10, 20, 30]"; a value that is no JSON is a
/// string. \throws Error with every error of the scene, one per line, each after its place,
/// "scene.json:41:17: " or
/// "-D camera.fov=x: ": scene_invalid, or input_missing if all that is wrong are files that cannot
/// be read; usage for an override without a path. A volume that `sequence` has as numbered may be
/// empty; \throws UnreadableFrame where such files alone cannot be read.
SceneFile read_scene(const std::string& path, const std::vector<std::string>& overrides,
                     const std::function<std::string(const std::string&)>& edit = {},
                     SequenceFiles* sequence = nullptr);

/// The same of a text, which messages call `name`; files are looked for in `folder`.
SceneFile read_scene_text(const std::string& name, const std::string& text,
                          const std::string& folder, const std::vector<std::string>& overrides);

/// \return JSON Schema (draft 2020-12) of the scene file.
std::string schema();

/// \return a scene with every key at its default, and each key's unit, range and meaning in
/// comments.
std::string defaults();

}  // namespace tyndall::io
