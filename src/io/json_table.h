/// \file
/// What a table of keys is made of. Each key has a kind of value, a unit and a meaning; a Kind
/// knows how its values are read, described (JSON Schema) and listed, and kinds are put together
/// from smaller ones.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec3.hpp>

#include "io/json_text.h"
#include "io/scene_json.h"
#include "io/volume_file.h"
#include "tyndall/render/check.h"
#include "tyndall/render/error.h"

namespace tyndall::io {

// ---- Errors: all of them are kept, and none stops the reading. ----

struct Finding {
  const Source* source;
  std::size_t offset;
  std::string path;
  std::string message;
  ExitCode code = ExitCode::scene_invalid;
  bool is_of_frame = false;  ///< about a file of this frame of a sequence, and of no other

  /// One line, whatever control characters a key or a value has.
  std::string text() const {
    std::string line =
        fmt::format("{}: {}{}{}", place(*source, offset), path, path.empty() ? "" : ": ", message);
    for (char& c : line) {
      if (static_cast<unsigned char>(c) < ' ') c = '?';
    }
    return line;
  }
};

class Reader {
 public:
  /// \param frames see SequenceFiles; may be null
  explicit Reader(std::filesystem::path folder, SequenceFiles* frames = nullptr)
      : sequence(frames), folder_(std::move(folder)) {}

  void error(const Node& node, const std::string& message,
             ExitCode code = ExitCode::scene_invalid) {
    errors.push_back({node.source, node.offset, path_, message, code, frame_files() != nullptr});
  }
  void error_at_key(const Node& node, const std::string& message) {
    errors.push_back({node.source, node.key_offset, path_, message});
  }
  void warning(const Node& node, const std::string& message) {
    warnings.push_back({node.source, node.offset, path_, message});
  }
  void expected(const Node& node, const std::string& what) {
    error(node, fmt::format("expected {}, got {}", what, quote(node)));
  }

  /// Calls `read` with the path extended by a key or an index.
  template <class Read>
  void within(const std::string& key, const Read& read) {
    const std::size_t length = path_.size();
    path_ += (path_.empty() ? "" : ".") + key;
    read();
    path_.resize(length);
  }
  template <class Read>
  void within(std::size_t index, const Read& read) {
    const std::size_t length = path_.size();
    path_ += fmt::format("[{}]", index);
    read();
    path_.resize(length);
  }

  /// The value at the current path could not be read: what check() says of its default is of no
  /// interest.
  void give_up() { unread.push_back(path_); }

  /// A file that the scene names, relative to the scene.
  std::filesystem::path file(const std::string& name) const {
    return folder_ / std::filesystem::path(name);
  }

  const std::string& path() const { return path_; }
  /// \return what the key at the current path names in each frame; null where that is one file.
  const std::vector<std::string>* frame_files() const {
    if (!sequence) return nullptr;
    const auto found = sequence->numbered.find(path_);
    return found == sequence->numbered.end() ? nullptr : &found->second;
  }
  /// Notes the file that the key at the current path names. \return whether it is not to be read.
  bool only_names(const std::filesystem::path& file) {
    named.push_back({path_, file.string()});
    return is_names_only;
  }

