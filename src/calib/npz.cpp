#include "calib/npz.h"

#include <zlib.h>

#include <array>
#include <bit>
#include <cstring>

namespace furrow::calib {
namespace {

static_assert(std::endian::native == std::endian::little, "npy data are written as they lie in memory");

/// `bytes` low bytes of a number, lowest first.
std::string little_endian(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
  return out;
}

template <class T>
std::string raw(const std::vector<T>& values) {
  std::string out(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(out.data(), values.data(), out.size());
  return out;
}

/// What a zip member's local header and its entry in the directory have in common
/// (APPNOTE.TXT 4.3.7, 4.3.12): stored, and the first day that zip knows as its date.
std::string zip_fields(const std::string& name, const std::string& content) {
  constexpr int kVersion = 20, kFirstOfJanuary1980 = 0x21;
  const auto crc =
      crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()));
  return little_endian(kVersion, 2) + little_endian(0, 2) + little_endian(0, 2) + little_endian(0, 2) +
         little_endian(kFirstOfJanuary1980, 2) + little_endian(crc, 4) + little_endian(content.size(), 4) +
         little_endian(content.size(), 4) + little_endian(name.size(), 2) + little_endian(0, 2);
}

}  // namespace

void Npz::add_npy(const std::string& name, const std::string& type, const std::vector<int>& shape,
                  const std::string& data) {
  std::string sizes;
  for (const int side : shape) sizes += std::to_string(side) + ", ";
  std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + sizes + "), }";
  constexpr std::size_t kBefore = 10, kAlignment = 64;
  while ((kBefore + header.size() + 1) % kAlignment != 0) header += ' ';
  header += '\n';
  members_.push_back({name + ".npy", std::string("\x93NUMPY\x01", 7) + '\0' +
                                         little_endian(header.size(), 2) + header + data});
}

void Npz::add(const std::string& name, const std::vector<int>& shape, const std::vector<double>& values) {
  add_npy(name, "<f8", shape, raw(values));
}

void Npz::add(const std::string& name, const std::vector<int>& shape,
              const std::vector<std::int32_t>& values) {
  add_npy(name, "<i4", shape, raw(values));
}

void Npz::add_number(const std::string& name, double value) {
  add_npy(name, "<f8", {}, raw(std::vector<double>{value}));
}

void Npz::add_flag(const std::string& name, bool value) {
  add_npy(name, "|b1", {}, std::string(1, value ? '\1' : '\0'));
}

void Npz::add_text(const std::string& name, const std::string& ascii) {
  // numpy has no text of length 0; one blank character reads back as none.
  std::string wide;
  for (const char c : ascii) wide += little_endian(static_cast<unsigned char>(c), 4);
  if (ascii.empty()) wide = little_endian(0, 4);
  add_npy(name, "<U" + std::to_string(wide.size() / 4), {}, wide);
}

std::string Npz::bytes() const {
  std::string out, directory;
  for (const Member& member : members_) {
    const std::string fields = zip_fields(member.name, member.content);
    directory += "PK\x01\x02" + little_endian(20, 2) + fields + little_endian(0, 6) + little_endian(0, 4) +
                 little_endian(out.size(), 4) + member.name;
    out += "PK\x03\x04" + fields + member.name + member.content;
  }
  const std::size_t start = out.size();
  out += directory + "PK\x05\x06" + little_endian(0, 4) + little_endian(members_.size(), 2) +
         little_endian(members_.size(), 2) + little_endian(directory.size(), 4) + little_endian(start, 4) +
         little_endian(0, 2);
  return out;
}

std::string base85(const std::string& bytes) {
  static constexpr char kAlphabet[] =
      "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;<=>?@^_`{|}~";
  std::string out;
  out.reserve(bytes.size() / 4 * 5 + 5);
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i)
      word = word << 8 | (at + i < bytes.size() ? static_cast<unsigned char>(bytes[at + i]) : 0U);
    std::array<char, 5> digits{};
    for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit) {
      *digit = kAlphabet[word % 85];
      word /= 85;
    }
    const std::size_t padding = at + 4 > bytes.size() ? at + 4 - bytes.size() : 0;
    out.append(digits.data(), digits.size() - padding);
  }
  return out;
}

}  // namespace furrow::calib
