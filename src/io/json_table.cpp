#include "io/json_table.h"

namespace tyndall::io {
namespace {

/// \return the edit distance (Levenshtein) of two names.
std::size_t edit_distance(std::string_view a, std::string_view b) {
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

}  // namespace

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  const auto distance = [&](const std::string& name) {
    return edit_distance(word.substr(0, 64), name);
  };
  const auto nearest =
      std::min_element(known.begin(), known.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (nearest != known.end() && distance(*nearest) <= 1 + nearest->size() / 3) {
    return fmt::format("did you mean \"{}\"?", *nearest);
  }
  return fmt::format("known here: {}", fmt::join(known, ", "));
}

std::string one_of(const std::vector<std::string>& names) {
  return fmt::format("\"{}\"", fmt::join(names, "\" or \""));
}

int count_of(const char* names) {
  const std::string_view text(names);
  return 1 + static_cast<int>(std::count(text.begin(), text.end(), ','));
}

// ---- Outline

namespace {

int index(const Outline::Sets& sets, const std::string& name) {
  for (std::size_t i = 0; i < sets.size(); ++i)
    if (std::find(sets[i].begin(), sets[i].end(), name) != sets[i].end())
      return static_cast<int>(i);
  return -1;
}

}  // namespace

void Outline::add(const char* name) { names.emplace_back(name); }

void Outline::alternatives(const scene::Alternatives& sets, bool one_needed) {
  Sets& choice = choices_.emplace_back();
  for (const auto& set : sets) choice.emplace_back(set.begin(), set.end());
  if (one_needed) needed = choice;
}

int Outline::alternative(const std::string& name) const {
  int found = -1;
  for (const Sets& sets : choices_) found = std::max(found, index(sets, name));
  return found;
}

bool Outline::exclude(const std::string& a, const std::string& b) const {
  return std::any_of(choices_.begin(), choices_.end(), [&](const Sets& sets) {
    const int i = index(sets, a), j = index(sets, b);
    return i >= 0 && j >= 0 && i != j;
  });
}

// ---- Reading

void missing(Reader& reader, const Node& node, const std::string& what) {
  reader.error(node, what.empty() ? "missing" : "missing; expected " + what);
}

namespace {

void refuse_unknown_keys(Reader& reader, const Node& node, const std::vector<std::string>& known) {
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

}  // namespace

bool begin_object(Reader& reader, const Node& node, const Outline& outline,
                  const Constant* constant) {
  if (!node.value.is_object()) {
    reader.expected(node, "an object");
    return false;
  }
  refuse_unknown_keys(reader, node, outline.names);
  if (constant && constant->is_required && !child(node, constant->name))
    reader.within(constant->name, [&] { missing(reader, node, constant->expected); });
  return true;
}

void refuse_alternatives(Reader& reader, const Node& node, const Outline& outline) {
  for (const Node& member : node.children) {
    for (const Node& other : node.children) {
      if (&other == &member) break;
      if (!outline.exclude(member.key, other.key)) continue;
      reader.within(member.key, [&] {
        reader.error_at_key(member, fmt::format("cannot be given together with \"{}\"", other.key));
      });
      break;
    }
  }
  std::vector<std::string> names;
  for (const auto& alternative : outline.needed) {
    for (const std::string& name : alternative)
      if (child(node, name)) return;
    names.push_back(alternative.front());
  }
  if (!names.empty())
    reader.error(node, fmt::format("missing \"{}\"", fmt::join(names, "\" or \"")));
}

// ---- Values as JSON, with comments

std::string as_alternative(const std::string& block, const std::string& indent) {
  std::string out = indent + "// or ";
  for (const char c : block) {
    out += c;
    if (c == '\n') out += indent + "// ";
  }
  return out + '\n';
}

ObjectLister::ObjectLister(const Outline& outline, const std::string& indent)
    : outline_(outline), indent_(indent) {
  for (const std::string& name : outline.names)
    if (!is_spare(name)) last_ = name;
}

std::string ObjectLister::comment(scene::Name name, const std::string& unit, const std::string& doc,
                                  const std::string& what) {
  return doc + (unit.empty() ? "" : " [" + unit + "]") + (what.empty() ? "" : "; " + what)
         + (name.is_required ? "; required" : "");
}

void ObjectLister::block(const std::string& name, const std::string& alternatives,
                         const std::string& list, const std::string& remark) {
  text += fmt::format("{0}// {1}\n{2}{0}\"{3}\": {4}{5}\n", indent_, remark, alternatives, name,
                      list, comma(name));
}

void ObjectLister::line(const std::string& name, const std::string& list,
                        const std::string& remark) {
  text += fmt::format("{}{}\"{}\": {}{}  // {}\n", indent_, is_spare(name) ? "// or " : "", name,
                      list, comma(name), remark);
}

const char* ObjectLister::comma(const std::string& name) const {
  return name == last_ || is_spare(name) ? "" : ",";
}

void ObjectLister::constant(const Constant& c) {
  line(c.name, c.value.dump(), comment({c.name, c.is_required}, "", c.doc, c.expected));
}

bool ObjectLister::is_spare(const std::string& name) const {
  return outline_.alternative(name) > 0;
}

// ---- JSON Schema

Json schema_of(const Range& range, const char* type) {
  // JSON Schema compares numbers by value: 1 and 1.0 are the same.
  Json schema{{"type", type}};
  if (std::isfinite(range.low)) schema[range.open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) schema[range.open ? "exclusiveMaximum" : "maximum"] = range.high;
  return schema;
}

void ObjectSchema::constant(const Constant& c) {
  add({c.name, c.is_required}, Json{{"const", c.value}}, "", c.doc,
      c.is_required ? "" : c.value.dump());
}

void ObjectSchema::add(scene::Name name, Json property, const std::string& unit,
                       const std::string& doc, const std::string& initial) {
  if (!doc.empty()) property["description"] = unit.empty() ? doc : doc + " [" + unit + "]";
  if (name.is_required) required_.push_back(name.text);
  if (!initial.empty()) property["default"] = Json::parse(initial);
  properties_[name.text] = std::move(property);
}

Json ObjectSchema::whole() const {
  Json schema{{"type", "object"}, {"properties", properties_}, {"additionalProperties", false}};
  if (!required_.empty()) schema["required"] = required_;
  for (const std::string& name : outline_.names)
    for (const std::string& other : outline_.names)
      if (outline_.exclude(name, other) && outline_.alternative(other) > outline_.alternative(name))
        schema["allOf"].push_back({{"not", {{"required", {name, other}}}}});
  for (const auto& names : outline_.needed) schema["anyOf"].push_back({{"required", names}});
  return schema;
}

}  // namespace tyndall::io
