#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::base {

class Value;
using Array = std::vector<Value>;
/// Members in file order.
using Object = std::vector<std::pair<std::string, Value>>;

/// A JSON or YAML document as a plain tree. Numbers keep whether they were written as integers.
class Value {
 public:
  using Data = std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object>;

  Value() = default;
  Value(bool v) : data(v) {}
  Value(int v) : data(std::int64_t{v}) {}
  Value(std::int64_t v) : data(v) {}
  Value(std::size_t v) : data(static_cast<std::int64_t>(v)) {}
  Value(double v) : data(v) {}
  Value(const char* v) : data(std::string(v)) {}
  Value(std::string_view v) : data(std::string(v)) {}
  Value(std::string v) : data(std::move(v)) {}
  Value(Array v) : data(std::move(v)) {}
  Value(Object v) : data(std::move(v)) {}

  bool is_null() const { return std::holds_alternative<std::monostate>(data); }
  const Object* object() const { return std::get_if<Object>(&data); }
  const Array* array() const { return std::get_if<Array>(&data); }
  const std::string* string() const { return std::get_if<std::string>(&data); }
  const bool* boolean() const { return std::get_if<bool>(&data); }
  /// The number as a double, integers included; nothing for other kinds.
  std::optional<double> number() const;
  std::optional<std::int64_t> integer() const;
  /// The member called `key`, or null when this is no object or has none.
  const Value* find(std::string_view key) const;
  /// Appends a member. This must be an object or null (null becomes an object).
  Value& set(std::string key, Value value);
  /// "a mapping", "a list", "a number", ... for error messages.
  std::string kind_name() const;

  Data data;
  int line = 0;  ///< 1-based line in the file it was read from; 0 when made by a program
};

/// Parses YAML; `name` stands in error messages. Errors: malformed_yaml (with the line). Anchors are refused,
/// so that no input grows without bound; so are duplicate keys.
Result<Value> parse_yaml(std::string_view text, const std::string& name);
Result<Value> read_yaml(const std::filesystem::path& file);

/// Parses strict JSON. Errors: malformed_json.
Result<Value> parse_json(std::string_view text, const std::string& name);
Result<Value> read_json(const std::filesystem::path& file);

/// JSON with `indent` blanks a level (-1: one line), members in order, shortest round-trip numbers; NaN and
/// infinities as null.
std::string to_json(const Value& value, int indent = 2);

}  // namespace furrow::base
