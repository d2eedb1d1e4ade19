// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace thenar {

/// A NumPy archive of named arrays, .npz: a ZIP archive of .npy files (version 1.0), without compression. NumPy reads
/// it without pickle.
class NpzArchive {
 public:
  /// Adds an array of numbers row by row, as many as the shape has.
  template <class Number>
  void add(const std::string& name, const std::vector<std::size_t>& shape, std::span<const Number> numbers) {
    constexpr const char* kType = std::is_same_v<Number, double>          ? "<f8"
                                  : std::is_same_v<Number, float>         ? "<f4"
                                  : std::is_same_v<Number, std::uint16_t> ? "<u2"
                                                                          : nullptr;
    static_assert(kType != nullptr);
    add_bytes(name, shape, kType, {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()});
  }
  /// Adds a list of names in UTF-8.
  void add_names(const std::string& name, const std::vector<std::string>& names);

  /// Returns the archive's bytes and gives up their ownership; nothing if the archive or an array has 4 GB or more.
  [[nodiscard]] std::optional<std::string> finish();

 private:
  void add_bytes(const std::string& name, const std::vector<std::size_t>& shape, const std::string& type,
                 std::string_view bytes);

  std::string bytes_, directory_;
  std::size_t entries_ = 0;
};

}  // namespace thenar
