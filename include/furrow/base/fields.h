#pragma once
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/value.h"

namespace furrow::base {

/// Reads a mapping into plain variables and refuses what it was not asked for.
///
///   Fields fields(value, "project.yaml", "rows");
///   fields.required("spacing_m", options.spacing_m);
///   fields.optional("height_m", options.height_m);
///   FURROW_DO(fields.finish());
///
/// The first fault is kept and returned by finish(): wrong kind, missing key, or a key nobody asked for, with
/// its line and the nearest known name. After a fault the remaining reads do nothing.
class Fields {
 public:
  /// `value` must outlive this. A null value counts as an empty mapping.
  Fields(const Value& value, std::string file, std::string section);

  void required(const std::string& key, double& out) { read(key, out, true); }
  void required(const std::string& key, int& out) { read(key, out, true); }
  void required(const std::string& key, bool& out) { read(key, out, true); }
  void required(const std::string& key, std::string& out) { read(key, out, true); }
  void required(const std::string& key, std::vector<double>& out) { read(key, out, true); }
  void required(const std::string& key, std::vector<std::string>& out) { read(key, out, true); }
  void optional(const std::string& key, double& out) { read(key, out, false); }
  void optional(const std::string& key, int& out) { read(key, out, false); }
  void optional(const std::string& key, bool& out) { read(key, out, false); }
  void optional(const std::string& key, std::string& out) { read(key, out, false); }
  void optional(const std::string& key, std::vector<double>& out) { read(key, out, false); }
  void optional(const std::string& key, std::vector<std::string>& out) { read(key, out, false); }
  /// As above; the variable gets a value only when the key is there.
  void optional(const std::string& key, std::optional<double>& out);

  /// The member `key` for a Fields or a loop of its own; null when absent. Marks the key as known.
  const Value* member(const std::string& key);

  /// Records a fault of the caller's own ("spacing_m is -3; wanted a length above 0"), at the line of `key`.
  void fail(const std::string& key, const std::string& found, const std::string& wanted);
  /// As fail(), unless `holds`.
  void require(bool holds, const std::string& key, const std::string& found, const std::string& wanted);

  bool ok() const { return !error_.has_value(); }
  /// The first fault, an unknown key included.
  Status finish();

 private:
  void read(const std::string& key, double& out, bool needed);
  void read(const std::string& key, int& out, bool needed);
  void read(const std::string& key, bool& out, bool needed);
  void read(const std::string& key, std::string& out, bool needed);
  void read(const std::string& key, std::vector<double>& out, bool needed);
  void read(const std::string& key, std::vector<std::string>& out, bool needed);
  const Value* look_up(const std::string& key, bool needed);
  std::string where(int line) const;

  const Value& value_;
  std::string file_;
  std::string section_;
  std::vector<std::string> known_;
  std::optional<Error> error_;
};

}  // namespace furrow::base
