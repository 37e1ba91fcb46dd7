/// \file
/// JSON text whose values know where they stand.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace tyndall::io {

using Json = nlohmann::ordered_json;

/// What a value was written in: the scene file, or the value of a -D option.
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
  Json value;                  ///< a scalar; empty for lists and objects, which have
  std::vector<Node> children;
};

/// Comments and a byte order mark are allowed.
/// \throws Error(scene_invalid) with the place of a syntax error. The nodes point to `source`.
Node parse(const Source& source);

/// \return the value of a -D option: JSON, or a string where it is none.
Node parse_option(const Source& option);

/// \return "scene.json:41:17" for the scene file, its own name for an option. Columns count
/// characters.
std::string place(const Source& source, std::size_t offset);

/// \return the value as a person would recognise it.
std::string quote(const Node& node);

// Paths: "lights[0].power".

std::vector<std::string> steps(std::string_view path);

/// \return the member or element that `step` names, or null.
Node* child(Node& node, std::string_view step);
const Node* child(const Node& node, std::string_view step);

/// \return the node at `path`, or the innermost one around where it would be.
const Node& nearest_node(const Node& root, std::string_view path);

}  // namespace tyndall::io
