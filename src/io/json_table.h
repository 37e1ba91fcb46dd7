/// \file
/// Visitors of the descriptions of a scene (scene/describe.h), which read its JSON and write the
/// schema and the defaults. Each value has a type and a form; read_value(), schema_of(), list_of()
/// and expected() operate on both.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/json_text.h"
#include "io/scene_json.h"
#include "io/volume_file.h"
#include "scene/scene.h"
#include "tyndall/render/error.h"
#include "tyndall/scene/limits.h"

namespace tyndall::io {

// ---- Errors: they are collected, and reading continues. ----

struct Finding {
  const Source* source;
  std::size_t offset;
  std::string path;
  std::string message;
  ExitCode code = ExitCode::scene_invalid;
  bool is_of_frame = false;  ///< about a file that only this frame of a sequence uses

  /// \return one line, with control characters of keys and values replaced.
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
  /// \param frames the files of a sequence, or null
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

  /// Calls `read` while the path is extended by a key or an index.
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

  /// Notes that the value at the current path could not be read, so that errors of check() about
  /// its default are ignored.
  void give_up() { unread.push_back(path_); }

  /// \return the path of a file that the scene names, relative to the scene's folder.
  std::filesystem::path file(const std::string& name) const {
    return folder_ / std::filesystem::path(name);
  }

  const std::string& path() const { return path_; }
  /// \return the files that the key at the current path names in each frame; null if all frames use
  /// the same file.
  const std::vector<std::string>* frame_files() const {
    if (!sequence) return nullptr;
    const auto found = sequence->numbered.find(path_);
    return found == sequence->numbered.end() ? nullptr : &found->second;
  }
  /// Notes the file that the key at the current path names. \return whether to skip reading it.
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
  std::map<std::string, LoadedVolume> volumes;  ///< by file and grid; each is read once

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/// \return `did you mean "fov"?`, or the list of all known words if none is similar.
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

// ---- Additions to the descriptions, specialised for things that are read from files.

/// Completes a thing after all its keys are read without an error.
template <class T>
struct Finish {
  static void run(Reader&, const Node&, T&) {}
};

/// Visits all keys of a thing.
template <class T>
struct Keys {
  template <class V>
  void operator()(V& visitor) const {
    scene::visit_keys<T>(visitor);
  }
};

/// Maps an alternative of a variant to the file: calls use(name, doc, initial, keys, store).
/// Reading starts with the values of `initial`; store() converts the thing that was read to the
/// alternative.
template <class P>
struct Case {
  template <class Use>
  static void visit(const char* name, const char* doc, const scene::Things&, const Use& use) {
    use(name, doc, P{}, Keys<P>{}, [](P&& read) { return std::move(read); });
  }
};

/// Specialised for values that the file stores as another type: Thing, which of() converts.
template <class V>
struct WrittenAs {};

// ---- Types of values

template <class V>
inline constexpr bool is_list = false;
template <class E>
inline constexpr bool is_list<std::vector<E>> = true;
template <class V>
inline constexpr bool is_optional = false;
template <class V>
inline constexpr bool is_optional<std::optional<V>> = true;
/// Whether V is an object whose key "type" selects its other keys. A camera stores its type in a
/// member.
template <class V>
inline constexpr bool is_variant = std::is_same_v<V, scene::Camera>;
template <class... P>
inline constexpr bool is_variant<std::variant<P...>> = true;
template <class V>
concept is_written = requires {
  typename WrittenAs<V>::Thing;
};
template <class V>
using Element = std::decay_t<decltype(std::declval<V&>()[0])>;

/// Finds the doc of one kind of camera.
struct CameraDoc : scene::Visitor<CameraDoc> {
  explicit CameraDoc(scene::Projection of) : kind(of) {}
  template <class M, class Form>
  void operator()(scene::Name, M scene::Camera::*, const Form&, const char*, const char*) {}
  template <class Describe>
  void when(scene::Projection scene::Camera::*, scene::Projection value, const char* text,
            const Describe&) {
    if (value == kind) doc = text;
  }

