#include "io/json_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

// nlohmann's parser reports tokens without their places; the two functions below find these. They
// can be simple because the parser has accepted the text, or they stop at its error.

bool is_one_of(char c, std::string_view characters) {
  return characters.find(c) != characters.npos;
}

std::size_t skip_blanks(std::string_view text, std::size_t at) {
  if (at == 0 && text.starts_with("\xef\xbb\xbf")) at = 3;  // byte order mark
  while (at < text.size()) {
    if (text.substr(at, 2) == "//") {
      at = text.find('\n', at);
    } else if (text.substr(at, 2) == "/*") {
      at = text.find("*/", at + 2);
      if (at != text.npos) at += 2;
    } else if (is_one_of(text[at], " \t\r\n")) {
      ++at;
    } else {
      break;
    }
  }
  return std::min(at, text.size());
}

/// \return the end of the token that starts `at`.
std::size_t token_end(std::string_view text, std::size_t at) {
  if (at >= text.size()) return text.size();
  if (text[at] == '"') {
    for (++at; at < text.size() && text[at] != '"'; ++at) {
      if (text[at] == '\\') ++at;
    }
    return std::min(at + 1, text.size());
  }
  if (is_one_of(text[at], "{}[],:")) return at + 1;
  const std::size_t end = text.find_first_of(" \t\r\n{}[],:\"/", at + 1);
  return std::min(end, text.size());
}

[[noreturn]] void throw_at(const Source& source, std::size_t offset, std::string_view message) {
  throw Error(ExitCode::scene_invalid, fmt::format("{}: {}", place(source, offset), message));
}

/// Refuses encodings of some editors, for which the messages of nlohmann's parser do not help.
void refuse_wide_characters(const Source& source) {
  const std::string_view text = source.text;
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")
      || text.substr(0, 4).find('\0') != text.npos)
    throw_at(source, 0, "text in UTF-16 or UTF-32: save it as UTF-8");
}

/// The receiver of nlohmann's parser (its SAX interface): builds the tree of nodes.
class Builder {
 public:
  Builder(const Source& source, Node& root) : source_(source), root_(root) {}

  bool null() { return add(nullptr); }
  bool boolean(bool value) { return add(value); }
  bool number_integer(std::int64_t value) { return add(value); }
  bool number_unsigned(std::uint64_t value) { return add(value); }
  bool number_float(double value, const std::string&) { return add(value); }
  bool string(std::string& value) { return add(value); }
  bool binary(Json::binary_t&) { return false; }  // not in JSON text
  bool start_object(std::size_t) { return add(Json::object()); }
  bool start_array(std::size_t) { return add(Json::array()); }
  bool end_object() { return end(); }
  bool end_array() { return end(); }

  bool key(std::string& name) {
    key_ = name;
    key_offset_ = next_token();
    return true;
  }

  template <class Exception>
  bool parse_error(std::size_t position, const std::string&, const Exception& exception) {
    const std::string_view text = source_.text;
    char before = 0;
    std::size_t at = skip_blanks(text, at_);
    for (std::size_t end = 0; at < text.size() && (end = token_end(text, at)) < position;) {
      before = text[at];
      at = skip_blanks(text, end);
    }
    throw_at(source_, at,
             reason(text.substr(at, token_end(text, at) - at), before, exception.what()));
  }

 private:
  /// \return the offset of the next key or value, after blanks and punctuation.
  std::size_t next_token() {
    const std::string_view text = source_.text;
    at_ = skip_blanks(text, at_);
    while (at_ < text.size() && is_one_of(text[at_], ",:]}")) at_ = skip_blanks(text, at_ + 1);
    const std::size_t start = at_;
    at_ = token_end(text, at_);
    return start;
  }

  bool add(Json value) {
    constexpr std::size_t deepest = 64;
    Node& node = open_.empty() ? root_ : open_.back()->children.emplace_back();
    node.source = &source_;
    node.offset = next_token();
    node.key = std::exchange(key_, {});
    node.key_offset = key_offset_;
    node.value = std::move(value);
    if (!node.value.is_structured()) return true;
    if (open_.size() == deepest)
      throw_at(source_, node.offset, fmt::format("nested deeper than {} levels", deepest));
    open_.push_back(&node);  // stays valid: the list that holds it grows only after end()
    return true;
  }

  bool end() {
    open_.pop_back();
    return true;
  }