  SequenceFiles* const sequence;
  bool is_names_only = false;
  std::vector<NamedFile> named;
  std::vector<Finding> errors;
  std::vector<std::string> unread;
  std::vector<std::string> inputs;  ///< files that were read beside the scene
  std::vector<Finding> warnings;
  std::map<std::string, LoadedVolume> volumes;  ///< by file and grid: each is read once

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/// Levenshtein's distance.
inline std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// \return `did you mean "fov"?`, or all there is to choose from where nothing is near.
inline std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  const auto distance = [&](const std::string& name) { return edits(word.substr(0, 64), name); };
  const auto nearest =
      std::min_element(known.begin(), known.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (nearest != known.end() && distance(*nearest) <= 1 + nearest->size() / 3) {
    return fmt::format("did you mean \"{}\"?", *nearest);
  }
  return fmt::format("known here: {}", fmt::join(known, ", "));
}

// ---- Kinds of values: each knows how it is read, described and listed. ----

/// A function whose copies share what it holds: kinds are copied into those that are made of them,
/// and these again, each with all below it.
template <class Signature>
class Shared;
template <class R, class... A>
class Shared<R(A...)> {
 public:
  Shared() = default;
  template <class F>
  requires std::is_invocable_r_v<R, const F&, A...> Shared(F function)
      : function_(std::make_shared<const std::function<R(A...)>>(std::move(function))) {}
  R operator()(A... arguments) const { return (*function_)(std::forward<A>(arguments)...); }
  explicit operator bool() const { return function_ != nullptr; }

