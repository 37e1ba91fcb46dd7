/// \file
/// The scene file: JSON with comments. The reader, its errors, the published schema and the listing
/// of defaults are generated from one description of the keys.
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
  std::vector<LoadedVolume> volumes;  ///< the volumes among these files
  /// \return what `warnings` would be for a scene that a command makes of this one.
  std::function<std::vector<std::string>(const ResolvedScene&)> warnings_of{};
};

/// A file that a scene names.
struct NamedFile {
  std::string key;   ///< "medium.components[0].field.file"
  std::string path;  ///< relative to the current folder
};

/// Data common to the frames of a sequence, for the readers of the frames.
struct SequenceFiles {
  struct Fit {
    std::string file;
    scene::SparseGrid::Bounds box;
  };

  /// By key: the file of each frame, in order, if these differ.
  std::map<std::string, std::vector<std::string>> numbered;
  /// By key: the box that is fitted in all frames, that of the first file that is not empty; no
  /// file if all are empty. The reader fills this in.
  std::map<std::string, Fit> fits;
  /// By key and name of the grid: whether any frame has it. The reader fills this in.
  std::map<std::string, bool> is_somewhere;
};

/// The only errors of a scene are files of one frame of a sequence.
class UnreadableFrame : public Error {
 public:
  explicit UnreadableFrame(const std::string& message) : Error(ExitCode::input_missing, message) {}
};

/// \return the files that a scene names, without reading them. \throws as read_scene(), except for
/// errors in these files.
std::vector<NamedFile> scene_files(const std::string& path,
                                   const std::vector<std::string>& overrides,
                                   const std::function<std::string(const std::string&)>& edit);

/// Reads and checks a scene. `edit` may change its text first. `overrides` replace values of the
/// file, each "path=value" as in "lights[0].power=[10, 20, 30]"; a value that is not JSON is a
/// string. A volume that is numbered in `sequence` may be empty.
/// \throws Error with every error of the scene, one per line, each after its place,
/// "scene.json:41:17: " or "-D camera.fov=x: ". The code is scene_invalid, or input_missing if the
/// only errors are unreadable files, or usage for an override without a path.
/// \throws UnreadableFrame if the only errors are unreadable files that are numbered in `sequence`.
SceneFile read_scene(const std::string& path, const std::vector<std::string>& overrides,
                     const std::function<std::string(const std::string&)>& edit = {},
                     SequenceFiles* sequence = nullptr);

/// Reads a scene from a text as read_scene() does. \param name of the text in messages
/// \param folder of the files that it names
SceneFile read_scene_text(const std::string& name, const std::string& text,
                          const std::string& folder, const std::vector<std::string>& overrides);

/// \return JSON Schema (draft 2020-12) of the scene file.
std::string schema();

/// \return a scene with every key at its default, and each key's unit, range and meaning in
/// comments.
std::string defaults();

}  // namespace tyndall::io
