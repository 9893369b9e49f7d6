// The exact state of objects in memory, so that work that was cut off goes on to the same bits. Raw
// bytes with their sizes: for this program on this machine and nobody else; what people exchange is
// written with byte_io.h. A class lists its members once, for both directions:
//   template <class Self, class Archive>
//   static void exchange(Self& self, Archive& archive) { archive(self.a_, self.b_); }
// Vectors keep their capacity too, since guides budget by it.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace qray {

template <class T, class Archive>
concept Exchanged = requires(T& v, Archive& archive) {
  std::remove_const_t<T>::exchange(v, archive);
};

class SnapshotWriter {
 public:
  using Sink = std::function<void(std::span<const uint8_t>)>;
  explicit SnapshotWriter(Sink sink) : sink_(std::move(sink)) {}

  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }

 private:
  void raw(const void* bytes, size_t size) { sink_({static_cast<const uint8_t*>(bytes), size}); }
  template <class T>
  void put(const T& v) {
    if constexpr (Exchanged<const T, SnapshotWriter>) {
      T::exchange(v, *this);
    } else {
      static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
      raw(&v, sizeof v);
    }
  }
  template <class T>
  void put(const std::vector<T>& v) {
    (*this)(uint64_t{v.size()}, uint64_t{v.capacity()}, uint64_t{sizeof(T)});
    if constexpr (Exchanged<const T, SnapshotWriter> || !std::is_trivially_copyable_v<T>) {
      for (const T& element : v) put(element);
    } else {
      raw(v.data(), v.size() * sizeof(T));
    }
  }
  void put(const std::string& v) {
    put(uint64_t{v.size()});
    raw(v.data(), v.size());
  }
  template <class K, class V>
  void put(const std::map<K, V>& v) {
    put(uint64_t{v.size()});
    for (const auto& [key, value] : v) (*this)(key, value);
  }
  template <class T>
  void put(const std::optional<T>& v) {
    put(v.has_value());
    if (v) put(*v);
  }

  Sink sink_;
};

// What does not fit turns ok() false; from then on nothing is read.
class SnapshotReader {
 public:
  explicit SnapshotReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  bool ok() const { return ok_; }
  void fail() { ok_ = false; }
  size_t remaining() const { return bytes_.size(); }
  bool whole() const { return ok_ && bytes_.empty(); }  // all was read

 private:
  static constexpr uint64_t kMaxBytes = uint64_t{1} << 38;

  void raw(void* to, size_t size) {
    if (!ok_ || size > bytes_.size()) return fail();
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  uint64_t number() {
    uint64_t v = 0;
    raw(&v, sizeof v);
    return v;
  }
  // Of elements that take at least `least` bytes each.
  uint64_t count(size_t least) {
    const uint64_t n = number();
    if (n > bytes_.size() / least) fail();
    return ok_ ? n : 0;
  }
  template <class T>
  void get(T& v) {
    if constexpr (Exchanged<T, SnapshotReader>) {
      T::exchange(v, *this);
    } else {
      static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
      raw(&v, sizeof v);
    }
  }
  template <class T>
  void get(std::vector<T>& v) {
    constexpr bool whole = std::is_trivially_copyable_v<T> && !Exchanged<T, SnapshotReader>;
    const uint64_t size = count(1), capacity = number(), element = number();
    if (element != sizeof(T) || capacity < size || capacity > kMaxBytes / sizeof(T) ||
        (whole && size > bytes_.size() / sizeof(T)))
      fail();
    if (!ok_) return;
    std::vector<T> fresh;
    fresh.reserve(capacity);
    fresh.resize(size);
    if constexpr (whole) {
      raw(fresh.data(), size * sizeof(T));
    } else {
      for (T& e : fresh) get(e);
    }
    v = std::move(fresh);
  }
  void get(std::string& v) {
    v.resize(count(1));
    raw(v.data(), v.size());
  }
  template <class K, class V>
  void get(std::map<K, V>& v) {
    v.clear();
    for (uint64_t n = count(1); n > 0 && ok_; --n) {
      K key{};
      get(key);
      get(v[key]);
    }
  }
  template <class T>
  void get(std::optional<T>& v) {
    bool there = false;
    get(there);
    if (!there) return v.reset();
    if (!v) v.emplace();
    get(*v);
  }

  std::span<const uint8_t> bytes_;
  bool ok_ = true;
};

}  // namespace qray