 private:
  std::shared_ptr<const std::function<R(A...)>> function_;
};

template <class V>
struct Kind {
  /// Completes "expected ..."
  std::string expected;
  /// Leaves the value as it was where it finds an error.
  Shared<void(Reader&, const Node&, V&)> read;
  Shared<Json()> schema;
  /// JSON with comments.
  Shared<std::string(const V&, const std::string& indent)> list;
  /// Comments that say what else the value may be.
  Shared<std::string(const std::string& indent)> others = {};
  /// Has keys of its own.
  bool composite = false;
};

inline Json schema_of(const Range& range, const char* type) {
  // JSON Schema compares numbers by value: 1 and 1.0 are the same.
  Json schema{{"type", type}};
  if (std::isfinite(range.low)) schema[range.open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) schema[range.open ? "exclusiveMaximum" : "maximum"] = range.high;
  return schema;
}

template <class Real = double>
Kind<Real> number(const Range& range) {
  const std::string expected = describe(range);
  return {expected,
          [=](Reader& reader, const Node& node, Real& value) {
            const bool good = node.value.is_number() && range.contains(node.value.get<double>());
            if (!good) return reader.expected(node, expected);
            value = static_cast<Real>(node.value.get<double>());
          },
          [=] { return schema_of(range, "number"); },
          [](const Real& value, const std::string&) { return fmt::format("{}", value); }};
}

/// 8000000 or 8e6.
template <class Integer>
Kind<Integer> integer(const Range& range) {
  const std::string expected = describe(range);
  return {expected,
          [=](Reader& reader, const Node& node, Integer& value) {
            constexpr double exact = 9007199254740992.0;  // 2^53: beyond it a float is no count
            const Json& json = node.value;
            const double x = json.is_number() ? json.get<double>() : 0.5;
            const bool whole =
                json.is_number_integer() || (x == std::floor(x) && std::abs(x) <= exact);
            if (!whole || !range.contains(x)) return reader.expected(node, expected);
            value = json.is_number_integer() ? json.get<Integer>() : static_cast<Integer>(x);
          },
          [=] { return schema_of(range, "integer"); },
          [](const Integer& value, const std::string&) { return fmt::format("{}", value); }};
}

inline Kind<std::string> text(const std::string& expected) {
  return {expected,
          [=](Reader& reader, const Node& node, std::string& value) {
            if (!node.value.is_string()) return reader.expected(node, expected);
            value = node.value.get<std::string>();
          },
          [] {
            return Json{{"type", "string"}};
          },
          [](const std::string& value, const std::string&) { return Json(value).dump(); }};
}

template <class E>
Kind<E> choice(const std::vector<std::pair<std::string, E>>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  const std::string expected = fmt::format("\"{}\"", fmt::join(names, "\" or \""));
  return {expected,
          [=](Reader& reader, const Node& node, E& value) {
            for (const auto& [name, meaning] : choices) {
              if (node.value == name) {
                value = meaning;
                return;
              }
            }
            reader.expected(node, expected);
          },
          [=] {
            return Json{{"enum", names}};
          },
          [=](const E& value, const std::string&) {
            for (const auto& [name, meaning] : choices) {
              if (meaning == value) return '"' + name + '"';
            }
            return std::string("null");
          }};
}

/// A list of as many elements as `names` names, e.g. "x, y, z". `or_one`: one value alone stands
/// for all of them.
template <class V, class E>
Kind<V> tuple(const std::string& names, const Kind<E>& element, bool or_one = false) {
  const int count = 1 + static_cast<int>(std::count(names.begin(), names.end(), ','));
  const std::string expected = or_one ? fmt::format("{}, or [{}] of such", element.expected, names)
                                      : fmt::format("[{}], each {}", names, element.expected);
  return {expected,
          [=](Reader& reader, const Node& node, V& values) {
            if (or_one && node.value.is_number()) {
              E one = values[0];
              element.read(reader, node, one);
              for (int i = 0; i < count; ++i) values[i] = one;
            } else if (!node.value.is_array()
                       || node.children.size() != static_cast<std::size_t>(count)) {
              reader.expected(node, expected);
            } else {
              for (int i = 0; i < count; ++i) {
                reader.within(i, [&] {
                  element.read(reader, node.children[static_cast<unsigned>(i)], values[i]);
                });
              }
            }
          },
          [=] {
            const Json list{{"type", "array"},
                            {"items", element.schema()},
                            {"minItems", count},
                            {"maxItems", count}};
            return or_one ? Json{{"anyOf", {element.schema(), list}}} : list;
          },
          [=](const V& values, const std::string& indent) {
            std::string list;
            for (int i = 0; i < count; ++i)
              list += fmt::format("{}{}", i == 0 ? "" : ", ", element.list(values[i], indent));
            return '[' + list + ']';
          }};
}

inline Kind<glm::dvec3> vector(const Range& range) {
  return tuple<glm::dvec3>("x, y, z", number(range));
}
inline Kind<glm::dvec3> color(const Range& range) {
  return tuple<glm::dvec3>("r, g, b", number(range), true);
}
inline Kind<std::array<int, 3>> cells(const Range& range) {
  return tuple<std::array<int, 3>>("x, y, z", integer<int>(range), true);
}

/// A value or null, for none.
template <class V>
Kind<std::optional<V>> or_null(const Kind<V>& kind) {
  return {"null, or " + kind.expected,
          [=](Reader& reader, const Node& node, std::optional<V>& value) {
            value.reset();
            if (!node.value.is_null()) kind.read(reader, node, value.emplace());
          },
          [=] {
            return Json{{"anyOf", {Json{{"type", "null"}}, kind.schema()}}};
          },
          [=](const std::optional<V>& value, const std::string& indent) {
            return value ? kind.list(*value, indent) : "null";
          }};
}

template <class E>
Kind<std::vector<E>> list(const Kind<E>& element) {
  return {"a list",
          [=](Reader& reader, const Node& node, std::vector<E>& values) {
            if (!node.value.is_array()) return reader.expected(node, "a list");
            values.resize(node.children.size());
            for (std::size_t i = 0; i < values.size(); ++i) {
              reader.within(i, [&] { element.read(reader, node.children[i], values[i]); });
            }
          },
          [=] {
            return Json{{"type", "array"}, {"items", element.schema()}};
          },
          [=](const std::vector<E>&, const std::string& indent) {
            if (!element.composite) return std::string("[]");
            return fmt::format("[\n{0}  {1}\n{0}]", indent, element.list(E{}, indent + "  "));
          },
          element.others,
          element.composite};
}

// ---- Objects: a table of keys per type. ----

/// One row of the table. Its kind reads into the object that has the key.
template <class T>
struct Key {
  std::string name;
  Kind<T> kind;
  std::string unit;
  std::string doc;
  bool is_required = false;

