#include "camera/literal.h"

#include <cctype>
#include <optional>

#include "furrow/base/text.h"

namespace furrow::camera {
namespace {

using base::Value;

/// Deeper nesting is refused, so that recursion ends; a camera model needs 2.
constexpr int kMaxDepth = 16;

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  Result<Value> document() {
    FURROW_TRY(Value value, item(0));
    skip_blanks();
    if (at_ < text_.size()) return fault("text after the end of the model", "nothing more");
    return value;
  }

 private:
  Result<Value> item(int depth) {
    skip_blanks();
    if (depth > kMaxDepth) return fault("brackets nested too deep", "a camera model");
    if (at_ >= text_.size()) return fault("the end of the file", "a value");
    const int line = line_;
    Result<Value> read = item_of(text_[at_], depth);
    if (!read.ok()) return read;
    Value value = std::move(read).value();
    value.line = line;
    return value;
  }

  Result<Value> item_of(char c, int depth) {
    if (c == '{') return mapping(depth);
    if (c == '[') return list(']', depth);
    if (c == '(') return list(')', depth);
    if (c == '\'' || c == '"') return quoted();
    if (c == 'b' && at_ + 1 < text_.size() && (text_[at_ + 1] == '\'' || text_[at_ + 1] == '"')) {
      ++at_;
      if (auto bytes = quoted(); !bytes.ok()) return bytes;
      return Value("");
    }
    return word();
  }

  Result<Value> mapping(int depth) {
    Value out{base::Object{}};
    ++at_;
    while (!closes('}')) {
      FURROW_TRY(const Value key, item(depth + 1));
      if (key.string() == nullptr) return fault(key.kind_name() + " as a key", "a name in quotes");
      if (out.find(*key.string()) != nullptr) return fault("'" + *key.string() + "' twice", "each key once");
      skip_blanks();
      if (at_ >= text_.size() || text_[at_] != ':')
        return fault("no ':' after '" + *key.string() + "'", "a value for it");
      ++at_;
      FURROW_TRY(Value member, item(depth + 1));
      out.set(*key.string(), std::move(member)).line = key.line;
      if (!separated('}')) return fault("no ',' after '" + *key.string() + "'", "',' or '}'");
    }
    return out;
  }

  Result<Value> list(char close, int depth) {
    base::Array out;
    ++at_;
    while (!closes(close)) {
      FURROW_TRY(Value element, item(depth + 1));
      out.push_back(std::move(element));
      if (!separated(close)) return fault("a list without its end", std::string("',' or '") + close + "'");
    }
    return Value(std::move(out));
  }

  /// Steps over `close` when it is next.
  bool closes(char close) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != close) return false;
    ++at_;
    return true;
  }

  /// After an element: a comma (stepped over) or the closing bracket (left there).
  bool separated(char close) {
    skip_blanks();
    if (at_ < text_.size() && text_[at_] == ',') {
      ++at_;
      return true;
    }
    return at_ < text_.size() && text_[at_] == close;
  }

  Result<Value> quoted() {
    const char mark = text_[at_++];
    std::string out;
    while (at_ < text_.size() && text_[at_] != mark && text_[at_] != '\n') {
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
      out += text_[at_++];
    }
    if (at_ >= text_.size() || text_[at_] != mark)
      return fault("a quoted text without its end", std::string(1, mark));
    ++at_;
    return Value(std::move(out));
  }

  Result<Value> word() {
    const std::size_t start = at_;
    while (at_ < text_.size() &&
           std::string_view(" \t\r\n,:]})#[{('\"").find(text_[at_]) == std::string_view::npos)
      ++at_;
    const std::string_view text = text_.substr(start, at_ - start);
    if (text == "None") return Value();
    if (text == "True") return Value(true);
    if (text == "False") return Value(false);
    if (const auto integer = base::parse_int(text)) return Value(*integer);
    if (const auto number = base::parse_double(text)) return Value(*number);
    // Shown short: the text may be a whole binary file.
    constexpr std::size_t kShown = 20;
    return fault("'" + std::string(text.substr(0, kShown)) + "'",
                 "a number, a quoted text, a list or a mapping");
  }

  void skip_blanks() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      } else if (std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
        line_ += text_[at_] == '\n' ? 1 : 0;
        ++at_;
      } else {
        return;
      }
    }
  }

  Error fault(const std::string& found, const std::string& wanted) const {
    return {"camera_file_invalid", name_ + ":" + std::to_string(line_), found, wanted, ""};
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 1;
};

}  // namespace

Result<Value> parse_literal(std::string_view text, const std::string& name) {
  return Reader(text, name).document();
}

}  // namespace furrow::camera