  scene::Projection kind;
  const char* doc = "";
};

/// Calls use() for each alternative of a variant, as described at Case.
template <class V, class Use>
void for_cases(const scene::Things& form, const Use& use) {
  if constexpr (std::is_same_v<V, scene::Camera>) {
    for (const auto& [word, kind] : scene::words(scene::Type<scene::Projection>{})) {
      CameraDoc found(kind);
      scene::visit_keys<V>(found);
      V camera;
      camera.projection = kind;
      use(word, found.doc, camera, Keys<V>{}, [](V&& read) { return std::move(read); });
    }
  } else {
    const auto visit = [&]<class P>(scene::Type<P>, const char* name, const char* doc) {
      Case<P>::visit(name, doc, form, use);
    };
    scene::visit_cases<V>(visit);
  }
}

template <class V>
std::vector<std::string> case_names(const scene::Things& form) {
  std::vector<std::string> names;
  for_cases<V>(form, [&](const char* name, const auto&...) { names.push_back(name); });
  return names;
}
/// Whether the first alternative is the default without a "type".
template <class V>
inline constexpr bool has_usual_case = std::is_same_v<V, scene::Camera>;

/// \return e.g. `"open" or "periodic"`.
std::string one_of(const std::vector<std::string>& names);

template <class E>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const auto& [word, value] : scene::words(scene::Type<E>{})) names.push_back(word);
  return names;
}

/// \return the number of names in a list such as "x, y, z".
int count_of(const char* names);

using scene::form_of;

/// The names of a form's elements, and whether a single number may replace the list.
inline const char* names_of(const scene::Numbers& form) { return form.names; }
inline const char* names_of(const scene::Word&) { return "x, y, z"; }
inline bool or_one(const scene::Numbers& form) { return form.or_one; }
inline bool or_one(const scene::Word&) { return false; }

// ---- Descriptions of valid values, to complete "expected ..."

template <class V, class Form>
std::string expected(const Form& form) {
  if constexpr (std::is_same_v<Form, scene::Things>) {
    return is_list<V> ? "a list" : "";
  } else if constexpr (std::is_same_v<Form, scene::Text>) {
    return form.expected;
  } else if constexpr (is_list<V>) {
    return "a list";
  } else if constexpr (is_optional<V>) {
    return "null, or " + expected<typename V::value_type>(form);
  } else if constexpr (requires(V v) { v[0]; }) {
    const std::string each = expected<Element<V>>(form);
    return or_one(form) ? fmt::format("{}, or [{}] of such", each, names_of(form))
                        : fmt::format("[{}], each {}", names_of(form), each);
  } else if constexpr (std::is_same_v<Form, scene::Word>) {
    return one_of(names_of<V>());
  } else {
    return describe(form.range);
  }
}

// ---- Objects: their keys

/// Reduces the ways to describe a key to operator(), alias(), group() and alternatives() of
/// Derived. `thing` selects the keys that depend on its kind.
template <class Derived, class T>
class KeyVisitor : public scene::Visitor<Derived> {
 public:
  explicit KeyVisitor(const T& thing) : thing_of_kind_(thing) {}

  template <class B, class M>
  void part(const char*, M B::*, const Range&) {}
  template <class B>
  void optional(scene::Name name, double B::*member, double example, const Range& range,
                const char* unit, const char* doc) {
    self().alias(
        name, example, [member](T& thing, double value) { thing.*member = value; },
        scene::Numbers(range), unit, doc);
  }
  void file(scene::Name name, const char* example, const char* doc) {
    self().alias(
        name, std::string(example), [](T&, const std::string&) {},  // Finish reads it
        scene::Text{"the name of a file"}, "", doc);
  }
  template <class E, class Describe>
  void when(E T::*member, E value, const char*, const Describe& keys) {
    if (thing_of_kind_.*member == value) keys(self());
  }
  template <class M>
  void faces(M T::*member, const scene::Numbers& form, const char* doc) {
    for (std::size_t face = 0; face < scene::face_names.size(); ++face)
      self().alias(
          scene::face_names[face], typename M::value_type{},
          [=](T& thing, const auto& value) { (thing.*member)[face] = value; }, form, "", doc);
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }

  const T& thing_of_kind_;
};

/// A key with a constant value: "type", or the version.
struct Constant {
  const char* name;
  Json value;
  std::string expected;
  const char* doc;
  bool is_required;
};

/// Passes each key to `out`, with its value, or with the initial value of an alias.
template <class T, class Out>
class Entries : public KeyVisitor<Entries<T, Out>, T> {
 public:
  Entries(const T& thing, Out& out) : KeyVisitor<Entries, T>(thing), thing_(thing), out_(out) {}

