// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine/grasp/model.h"

/// Archives of numbers and structures of them, in the machine's byte order. `a(x, y)` writes x and y or reads them. A
/// struct names its members once, for both: in a function `members(a, x)` or, where they are private, in its own
/// `members(a)`.
namespace thenar {

/// An archive that writes values to `bytes`, without changing them.
class StateWriter {
 public:
  static constexpr bool kReads = false;

  template <typename... T>
  void operator()(T&... values) {
    (archive(*this, values), ...);
  }
  void raw(const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); }

  std::string bytes;
};

/// An archive that reads values into objects of the same model. Throws std::invalid_argument if the bytes end early or
/// contain an impossible size; its memory is proportional to the bytes.
class StateReader {
 public:
  static constexpr bool kReads = true;

  /// Keeps references to the bytes and the model.
  StateReader(std::string_view bytes, const Model& model) : left_(bytes), model_(model) {}

  template <typename... T>
  void operator()(T&... values) {
    (archive(*this, values), ...);
  }
  void raw(void* data, std::size_t size) {
    require(size <= left_.size());
    if (size > 0) std::memcpy(data, left_.data(), size);
    left_.remove_prefix(size);
  }
  static void require(bool is_sound) {
    if (!is_sound) throw std::invalid_argument("the state is damaged");
  }
  /// Makes a new value by `place`, a container's or an optional's emplace, with the model where needed.
  template <typename T, typename Place>
  void make(const Place& place) const {
    if constexpr (std::is_default_constructible_v<T>) {
      place();
    } else if constexpr (std::is_constructible_v<T, const Model&>) {
      place(model_);
    } else {
      require(false);
    }
  }
  [[nodiscard]] std::size_t left() const { return left_.size(); }

 private:
  std::string_view left_;
  const Model& model_;
};

template <typename Archive, typename T>
void archive(Archive& a, T& x) {
  if constexpr (std::is_same_v<T, bool>) {
    unsigned char byte = x ? 1 : 0;
    a.raw(&byte, 1);
    if constexpr (Archive::kReads) x = byte != 0;
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    a.raw(&x, sizeof x);
  } else if constexpr (requires { x.members(a); }) {
    x.members(a);
  } else {
    members(a, x);
  }
}

template <typename Archive, typename S, int R, int C, int O, int MR, int MC>
void archive(Archive& a, Eigen::Matrix<S, R, C, O, MR, MC>& x) {
  if constexpr (R == Eigen::Dynamic || C == Eigen::Dynamic) {
    constexpr std::uint32_t kMost = 1U << 24U;
    auto rows = static_cast<std::uint32_t>(x.rows()), cols = static_cast<std::uint32_t>(x.cols());
    a(rows, cols);
    if constexpr (Archive::kReads) {
      const auto fits = [](std::uint32_t size, int fixed, int most) {
        return fixed == Eigen::Dynamic ? size <= (most == Eigen::Dynamic ? kMost : static_cast<std::uint32_t>(most))
                                       : size == static_cast<std::uint32_t>(fixed);
      };
      a.require(fits(rows, R, MR) && fits(cols, C, MC));
      a.require(std::uint64_t{rows} * cols <= a.left() / sizeof(S));
      x.resize(rows, cols);
    }
  }
  a.raw(x.data(), static_cast<std::size_t>(x.size()) * sizeof(S));
}

template <typename Archive>
void archive(Archive& a, Eigen::Isometry3d& x) {
  a(x.matrix());
}

template <typename Archive>
void archive(Archive& a, std::string& x) {
  std::uint64_t size = x.size();
  a(size);
  if constexpr (Archive::kReads) {
    a.require(size <= a.left());
    x.resize(size);
  }
  a.raw(x.data(), size);
}

template <typename Archive, typename T, std::size_t kSize>
void archive(Archive& a, std::array<T, kSize>& x) {
  for (T& one : x) a(one);
}

template <typename Archive, typename T>
void archive(Archive& a, PerFinger<T>& x) {
  auto fingers = static_cast<std::uint8_t>(x.size());
  a(fingers);
  if constexpr (Archive::kReads) {
    a.require(fingers <= kMaxFingers);
    T blank{};
    if constexpr (requires { blank.setIdentity(); }) blank.setIdentity();
    x = PerFinger<T>(fingers, blank);
  }
  for (T& one : x) a(one);
}

template <typename Archive, typename T>
void archive(Archive& a, std::vector<T>& x) {
  std::uint64_t size = x.size();
  a(size);
  if constexpr (Archive::kReads) {
    // One by one: an impossible size ends with the bytes.
    x.clear();
    for (; size > 0; --size) {
      a.template make<T>([&](const auto&... of) { x.emplace_back(of...); });
      a(x.back());
    }
  } else {
    for (T& one : x) a(one);
  }
}

template <typename Archive, typename T>
void archive(Archive& a, std::optional<T>& x) {
  bool has = x.has_value();
  a(has);
  if constexpr (Archive::kReads) {
    if (!has) x.reset();
    if (has && !x) a.template make<T>([&](const auto&... of) { x.emplace(of...); });
  }
  if (has) a(*x);
}

template <typename Archive, typename T>
void archive(Archive& a, std::shared_ptr<const T>& x) {
  std::optional<T> value;
  if (!Archive::kReads && x) value = *x;
  a(value);
  if constexpr (Archive::kReads) x = value ? std::make_shared<const T>(*value) : nullptr;
}

/// Engines and distributions, in the standard's text form.
template <typename Archive, typename Random>
requires requires(Random x) { x.min(), x.max(), x.reset(); } || requires(Random x) {
  x.discard(0);
}
void archive(Archive& a, Random& x) {
  std::string text;
  if constexpr (!Archive::kReads) {
    std::ostringstream out;
    out << x;
    text = out.str();
  }
  a(text);
  if constexpr (Archive::kReads) {
    std::istringstream in(text);
    in >> x;
    a.require(!in.fail());
  }
}

}  // namespace thenar