  std::string comment() const {
    std::string text = doc;
    if (!unit.empty()) text += " [" + unit + "]";
    if (!kind.expected.empty()) text += "; " + kind.expected;
    return text + (is_required ? "; required" : "");
  }
};

template <class T, class V>
Key<T> key(const std::string& name, V T::*member, const Kind<V>& kind, const std::string& unit,
           const std::string& doc) {
  return {name,
          {kind.expected,
           [=](Reader& reader, const Node& node, T& object) {
             kind.read(reader, node, object.*member);
           },
           kind.schema,
           [=](const T& object, const std::string& indent) {
             return kind.list(object.*member, indent);
           },
           kind.others, kind.composite},
          unit,
          doc};
}

/// A value that the object does not hold as it is written: `set(object, value)` stores it.
template <class T, class V, class Set>
Key<T> setter(const std::string& name, const V& initial, const Set& set, const Kind<V>& kind,
              const std::string& unit, const std::string& doc) {
  return {
      name,
      {kind.expected,
       [=](Reader& reader, const Node& node, T& object) {
         V value = initial;
         const std::size_t errors = reader.errors.size();
         kind.read(reader, node, value);
         if (reader.errors.size() == errors) set(object, value);
       },
       kind.schema, [=](const T&, const std::string& indent) { return kind.list(initial, indent); },
       kind.others, kind.composite},
      unit,
      doc};
}

template <class T>
Key<T> required(Key<T> key) {
  key.is_required = true;
  return key;
}

/// What a table of keys cannot say of each key alone.
template <class T>
struct Rules {
  using Alternatives = std::vector<std::vector<std::string>>;

  /// Sets of keys; keys of different sets exclude each other.
  Alternatives alternatives = {};
  bool one_needed = false;  ///< of the alternatives
  /// Called once all keys are read without an error.
  std::function<void(Reader&, const Node&, T&)> finish = {};
  Alternatives second_alternatives = {};  ///< another choice, of other keys
  bool is_usual = false;                  ///< of a case: the one that is meant without a "type"

  /// \return which of its alternatives `name` is one of, -1: none
  int alternative(const std::string& name) const {
    return std::max(index(alternatives, name), index(second_alternatives, name));
  }
  bool exclude(const std::string& a, const std::string& b) const {
    const auto differ = [](int i, int j) { return i >= 0 && j >= 0 && i != j; };
    return differ(index(alternatives, a), index(alternatives, b))
           || differ(index(second_alternatives, a), index(second_alternatives, b));
  }

 private:
  static int index(const Alternatives& sets, const std::string& name) {
    for (std::size_t i = 0; i < sets.size(); ++i) {
      const auto& names = sets[i];
      if (std::find(names.begin(), names.end(), name) != names.end()) return static_cast<int>(i);
    }
    return -1;
  }
};

template <class T>
class Table {
 public:
  Table(std::vector<Key<T>> keys, Rules<T> rules)
      : keys_(std::move(keys)), rules_(std::move(rules)) {}

  void read(Reader& reader, const Node& node, T& object) const {
    if (!node.value.is_object()) return reader.expected(node, "an object");
    const std::size_t errors = reader.errors.size();
    refuse_strange_keys(reader, node);
    for (const Key<T>& key : keys_) {
      reader.within(key.name, [&] {
        if (const Node* member = child(node, key.name)) {
          key.kind.read(reader, *member, object);
        } else if (key.is_required) {
          const std::string& expected = key.kind.expected;
          reader.error(node, expected.empty() ? "missing" : "missing; expected " + expected);
        }
      });
    }
    refuse_alternatives(reader, node);
    if (rules_.finish && reader.errors.size() == errors) rules_.finish(reader, node, object);
  }