  /// \return nlohmann's message without its position and quotations, in plainer terms.
  std::string reason(std::string_view token, char before, std::string message) const {
    std::string word(token.substr(token.find_first_not_of("+-") == 1 ? 1 : 0));
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (word == "nan" || word == "inf" || word == "infinity")
      return fmt::format("{} is no number in JSON: every number must be finite", token);
    if (before == ',' && (token == "}" || token == "]"))
      return fmt::format("a comma before '{}': remove the comma", token);
    if (token.empty() && root_.source == nullptr)
      return "empty; a scene starts with {\"tyndall\": 1, ...";

    if (const auto start = message.find(" - "); start != message.npos) message.erase(0, start + 3);
    if (const auto start = message.find("[json.exception"); start == 0)
      message.erase(0, message.find("] ") + 2);
    if (const auto quote = message.find("; last read: '"); quote != message.npos) {
      const auto rest = message.rfind("'; expected ");
      message.erase(quote, rest == message.npos ? rest : rest + 1 - quote);
    }
    for (const char* close : {"expected '}'", "expected ']'"}) {
      if (message.ends_with(close)) message.insert(message.size() - 3, "',' or ");
    }
    for (const auto& [term, plain] :
         {std::pair("string literal", "string in double quotes"),
          std::pair("number literal", "number"), std::pair("invalid literal", "invalid word"),
          std::pair("or a literal", "or a value")}) {
      const auto at = message.find(term);
      if (at != message.npos) message.replace(at, std::string_view(term).size(), plain);
    }
    return message;
  }

  const Source& source_;
  Node& root_;
  std::vector<Node*> open_;  // the lists and objects around the current place
  std::size_t at_ = 0;       // [byte] end of the last token
  std::string key_;
  std::size_t key_offset_ = 0;
};

}  // namespace

std::string place(const Source& source, std::size_t offset) {
  if (source.option) return source.name;
  std::string_view before = std::string_view(source.text).substr(0, offset);
  if (before.starts_with("\xef\xbb\xbf")) before.remove_prefix(3);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  before.remove_prefix(before.rfind('\n') + 1);  // none: npos + 1 = 0
  const auto starts_character = [](char c) { return (c & 0xc0) != 0x80; };
  const auto column = 1 + std::count_if(before.begin(), before.end(), starts_character);
  return fmt::format("{}:{}:{}", source.name, line, column);
}

Node parse(const Source& source) {
  refuse_wide_characters(source);
  Node root;
  Builder builder(source, root);
  constexpr bool strict = true, with_comments = true;
  Json::sax_parse(source.text, &builder, Json::input_format_t::json, strict, with_comments);
  return root;
}

Node parse_option(const Source& option) {
  const std::size_t start = skip_blanks(option.text, 0);
  const bool meant_as_json = start < option.text.size() && is_one_of(option.text[start], "{[\"");
  if (meant_as_json || Json::accept(option.text)) return parse(option);
  Node node;
  node.source = &option;
  node.value = option.text;
  return node;
}

std::vector<std::string> steps(std::string_view path) {
  std::vector<std::string> result(1);
  for (const char c : path) {
    if (c == '.' || c == '[') {
      result.emplace_back();
    } else if (c != ']') {
      result.back() += c;
    }
  }
  return result;
}

Node* child(Node& node, std::string_view step) {
  if (node.value.is_array()) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(step.begin(), step.end(), index);
    const bool exists = error == std::errc() && end == step.end() && index < node.children.size();
    return exists ? &node.children[index] : nullptr;
  }
  for (Node& member : node.children) {
    if (member.key == step) return &member;
  }
  return nullptr;
}

const Node* child(const Node& node, std::string_view step) {
  return child(const_cast<Node&>(node), step);
}

const Node& nearest_node(const Node& root, std::string_view path) {
  const Node* node = &root;
  for (const std::string& step : steps(path)) {
    const Node* next = child(*node, step);
    if (!next) break;
    node = next;
  }
  return *node;
}

std::string quote(const Node& node) {
  constexpr std::size_t longest = 40;
  if (node.value.is_object()) return "an object";
  if (node.value.is_array()) return fmt::format("a list of {}", node.children.size());
  if (node.value.is_number_float()) return fmt::format("{}", node.value.get<double>());
  if (!node.value.is_string()) return node.value.dump();
  std::string text = node.value.get<std::string>();
  const bool cut = text.size() > longest;
  if (cut) text = text.substr(0, longest);
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace) + (cut ? "..." : "");
}

}  // namespace tyndall::io