  template <class B, class M, class Form>
  void operator()(scene::Name name, M B::*member, const Form& form, const char* unit,
                  const char* doc) {
    out_.entry(name, thing_.*member, form_of(form), unit, doc);
  }
  template <class M, class Set, class Form>
  void alias(scene::Name name, const M& initial, const Set&, const Form& form, const char* unit,
             const char* doc) {
    out_.entry(name, initial, form_of(form), unit, doc);
  }
  template <class Describe>
  void group(const char* name, const char* doc, const Describe& keys) {
    out_.group(name, doc, thing_, keys);
  }
  void alternatives(const scene::Alternatives& sets, bool one_needed = false) {
    out_.alternatives(sets, one_needed);
  }

 private:
  const T& thing_;
  Out& out_;
};

template <class T, class Describe, class Out>
void pass_on(const T& thing, const Describe& keys, Out& out) {
  Entries<T, Out> entries(thing, out);
  keys(entries);
}

/// The names of the keys of an object, with the sets that exclude each other.
class Outline {
 public:
  template <class T, class Describe>
  Outline(const T& thing, const Describe& keys, const Constant* constant) {
    if (constant) add(constant->name);
    pass_on(thing, keys, *this);
  }

  template <class... A>
  void entry(scene::Name name, const A&...) {
    add(name.text);
  }
  template <class... A>
  void group(const char* name, const A&...) {
    add(name);
  }
  void alternatives(const scene::Alternatives& sets, bool one_needed);

  /// \return the index of the alternative that `name` belongs to, -1 for none
  int alternative(const std::string& name) const;
  /// \return whether `a` and `b` belong to different alternatives of one choice
  bool exclude(const std::string& a, const std::string& b) const;

  using Sets = std::vector<std::vector<std::string>>;
  std::vector<std::string> names;
  Sets needed;  ///< alternatives of which one is required

 private:
  void add(const char* name);

  std::vector<Sets> choices_;
};

// ---- Reading. A value with an error is not changed.

void missing(Reader& reader, const Node& node, const std::string& expected);
template <class V, class Form>
void read_value(Reader& reader, const Node& node, V& value, const Form& form);

template <class T, class Describe>
void read_object(Reader& reader, const Node& node, T& thing, const Describe& keys,
                 const Constant* constant = nullptr);

/// \return whether the key is given with a valid value.
template <class V, class Form>
bool read_key(Reader& reader, const Node& node, scene::Name name, V& value, const Form& form) {
  const Node* member = child(node, name.text);
  const std::size_t errors = reader.errors.size();
  if (member)
    reader.within(name.text, [&] { read_value(reader, *member, value, form); });
  else if (name.is_required)
    reader.within(name.text, [&] { missing(reader, node, expected<V>(form)); });
  return member && reader.errors.size() == errors;
}

template <class T>
class ObjectReader : public KeyVisitor<ObjectReader<T>, T> {
 public:
  ObjectReader(Reader& reader, const Node& node, T& thing)
      : KeyVisitor<ObjectReader, T>(thing), reader_(reader), node_(node), thing_(thing) {}

  template <class B, class M, class Form>
  void operator()(scene::Name name, M B::*member, const Form& form, const char*, const char*) {
    read_key(reader_, node_, name, thing_.*member, form_of(form));
  }
  template <class M, class Set, class Form>
  void alias(scene::Name name, const M& initial, const Set& set, const Form& form, const char*,
             const char*) {
    M value = initial;
    if (read_key(reader_, node_, name, value, form_of(form))) set(thing_, value);
  }
  template <class Describe>
  void group(const char* name, const char*, const Describe& keys) {
    if (const Node* member = child(node_, name))
      reader_.within(name, [&] { read_object(reader_, *member, thing_, keys); });
  }

 private:
  Reader& reader_;
  const Node& node_;
  T& thing_;
};

/// Refuses unknown and repeated keys. \return whether the node is an object.
bool begin_object(Reader& reader, const Node& node, const Outline& outline,
                  const Constant* constant);
void refuse_alternatives(Reader& reader, const Node& node, const Outline& outline);

