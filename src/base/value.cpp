#include "furrow/base/value.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "furrow/base/bytes.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"

namespace furrow::base {
namespace {

/// Deeper documents are refused: nobody writes them, and recursion must end.
constexpr int kMaxDepth = 64;

struct TooDeep {
  int line;
};
struct Anchored {
  int line;
};
struct Duplicate {
  std::string key;
  int line;
};

/// A plain YAML scalar under the core schema.
Value plain_scalar(const std::string& text) {
  if (text.empty() || text == "~" || text == "null" || text == "Null" || text == "NULL") return {};
  if (text == "true" || text == "True" || text == "TRUE") return true;
  if (text == "false" || text == "False" || text == "FALSE") return false;
  if (const auto integer = parse_int(text)) return *integer;
  if (const auto number = parse_double(text)) return *number;
  return text;
}

Value from_yaml(const YAML::Node& node, int depth) {
  const int line = node.Mark().line + 1;
  if (depth > kMaxDepth) throw TooDeep{line};
  Value value;
  if (node.IsScalar()) {
    // yaml-cpp tags quoted scalars "!".
    value = node.Tag() == "!" ? Value(node.Scalar()) : plain_scalar(node.Scalar());
  } else if (node.IsSequence()) {
    Array items;
    for (const auto& item : node) items.push_back(from_yaml(item, depth + 1));
    value = std::move(items);
  } else if (node.IsMap()) {
    value = Object{};
    for (const auto& member : node) {
      const std::string key = member.first.IsScalar() ? member.first.Scalar() : "";
      if (value.find(key) != nullptr) throw Duplicate{key, member.first.Mark().line + 1};
      value.set(key, from_yaml(member.second, depth + 1)).line = member.first.Mark().line + 1;
    }
  }
  value.line = line;
  return value;
}

/// Line of the first anchor or alias outside quotes and comments, 0 for none: aliases can grow a file without
/// bound.
int anchor_line(std::string_view text) {
  int line = 1;
  char quote = 0;
  char before = '\n';
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
      if (c == '\n') ++line;
    } else if (c == '\n') {
      ++line;
    } else if ((c == '"' || c == '\'') &&
               std::string_view(" \n[{:,-").find(before) != std::string_view::npos) {
      quote = c;
    } else if (c == '#' && (before == ' ' || before == '\n')) {
      quote = '\n';
    } else if ((c == '&' || c == '*') &&
               std::string_view(" \n[{:,-").find(before) != std::string_view::npos) {
      return line;
    }
    if (quote == '\n' && c == '\n') quote = 0;
    before = c;
  }
  return 0;
}

/// Line of the first byte that no text holds, 0 for none: a picture or a video is not worth a word on its
/// YAML.
int binary_line(std::string_view text) {
  int line = 1;
  for (const char c : text) {
    if (is_control(c)) return line;
    if (c == '\n') ++line;
  }
  return 0;
}

Error malformed_yaml(const std::string& name, int line, const std::string& what) {
  return {"malformed_yaml", name + ":" + std::to_string(line), what, "", ""};
}

using Json = nlohmann::ordered_json;

Value from_json(const Json& json) {
  switch (json.type()) {
    case Json::value_t::boolean:
      return json.get<bool>();
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
      return json.get<std::int64_t>();
    case Json::value_t::number_float:
      return json.get<double>();
    case Json::value_t::string:
      return json.get<std::string>();
    case Json::value_t::array: {
      Array items;
      for (const auto& item : json) items.push_back(from_json(item));
      return items;
    }
    case Json::value_t::object: {
      Object members;
      for (const auto& [key, member] : json.items()) members.emplace_back(key, from_json(member));
      return members;
    }
    default:
      return {};
  }
}

Json to_nlohmann(const Value& value) {
  struct Visitor {
    Json operator()(std::monostate) const { return nullptr; }
    Json operator()(bool v) const { return v; }
    Json operator()(std::int64_t v) const { return v; }
    Json operator()(double v) const { return std::isfinite(v) ? Json(v) : Json(nullptr); }
    Json operator()(const std::string& v) const { return v; }
    Json operator()(const Array& items) const {
      Json json = Json::array();
      for (const Value& item : items) json.push_back(to_nlohmann(item));
      return json;
    }
    Json operator()(const Object& members) const {
      Json json = Json::object();
      for (const auto& [key, member] : members) json[key] = to_nlohmann(member);
      return json;
    }
  };
  return std::visit(Visitor{}, value.data);
}

/// How deep brackets nest, strings left out.
int json_depth(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

std::optional<double> Value::number() const {
  if (const auto* v = std::get_if<double>(&data)) return *v;
  if (const auto* v = std::get_if<std::int64_t>(&data)) return static_cast<double>(*v);
  return std::nullopt;
}

std::optional<std::int64_t> Value::integer() const {
  if (const auto* v = std::get_if<std::int64_t>(&data)) return *v;
  return std::nullopt;
}

const Value* Value::find(std::string_view key) const {
  if (object() == nullptr) return nullptr;
  for (const auto& [name, value] : *object()) {
    if (name == key) return &value;
  }
  return nullptr;
}

Value& Value::set(std::string key, Value value) {
  if (is_null()) data = Object{};
  auto* members = std::get_if<Object>(&data);
  check(members != nullptr, "Value::set on something that is no object");
  members->emplace_back(std::move(key), std::move(value));
  return members->back().second;
}

std::string Value::kind_name() const {
  static constexpr const char* kNames[] = {"nothing", "true or false", "a whole number", "a number",
                                           "text",    "a list",        "a mapping"};
  return kNames[data.index()];
}

Result<Value> parse_yaml(std::string_view text, const std::string& name) {
  if (const int line = binary_line(text); line > 0)
    return malformed_yaml(name, line, "not YAML: bytes that are no text");
  if (const int line = anchor_line(text); line > 0) {
    return malformed_yaml(name, line,
                          "anchors and aliases (& and *) are not read; quote the text if it starts with one");
  }
  try {
    return from_yaml(YAML::Load(std::string(text)), 0);
  } catch (const TooDeep& deep) {
    return malformed_yaml(name, deep.line, "nested deeper than " + std::to_string(kMaxDepth) + " levels");
  } catch (const Duplicate& duplicate) {
    return malformed_yaml(name, duplicate.line, "key '" + duplicate.key + "' is given twice");
  } catch (const YAML::Exception& problem) {
    return malformed_yaml(name, problem.mark.line + 1, "not YAML: " + problem.msg);
  }
}

Result<Value> read_yaml(const std::filesystem::path& file) {
  FURROW_TRY(const std::string text, read_file(file, std::size_t{1} << 24));
  return parse_yaml(text, file.filename().string());
}

Result<Value> parse_json(std::string_view text, const std::string& name) {
  if (json_depth(text) > kMaxDepth) {
    return Error{"malformed_json", name, "nested deeper than " + std::to_string(kMaxDepth) + " levels", "",
                 ""};
  }
  try {
    return from_json(Json::parse(text));
  } catch (const Json::exception& problem) {
    return Error{"malformed_json", name, std::string("not JSON: ") + problem.what(), "", ""};
  }
}

Result<Value> read_json(const std::filesystem::path& file) {
  FURROW_TRY(const std::string text, read_file(file));
  return parse_json(text, file.filename().string());
}

std::string to_json(const Value& value, int indent) {
  return to_nlohmann(value).dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace furrow::base
