/// \file
/// A JSON parser that keeps the position of each value in the text.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace tyndall::io {

using Json = nlohmann::ordered_json;

/// The source of a value: the scene file, or the value of a -D option.
struct Source {
  std::string name;
  std::string text;
  bool option = false;
};

struct Node {
  const Source* source = nullptr;
  std::size_t offset = 0;      ///< [byte] of the value
  std::string key;             ///< of a member of an object
  std::size_t key_offset = 0;  ///< [byte]
  Json value;                  ///< a scalar, or an empty list or object
  std::vector<Node> children;  ///< elements of a list, members of an object
};

/// Parses JSON with comments and an optional byte order mark. The nodes point to `source`.
/// \throws Error(scene_invalid) with the place of a syntax error.
Node parse(const Source& source);

/// \return the value of a -D option: JSON, or else a string.
Node parse_option(const Source& option);

/// \return "scene.json:41:17" for the scene file, the option itself for an option. Columns count
/// characters.
std::string place(const Source& source, std::size_t offset);

/// \return the value, shortened for messages.
std::string quote(const Node& node);

// Paths: "lights[0].power".

/// \return the keys and indices of a path: "lights", "0", "power".
std::vector<std::string> steps(std::string_view path);

/// \return the member or element that `step` names, or null.
Node* child(Node& node, std::string_view step);
const Node* child(const Node& node, std::string_view step);

/// \return the node at `path`, or its innermost existing ancestor.
const Node& nearest_node(const Node& root, std::string_view path);

}  // namespace tyndall::io