template <class T, class Describe>
void read_object(Reader& reader, const Node& node, T& thing, const Describe& keys,
                 const Constant* constant) {
  const Outline outline(thing, keys, constant);
  if (!begin_object(reader, node, outline, constant)) return;
  ObjectReader<T> visitor(reader, node, thing);
  keys(visitor);
  refuse_alternatives(reader, node, outline);
}

/// Reads an object and completes it. \return whether it has no errors.
template <class T, class Describe>
bool read_thing(Reader& reader, const Node& node, T& thing, const Describe& keys,
                const Constant* constant = nullptr) {
  const std::size_t errors = reader.errors.size();
  read_object(reader, node, thing, keys, constant);
  if (reader.errors.size() == errors) Finish<T>::run(reader, node, thing);
  return reader.errors.size() == errors;
}

inline Constant type_constant(const char* name, const char* doc, bool is_usual) {
  return {"type", name, "", doc, !is_usual};
}

template <class V>
void read_variant(Reader& reader, const Node& node, V& value, const scene::Things& form) {
  const std::size_t errors = reader.errors.size();
  const std::vector<std::string> names = case_names<V>(form);
  const Node* type = child(node, "type");
  const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    return type ? type->value == Json(name) : has_usual_case<V> && name == names[0];
  });
  if (!node.value.is_object()) {
    reader.expected(node, has_usual_case<V> ? "an object" : "an object with a \"type\"");
  } else if (found != names.end()) {
    for_cases<V>(form, [&](const char* name, const char* doc, auto thing, const auto& keys,
                           const auto& store) {
      if (name != *found) return;
      const Constant constant = type_constant(name, doc, has_usual_case<V> && name == names[0]);
      if (read_thing(reader, node, thing, keys, &constant)) value = store(std::move(thing));
    });
  } else {
    reader.within("type", [&] {
      if (!type) return missing(reader, node, one_of(names));
      const std::string word = type->value.is_string() ? type->value.get<std::string>() : "";
      reader.error(*type, fmt::format("expected {}, got {}; {}", one_of(names), quote(*type),
                                      suggestion(word, names)));
    });
  }
  if (reader.errors.size() > errors) reader.give_up();
}

template <class V>
void read_written(Reader& reader, const Node& node, V& value) {
  using Thing = typename WrittenAs<V>::Thing;
  Thing thing;
  read_thing(reader, node, thing, Keys<Thing>{});
  value = WrittenAs<V>::of(thing);
}

/// Reads an integer, written as 8000000 or 8e6.
template <class Integer>
void read_integer(Reader& reader, const Node& node, Integer& value, const Range& range) {
  constexpr double exact = 9007199254740992.0;  // 2^53: larger doubles are not exact
  const Json& json = node.value;
  const double x = json.is_number() ? json.get<double>() : 0.5;
  const bool whole = json.is_number_integer() || (x == std::floor(x) && std::abs(x) <= exact);
  if (!whole || !range.contains(x)) return reader.expected(node, describe(range));
  value = json.is_number_integer() ? json.get<Integer>() : static_cast<Integer>(x);
}

template <class V, class Form>
void read_list(Reader& reader, const Node& node, V& values, const Form& form) {
  if (!node.value.is_array()) return reader.expected(node, "a list");
  values.resize(node.children.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    reader.within(i, [&] { read_value(reader, node.children[i], values[i], form); });
}

template <class V, class Form>
void read_tuple(Reader& reader, const Node& node, V& values, const Form& form) {
  const int count = count_of(names_of(form));
  if (or_one(form) && node.value.is_number()) {
    Element<V> one = values[0];
    read_value(reader, node, one, form);
    for (int i = 0; i < count; ++i) values[i] = one;
  } else if (!node.value.is_array() || node.children.size() != static_cast<std::size_t>(count)) {
    reader.expected(node, expected<V>(form));
  } else {
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      reader.within(at, [&] { read_value(reader, node.children[at], values[i], form); });
    }
  }
}