  Json schema() const {
    Json properties = Json::object(), required_names = Json::array(), exclusions = Json::array();
    for (const Key<T>& key : keys_) {
      Json property = key.kind.schema();
      if (!key.doc.empty())
        property["description"] = key.unit.empty() ? key.doc : key.doc + " [" + key.unit + "]";
      const int alternative = rules_.alternative(key.name);
      if (key.is_required) {
        required_names.push_back(key.name);
      } else if (!key.kind.composite && alternative < 0) {
        property["default"] = Json::parse(key.kind.list(T{}, ""));
      }
      properties[key.name] = std::move(property);
      for (const Key<T>& other : keys_) {
        if (rules_.exclude(key.name, other.name) && rules_.alternative(other.name) > alternative) {
          exclusions.push_back({{"not", {{"required", {key.name, other.name}}}}});
        }
      }
    }
    Json schema{{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
    if (!required_names.empty()) schema["required"] = required_names;
    if (!exclusions.empty()) schema["allOf"] = exclusions;
    if (rules_.one_needed) {
      for (const auto& names : rules_.alternatives)
        schema["anyOf"].push_back({{"required", names}});
    }
    return schema;
  }

  std::string list(const T& object, const std::string& indent) const {
    const std::string inner = indent + "  ";
    // Shown as a comment, beside the keys that it excludes.
    const auto spare = [&](const Key<T>& key) { return rules_.alternative(key.name) > 0; };
    const Key<T>* last = nullptr;
    for (const Key<T>& key : keys_) {
      if (!spare(key)) last = &key;
    }
    std::string out = "{\n";
    for (const Key<T>& key : keys_) {
      const std::string value = fmt::format("\"{}\": {}", key.name, key.kind.list(object, inner));
      const char* comma = &key == last || spare(key) ? "" : ",";
      if (key.kind.composite) {
        out += fmt::format("{}// {}\n", inner, key.comment());
        if (key.kind.others) out += key.kind.others(inner);
        out += fmt::format("{}{}{}\n", inner, value, comma);
      } else {
        out += fmt::format("{}{}{}{}  // {}\n", inner, spare(key) ? "// or " : "", value, comma,
                           key.comment());
      }
    }
    return out + indent + "}";
  }

 private:
  void refuse_strange_keys(Reader& reader, const Node& node) const {
    std::vector<std::string> known;
    for (const Key<T>& key : keys_) known.push_back(key.name);
    for (const Node& member : node.children) {
      reader.within(member.key, [&] {
        if (std::find(known.begin(), known.end(), member.key) == known.end()) {
          return reader.error_at_key(member,
                                     fmt::format("unknown key; {}", suggestion(member.key, known)));
        }
        const Node* first = child(node, member.key);
        if (first == &member) return;
        reader.error_at_key(member, fmt::format("given twice, first at {}",
                                                place(*first->source, first->key_offset)));
      });
    }
  }

  void refuse_alternatives(Reader& reader, const Node& node) const {
    for (const Node& member : node.children) {
      for (const Node& other : node.children) {
        if (&other == &member) break;
        if (!rules_.exclude(member.key, other.key)) continue;
        reader.within(member.key, [&] {
          reader.error_at_key(member,
                              fmt::format("cannot be given together with \"{}\"", other.key));
        });
        break;
      }
    }
    if (!rules_.one_needed) return;
    for (const auto& alternative : rules_.alternatives) {
      for (const std::string& name : alternative)
        if (child(node, name)) return;
    }
    std::vector<std::string> names;
    for (const auto& alternative : rules_.alternatives) names.push_back(alternative.front());
    reader.error(node, fmt::format("missing \"{}\"", fmt::join(names, "\" or \"")));
  }

  std::vector<Key<T>> keys_;
  Rules<T> rules_;
};

template <class T>
Kind<T> object(std::vector<Key<T>> keys, Rules<T> rules = {}) {
  const auto table = std::make_shared<const Table<T>>(std::move(keys), std::move(rules));
  return {"",
          [=](Reader& reader, const Node& node, T& value) { table->read(reader, node, value); },
          [=] { return table->schema(); },
          [=](const T& value, const std::string& indent) { return table->list(value, indent); },
          {},
          true};
}

/// Keys that the file gathers in an object of their own, and the program does not.
template <class T>
Key<T> group(const std::string& name, std::vector<Key<T>> keys, const std::string& doc) {
  return {name, object<T>(std::move(keys)), "", doc};
}

// ---- Variants: objects whose key "type" says which other keys they have. ----

template <class V>
struct Case {
  std::string name;
  Kind<V> kind;
  bool is_usual = false;  ///< meant without a "type"
};

/// \param store makes a V from the P that the keys fill in.
template <class V, class P>
Case<V> one(
    const std::string& name, const std::string& doc, std::vector<Key<P>> keys, Rules<P> rules = {},
    const std::function<V(P&&)>& store = [](P&& value) { return V(std::move(value)); }) {
  const Kind<P> type{"", [](Reader&, const Node&, P&) {},
                     [=] {
                       return Json{{"const", name}};
                     },
                     [=](const P&, const std::string&) { return '"' + name + '"'; }};
  const bool is_usual = rules.is_usual;
  keys.insert(keys.begin(), Key<P>{"type", type, "", doc, !is_usual});
  const Kind<P> whole = object<P>(std::move(keys), std::move(rules));
  return {
      name,
      {"",
       [=](Reader& reader, const Node& node, V& value) {
         P read{};
         const std::size_t errors = reader.errors.size();
         whole.read(reader, node, read);
         if (reader.errors.size() == errors) value = store(std::move(read));
       },
       whole.schema, [=](const V&, const std::string& indent) { return whole.list(P{}, indent); }},
      is_usual};
}

inline std::string as_alternative(const std::string& block, const std::string& indent) {
  std::string out = indent + "// or ";
  for (const char c : block) {
    out += c;
    if (c == '\n') out += indent + "// ";
  }
  return out + '\n';
}

/// The first case is the default's.
template <class V>
Kind<V> variant(const std::vector<Case<V>>& cases) {
  std::vector<std::string> names;
  for (const Case<V>& c : cases) names.push_back(c.name);
  const std::string expected = fmt::format("\"{}\"", fmt::join(names, "\" or \""));
  return {
      "",
      [=](Reader& reader, const Node& node, V& value) {
        const std::size_t errors = reader.errors.size();
        const Node* type = child(node, "type");
        const auto usual =
            std::find_if(cases.begin(), cases.end(), [](const Case<V>& c) { return c.is_usual; });
        if (!node.value.is_object()) {
          reader.expected(node, usual == cases.end() ? "an object with a \"type\"" : "an object");
        } else if (!type && usual != cases.end()) {
          usual->kind.read(reader, node, value);
        } else if (!type) {
          reader.within("type", [&] { reader.error(node, "missing; expected " + expected); });
        } else if (const auto found =
                       std::find_if(names.begin(), names.end(),
                                    [&](const auto& n) { return type->value == Json(n); });
                   found != names.end()) {
          cases[static_cast<std::size_t>(found - names.begin())].kind.read(reader, node, value);
        } else {
          const std::string word =
              type->value.is_string() ? type->value.template get<std::string>() : "";
          reader.within("type", [&] {
            reader.error(*type, fmt::format("expected {}, got {}; {}", expected, quote(*type),
                                            suggestion(word, names)));
          });
        }
        if (reader.errors.size() > errors) reader.give_up();
      },
      [=] {
        Json schema{{"oneOf", Json::array()}};
        for (const Case<V>& c : cases) schema["oneOf"].push_back(c.kind.schema());
        return schema;
      },
      [=](const V& value, const std::string& indent) { return cases[0].kind.list(value, indent); },
      [=](const std::string& indent) {
        std::string out;
        for (std::size_t i = 1; i < cases.size(); ++i)
          out += as_alternative(cases[i].kind.list(V{}, ""), indent);
        return out;
      },
      true};
}

}  // namespace tyndall::io
