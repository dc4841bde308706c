#include "furrow/base/fields.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "furrow/base/text.h"

namespace furrow::base {

Fields::Fields(const Value& value, std::string file, std::string section)
    : value_(value), file_(std::move(file)), section_(std::move(section)) {
  if (!value_.is_null() && value_.object() == nullptr) {
    error_ = Error{"wrong_kind", where(value_.line), "'" + section_ + "' is " + value_.kind_name(),
                   "a mapping (name: value)", ""};
  }
}

std::string Fields::where(int line) const {
  return line > 0 ? file_ + ":" + std::to_string(line) : file_;
}

const Value* Fields::member(const std::string& key) {
  known_.push_back(key);
  return value_.find(key);
}

const Value* Fields::look_up(const std::string& key, bool needed) {
  const Value* found = member(key);
  if (found == nullptr && needed && !error_) {
    const std::string place = section_.empty() ? "" : " in '" + section_ + "'";
    error_ = Error{"missing_key", where(value_.line), "'" + key + "' is missing" + place, "", ""};
  }
  return error_ ? nullptr : found;
}

void Fields::fail(const std::string& key, const std::string& found, const std::string& wanted) {
  if (error_) return;
  const Value* at = value_.find(key);
  const std::string name = section_.empty() ? key : section_ + "." + key;
  error_ =
      Error{"bad_value", where(at != nullptr ? at->line : value_.line), name + " is " + found, wanted, ""};
}

void Fields::require(bool holds, const std::string& key, const std::string& found,
                     const std::string& wanted) {
  if (!holds) fail(key, found, wanted);
}

void Fields::read(const std::string& key, double& out, bool needed) {
  const Value* at = look_up(key, needed);
  if (at == nullptr) return;
  const auto number = at->number();
  if (number && std::isfinite(*number)) {
    out = *number;
  } else {
    fail(key, at->string() != nullptr ? "'" + *at->string() + "'" : at->kind_name(), "a number");
  }
}

void Fields::optional(const std::string& key, std::optional<double>& out) {
  double number = std::numeric_limits<double>::quiet_NaN();
  read(key, number, false);
  if (!std::isnan(number)) out = number;
}

void Fields::read(const std::string& key, int& out, bool needed) {
  const Value* at = look_up(key, needed);
  if (at == nullptr) return;
  const auto number = at->integer();
  if (number && *number >= std::numeric_limits<int>::min() && *number <= std::numeric_limits<int>::max()) {
    out = static_cast<int>(*number);
  } else {
    fail(key, at->string() != nullptr ? "'" + *at->string() + "'" : at->kind_name(), "a whole number");
  }
}

void Fields::read(const std::string& key, bool& out, bool needed) {
  const Value* at = look_up(key, needed);
  if (at == nullptr) return;
  if (at->boolean() != nullptr) {
    out = *at->boolean();
  } else {
    fail(key, at->kind_name(), "true or false");
  }
}

void Fields::read(const std::string& key, std::string& out, bool needed) {
  const Value* at = look_up(key, needed);
  if (at == nullptr) return;
  if (at->string() != nullptr) {
    out = *at->string();
  } else if (at->number()) {
    out = at->integer() ? std::to_string(*at->integer())
                        : format_double(*at->number());  // name: 2026 is a fine name
  } else {
    fail(key, at->kind_name(), "text");
  }
}

void Fields::read(const std::string& key, std::vector<double>& out, bool needed) {
  const Value* at = look_up(key, needed);
  if (at == nullptr) return;
  std::vector<double> numbers;
  if (at->array() != nullptr) {
    for (const Value& item : *at->array()) {
      if (!item.number() || !std::isfinite(*item.number()))
        return fail(key, "a list with " + item.kind_name(), "a list of numbers");
      numbers.push_back(*item.number());
    }
    out = std::move(numbers);
  } else {
    fail(key, at->kind_name(), "a list of numbers");
  }
}

void Fields::read(const std::string& key, std::vector<std::string>& out, bool needed) {
  const Value* at = look_up(key, needed);
  if (at == nullptr) return;
  if (at->string() != nullptr) {
    out = {*at->string()};
    return;
  }
  std::vector<std::string> texts;
  if (at->array() == nullptr) return fail(key, at->kind_name(), "text or a list of texts");
  for (const Value& item : *at->array()) {
    if (item.string() == nullptr) return fail(key, "a list with " + item.kind_name(), "a list of texts");
    texts.push_back(*item.string());
  }
  out = std::move(texts);
}

Status Fields::finish() {
  // A key nobody knows often explains another that is missing or at odds, so it is named first.
  const bool stands_alone = error_ && error_->code == "wrong_kind";
  if (!stands_alone && value_.object() != nullptr) {
    for (const auto& [key, member_value] : *value_.object()) {
      if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
      const auto nearest = nearest_name(key, known_);
      std::string names;
      for (const auto& name : known_) names += (names.empty() ? "" : ", ") + name;
      const std::string place = section_.empty() ? "" : " in '" + section_ + "'";
      error_ = Error{"unknown_key", where(member_value.line), "unknown key '" + key + "'" + place,
                     nearest ? "'" + *nearest + "' perhaps" : "one of " + names, ""};
      break;
    }
  }
  if (error_) return *error_;
  return Done{};
}

}  // namespace furrow::base
