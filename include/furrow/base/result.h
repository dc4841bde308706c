#pragma once
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace furrow::base {

/// Bad or missing data, in four parts that a person needs to mend it.
struct Error {
  std::string code;    ///< snake_case name that a program can test, e.g. "not_enough_rows"
  std::string where;   ///< file, file:line or shot id
  std::string found;   ///< what was found there
  std::string wanted;  ///< what was wanted instead; may be empty
  std::string hint;    ///< what to do next; may be empty

  /// "where: found; wanted W. Hint" - one sentence for a person.
  std::string message() const;
};

/// Misuse by the calling program: a precondition that the caller broke. Never thrown for bad data.
class CheckFailure : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws CheckFailure with `what` unless `holds`.
inline void check(bool holds, const char* what) {
  if (!holds) throw CheckFailure(what);
}

/// A value, or the Error that stood in its way.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& {
    check(ok(), "value() of a Result that holds an error");
    return std::get<0>(state_);
  }
  T& value() & {
    check(ok(), "value() of a Result that holds an error");
    return std::get<0>(state_);
  }
  T&& value() && {
    check(ok(), "value() of a Result that holds an error");
    return std::get<0>(std::move(state_));
  }
  const Error& error() const {
    check(!ok(), "error() of a Result that holds a value");
    return std::get<1>(state_);
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

 private:
  std::variant<T, Error> state_;
};

/// The value of a Result that has none: it went well.
struct Done {};
using Status = Result<Done>;

}  // namespace furrow::base

namespace furrow {
using base::check;
using base::Done;
using base::Error;
using base::Result;
using base::Status;
}  // namespace furrow

#define FURROW_CONCAT_INNER(a, b) a##b
#define FURROW_CONCAT(a, b) FURROW_CONCAT_INNER(a, b)
/// FURROW_TRY(auto x, f()): x becomes f's value, or the enclosing function returns f's error.
#define FURROW_TRY(declaration, ...) \
  FURROW_TRY_IMPL(FURROW_CONCAT(furrow_result_, __LINE__), declaration, __VA_ARGS__)
#define FURROW_TRY_IMPL(temporary, declaration, ...) \
  auto temporary = (__VA_ARGS__);                    \
  if (!temporary.ok()) return temporary.error();     \
  declaration = std::move(temporary).value()
/// FURROW_DO(f()): the enclosing function returns f's error, if there is one.
#define FURROW_DO(...) \
  if (auto furrow_status = (__VA_ARGS__); !furrow_status.ok()) return furrow_status.error()