template <class V, class Form>
void read_value(Reader& reader, const Node& node, V& value, const Form& form) {
  if constexpr (is_list<V>) {
    read_list(reader, node, value, form);
  } else if constexpr (std::is_same_v<Form, scene::Things>) {
    if constexpr (is_variant<V>)
      read_variant(reader, node, value, form);
    else if constexpr (is_written<V>)
      read_written(reader, node, value);
    else
      read_thing(reader, node, value, Keys<V>{});
  } else if constexpr (std::is_same_v<Form, scene::Text>) {
    if (!node.value.is_string()) return reader.expected(node, form.expected);
    value = node.value.get<std::string>();
  } else if constexpr (is_optional<V>) {
    value.reset();
    if (!node.value.is_null()) read_value(reader, node, value.emplace(), form);
  } else if constexpr (requires { value[0]; }) {
    read_tuple(reader, node, value, form);
  } else if constexpr (std::is_same_v<Form, scene::Word>) {
    for (const auto& [word, meaning] : scene::words(scene::Type<V>{})) {
      if (node.value == word) {
        value = meaning;
        return;
      }
    }
    reader.expected(node, expected<V>(form));
  } else if constexpr (std::is_integral_v<V>) {
    read_integer(reader, node, value, form.range);
  } else {
    const bool good = node.value.is_number() && form.range.contains(node.value.get<double>());
    if (!good) return reader.expected(node, describe(form.range));
    value = static_cast<V>(node.value.get<double>());
  }
}

// ---- Values as JSON, with comments

/// Whether values of this form are objects, or lists of objects.
template <class Form>
inline constexpr bool is_composite = std::is_same_v<Form, scene::Things>;

template <class T, class Describe>
std::string list_of_object(const T& thing, const std::string& indent, const Describe& keys,
                           const Constant* constant = nullptr);

template <class V>
std::string list_of_case(const scene::Things& form, std::size_t at, const std::string& indent) {
  std::string list;
  std::size_t i = 0;
  for_cases<V>(form, [&](const char* name, const char* doc, const auto& thing, const auto& keys,
                         const auto&) {
    if (i++ != at) return;
    const Constant constant = type_constant(name, doc, has_usual_case<V> && at == 0);
    list = list_of_object(thing, indent, keys, &constant);
  });
  return list;
}

template <class V, class Form>
std::string list_of(const V& value, const Form& form, const std::string& indent) {
  if constexpr (is_list<V>) {
    if constexpr (!is_composite<Form>) return "[]";
    const typename V::value_type element{};
    return fmt::format("[\n{0}  {1}\n{0}]", indent, list_of(element, form, indent + "  "));
  } else if constexpr (is_composite<Form>) {
    if constexpr (is_variant<V>)
      return list_of_case<V>(form, 0, indent);
    else if constexpr (is_written<V>)
      return list_of(typename WrittenAs<V>::Thing{}, form, indent);
    else
      return list_of_object(value, indent, Keys<V>{});
  } else if constexpr (std::is_same_v<Form, scene::Text>) {
    return Json(value).dump();
  } else if constexpr (is_optional<V>) {
    return value ? list_of(*value, form, indent) : "null";
  } else if constexpr (requires { value[0]; }) {
    std::string list;
    for (int i = 0; i < count_of(names_of(form)); ++i)
      list += (i == 0 ? "" : ", ") + list_of(value[i], form, indent);
    return '[' + list + ']';
  } else if constexpr (std::is_same_v<Form, scene::Word>) {
    for (const auto& [word, meaning] : scene::words(scene::Type<V>{}))
      if (meaning == value) return fmt::format("\"{}\"", word);
    return "null";
  } else {
    return fmt::format("{}", value);
  }
}

std::string as_alternative(const std::string& block, const std::string& indent);

/// \return comments that list the alternatives to the value.
template <class V>
std::string others(const scene::Things& form, const std::string& indent) {
  std::string out;
  if constexpr (is_list<V>) {
    out = others<typename V::value_type>(form, indent);
  } else if constexpr (is_variant<V>) {
    for (std::size_t i = 1; i < case_names<V>(form).size(); ++i)
      out += as_alternative(list_of_case<V>(form, i, ""), indent);
  }
  return out;
}

class ObjectLister {
 public:
  ObjectLister(const Outline& outline, const std::string& indent);

  template <class M, class Form>
  void entry(scene::Name name, const M& value, const Form& form, const char* unit,
             const char* doc) {
    const std::string remark = comment(name, unit, doc, expected<M>(form)),
                      list = list_of(value, form, indent_);
    if constexpr (is_composite<Form>)
      block(name.text, others<M>(form, indent_), list, remark);
    else
      line(name.text, list, remark);
  }
  template <class T, class Describe>
  void group(const char* name, const char* doc, const T& thing, const Describe& keys) {
    block(name, "", list_of_object(thing, indent_, keys), doc);
  }
  void alternatives(const scene::Alternatives&, bool) {}
  void constant(const Constant& c);

