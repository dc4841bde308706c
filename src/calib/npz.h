#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace furrow::calib {

/// Arrays as numpy's uncompressed .npz: a zip of .npy files (numpy.lib.format, version 1.0). Same arrays,
/// same bytes.
class Npz {
 public:
  void add(const std::string& name, const std::vector<int>& shape, const std::vector<double>& values);
  void add(const std::string& name, const std::vector<int>& shape, const std::vector<std::int32_t>& values);
  /// Scalars.
  void add_number(const std::string& name, double value);
  void add_flag(const std::string& name, bool value);
  void add_text(const std::string& name, const std::string& ascii);

  std::string bytes() const;

 private:
  struct Member {
    std::string name, content;
  };
  void add_npy(const std::string& name, const std::string& type, const std::vector<int>& shape,
               const std::string& data);
  std::vector<Member> members_;
};

/// Base 85 with the alphabet of Python's base64.b85encode (RFC 1924's), padding cut as there.
std::string base85(const std::string& bytes);

}  // namespace furrow::calib