  std::string text;

 private:
  static std::string comment(scene::Name name, const std::string& unit, const std::string& doc,
                             const std::string& what);
  void block(const std::string& name, const std::string& alternatives, const std::string& list,
             const std::string& remark);
  void line(const std::string& name, const std::string& list, const std::string& remark);
  /// \return whether the key is listed as a comment, because it excludes keys that are listed.
  bool is_spare(const std::string& name) const;
  const char* comma(const std::string& name) const;

  const Outline& outline_;
  const std::string indent_;
  std::string last_;
};

template <class T, class Describe>
std::string list_of_object(const T& thing, const std::string& indent, const Describe& keys,
                           const Constant* constant) {
  const Outline outline(thing, keys, constant);
  ObjectLister lister(outline, indent + "  ");
  if (constant) lister.constant(*constant);
  pass_on(thing, keys, lister);
  return "{\n" + lister.text + indent + "}";
}

// ---- JSON Schema

template <class T, class Describe>
Json schema_of_object(const T& thing, const Describe& keys, const Constant* constant = nullptr);

Json schema_of(const Range& range, const char* type);

template <class V, class Form>
Json schema_of(const Form& form) {
  if constexpr (is_list<V>) {
    return {{"type", "array"}, {"items", schema_of<typename V::value_type>(form)}};
  } else if constexpr (is_composite<Form>) {
    if constexpr (is_variant<V>) {
      Json schema{{"oneOf", Json::array()}};
      for_cases<V>(form, [&](const char* name, const char* doc, const auto& thing, const auto& keys,
                             const auto&) {
        const Constant constant =
            type_constant(name, doc, has_usual_case<V> && schema["oneOf"].empty());
        schema["oneOf"].push_back(schema_of_object(thing, keys, &constant));
      });
      return schema;
    } else if constexpr (is_written<V>) {
      return schema_of<typename WrittenAs<V>::Thing>(form);
    } else {
      return schema_of_object(V{}, Keys<V>{});
    }
  } else if constexpr (std::is_same_v<Form, scene::Text>) {
    return {{"type", "string"}};
  } else if constexpr (is_optional<V>) {
    return {{"anyOf", {Json{{"type", "null"}}, schema_of<typename V::value_type>(form)}}};
  } else if constexpr (requires(V v) { v[0]; }) {
    const Json each = schema_of<Element<V>>(form);
    const int count = count_of(names_of(form));
    const Json list{{"type", "array"}, {"items", each}, {"minItems", count}, {"maxItems", count}};
    return or_one(form) ? Json{{"anyOf", {each, list}}} : list;
  } else if constexpr (std::is_same_v<Form, scene::Word>) {
    return {{"enum", names_of<V>()}};
  } else {
    return schema_of(form.range, std::is_integral_v<V> ? "integer" : "number");
  }
}

class ObjectSchema {
 public:
  explicit ObjectSchema(const Outline& outline) : outline_(outline) {}

  template <class M, class Form>
  void entry(scene::Name name, const M& value, const Form& form, const char* unit,
             const char* doc) {
    const bool has_default =
        !is_composite<Form> && !name.is_required && outline_.alternative(name.text) < 0;
    add(name, schema_of<M>(form), unit, doc, has_default ? list_of(value, form, "") : "");
  }
  template <class T, class Describe>
  void group(const char* name, const char* doc, const T& thing, const Describe& keys) {
    add(name, schema_of_object(thing, keys), "", doc, "");
  }
  void alternatives(const scene::Alternatives&, bool) {}
  void constant(const Constant& c);

  Json whole() const;

 private:
  void add(scene::Name name, Json property, const std::string& unit, const std::string& doc,
           const std::string& initial);

  const Outline& outline_;
  Json properties_ = Json::object(), required_ = Json::array();
};

template <class T, class Describe>
Json schema_of_object(const T& thing, const Describe& keys, const Constant* constant) {
  const Outline outline(thing, keys, constant);
  ObjectSchema object(outline);
  if (constant) object.constant(*constant);
  pass_on(thing, keys, object);
  return object.whole();
}

}  // namespace tyndall::io
