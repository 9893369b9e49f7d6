// The state of objects as bytes, so that work that was cut off goes on to the same bits. A class
// lists its members once, for both directions:
//   template <class Self, class Archive>
//   static void exchange(Self& self, Archive& archive) { archive(self.a_, self.b_); }
// A class that has none is refused by the compiler: memory is never copied as it lies.
//
// Encoding, little-endian. A number is a byte that names its kind and width, then its value. A
// vector is its tag, size and capacity (guides budget by it), a checksum of its elements' kinds and
// widths, then the elements' members without gaps. So a class that gained, lost or changed a member
// is noticed by who reads; one that swapped two of the same kind is not, which is what the version
// of the file is for (core/render/checkpoint.h). Not synchronised.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/byte_io.h"

namespace qray {

template <class T, class Archive>
concept Exchanged = requires(T& v, Archive& archive) {
  std::remove_const_t<T>::exchange(v, archive);
};

namespace snapshot {

// Numbers are copied as they lie, which is the encoding on these machines.
static_assert(std::endian::native == std::endian::little);
static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

template <class T>
concept Number = (std::is_arithmetic_v<T> || std::is_enum_v<T>)&&sizeof(T) <= 8;
// Whose bytes may be anything.
template <class T>
concept Bulk = Number<T> && !std::is_same_v<T, bool>;

enum Tag : uint8_t { kVector = 1, kArray, kList, kText, kMap, kOptional };

// Above those of Tag: 0x1n bool, 0x2n floating point, 0x3n signed, 0x4n unsigned, of n bytes.
template <Number T>
constexpr uint8_t tag_of() {
  if constexpr (std::is_enum_v<T>) {
    return tag_of<std::underlying_type_t<T>>();
  } else {
    const int kind = std::is_same_v<T, bool>       ? 0x10
                     : std::is_floating_point_v<T> ? 0x20
                     : std::is_signed_v<T>         ? 0x30
                                                   : 0x40;
    return static_cast<uint8_t>(kind | static_cast<int>(sizeof(T)));
  }
}

// What an element of a vector consists of: numbers, arrays, and classes of these.
class Shape {
 public:
  template <class T>
  static const Shape& of() {
    static const Shape shape = [] {
      Shape s;
      T element{};
      s.add(element);
      return s;
    }();
    return shape;
  }
  uint32_t kinds() const { return kinds_; }  // CRC-32C of the numbers' tags
  size_t bytes() const { return bytes_; }    // encoded

  template <class... T>
  void operator()(T&... values) {
    (add(values), ...);
  }

 private:
  template <class T>
  void add(T& v) {
    if constexpr (Number<T>) {
      const uint8_t tag = tag_of<T>();
      kinds_ = crc32c({&tag, 1}, kinds_);
      bytes_ += sizeof(T);
    } else {
      static_assert(Exchanged<T, Shape>, "the class needs an exchange(), without vectors in it");
      T::exchange(v, *this);
    }
  }
  template <class T, size_t kCount>
  void add(T (&v)[kCount]) {
    for (T& e : v) add(e);
  }
  template <class T, size_t kCount>
  void add(std::array<T, kCount>& v) {
    for (T& e : v) add(e);
  }

  uint32_t kinds_ = 0;
  size_t bytes_ = 0;
};

// One element's members, to memory that has room for Shape::bytes().
class FieldWriter {
 public:
  explicit FieldWriter(uint8_t* to) : to_(to) {}
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }

 private:
  template <class T>
  void put(const T& v) {
    if constexpr (Number<T>) {
      std::memcpy(to_, &v, sizeof v);
      to_ += sizeof v;
    } else {
      T::exchange(v, *this);
    }
  }
  template <class T, size_t kCount>
  void put(const T (&v)[kCount]) {
    for (const T& e : v) put(e);
  }
  template <class T, size_t kCount>
  void put(const std::array<T, kCount>& v) {
    for (const T& e : v) put(e);
  }

  uint8_t* to_;
};

// The same from such memory.
class FieldReader {
 public:
  explicit FieldReader(const uint8_t* from) : from_(from) {}
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  bool ok() const { return ok_; }  // false: a bool that is neither

 private:
  template <class T>
  void get(T& v) {
    if constexpr (std::is_same_v<T, bool>) {
      ok_ &= *from_ <= 1;
      v = *from_++ == 1;
    } else if constexpr (Number<T>) {
      std::memcpy(&v, from_, sizeof v);
      from_ += sizeof v;
    } else {
      T::exchange(v, *this);
    }
  }
  template <class T, size_t kCount>
  void get(T (&v)[kCount]) {
    for (T& e : v) get(e);
  }
  template <class T, size_t kCount>
  void get(std::array<T, kCount>& v) {
    for (T& e : v) get(e);
  }

  const uint8_t* from_;
  bool ok_ = true;
};

}  // namespace snapshot

class SnapshotWriter {
 public:
  using Sink = std::function<void(std::span<const uint8_t>)>;
  explicit SnapshotWriter(Sink sink) : sink_(std::move(sink)) {}

  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }

 private:
  static constexpr size_t kBlockBytes = 16 << 10;

  void raw(const void* bytes, size_t size) { sink_({static_cast<const uint8_t*>(bytes), size}); }
  template <snapshot::Number T>
  void bare(T v) {
    raw(&v, sizeof v);
  }
  void head(snapshot::Tag tag, uint64_t size) {
    bare(uint8_t{tag});
    bare(size);
  }
  template <class T>
  void elements(std::span<const T> v) {
    const snapshot::Shape& shape = snapshot::Shape::of<T>();
    bare(shape.kinds());
    if constexpr (snapshot::Bulk<T>) {
      raw(v.data(), v.size_bytes());
    } else {
      const size_t at_once = std::max<size_t>(1, kBlockBytes / std::max<size_t>(1, shape.bytes()));
      Bytes block(std::min(at_once, v.size()) * shape.bytes());
      while (!v.empty()) {
        const std::span<const T> some = v.first(std::min(at_once, v.size()));
        uint8_t* to = block.data();
        for (const T& element : some) {
          snapshot::FieldWriter out(to);
          out(element);
          to += shape.bytes();
        }
        raw(block.data(), some.size() * shape.bytes());
        v = v.subspan(some.size());
      }
    }
  }

  template <class T>
  void put(const T& v) {
    if constexpr (snapshot::Number<T>) {
      bare(snapshot::tag_of<T>());
      bare(v);
    } else {
      static_assert(Exchanged<const T, SnapshotWriter>, "the class needs an exchange()");
      T::exchange(v, *this);
    }
  }
  template <class T, size_t kCount>
  void put(const T (&v)[kCount]) {
    head(snapshot::kArray, kCount);
    elements(std::span<const T>(v));
  }
  template <class T, size_t kCount>
  void put(const std::array<T, kCount>& v) {
    head(snapshot::kArray, kCount);
    elements(std::span<const T>(v));
  }
  template <class T>
  void put(const std::vector<T>& v) {
    head(snapshot::kVector, v.size());
    bare(uint64_t{v.capacity()});
    elements(std::span<const T>(v));
  }
  void put(const std::vector<std::string>& v) {
    head(snapshot::kList, v.size());
    for (const std::string& text : v) put(text);
  }
  void put(const std::string& v) {
    head(snapshot::kText, v.size());
    raw(v.data(), v.size());
  }
  template <class K, class V>
  void put(const std::map<K, V>& v) {
    head(snapshot::kMap, v.size());
    for (const auto& [key, value] : v) (*this)(key, value);
  }
  template <class T>
  void put(const std::optional<T>& v) {
    head(snapshot::kOptional, v.has_value());
    if (v) put(*v);
  }

  Sink sink_;
};

// What does not fit turns ok() false; from then on nothing is read. So does what this machine has
// no memory for.
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
  // Of memory that a vector holds beyond its elements. It grows by doubling, and one that was
  // emptied keeps what it had: more than as much again and this no vector of a state has. What
  // claims more is damaged, and must not take the machine's memory.
  static constexpr uint64_t kMostEmptyBytes = uint64_t{1} << 30;

  void raw(void* to, size_t size) {
    if (!ok_ || size > bytes_.size()) return fail();
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  template <snapshot::Number T>
  T bare() {
    T v{};
    raw(&v, sizeof v);
    return v;
  }
  void expect(bool fits) {
    if (!fits) fail();
  }
  // Of elements that take at least `least` bytes each.
  uint64_t head(snapshot::Tag tag, size_t least) {
    expect(bare<uint8_t>() == tag);
    const uint64_t size = bare<uint64_t>();
    expect(size <= bytes_.size() / std::max<size_t>(1, least));
    return ok_ ? size : 0;
  }
  template <class T>
  void elements(std::span<T> v) {
    const snapshot::Shape& shape = snapshot::Shape::of<T>();
    expect(bare<uint32_t>() == shape.kinds());
    expect(v.size() <= bytes_.size() / std::max<size_t>(1, shape.bytes()));
    if (!ok_) return;
    if constexpr (snapshot::Bulk<T>) {
      raw(v.data(), v.size_bytes());
    } else {
      bool fits = true;
      for (size_t i = 0; i < v.size(); ++i) {
        snapshot::FieldReader in(bytes_.data() + i * shape.bytes());
        in(v[i]);
        fits &= in.ok();
      }
      bytes_ = bytes_.subspan(v.size() * shape.bytes());
      expect(fits);
    }
  }

  template <class T>
  void get(T& v) {
    if constexpr (std::is_same_v<T, bool>) {
      expect(bare<uint8_t>() == snapshot::tag_of<bool>());
      const uint8_t value = bare<uint8_t>();
      expect(value <= 1);
      v = ok_ && value == 1;
    } else if constexpr (snapshot::Number<T>) {
      expect(bare<uint8_t>() == snapshot::tag_of<T>());
      raw(&v, sizeof v);
    } else {
      static_assert(Exchanged<T, SnapshotReader>, "the class needs an exchange()");
      T::exchange(v, *this);
    }
  }
  template <class T, size_t kCount>
  void get(T (&v)[kCount]) {
    expect(head(snapshot::kArray, 0) == kCount);
    elements(std::span<T>(v));
  }
  template <class T, size_t kCount>
  void get(std::array<T, kCount>& v) {
    expect(head(snapshot::kArray, 0) == kCount);
    elements(std::span<T>(v));
  }
  template <class T>
  void get(std::vector<T>& v) {
    const uint64_t size = head(snapshot::kVector, snapshot::Shape::of<T>().bytes());
    const uint64_t capacity = bare<uint64_t>();
    expect(size <= capacity && capacity - size <= size + kMostEmptyBytes / sizeof(T));
    if (!ok_) return;
    std::vector<T> fresh;
    try {
      fresh.reserve(capacity);
    } catch (const std::bad_alloc&) {
      return fail();
    }
    fresh.resize(size);
    elements(std::span<T>(fresh));
    if (ok_) v = std::move(fresh);
  }
  void get(std::vector<std::string>& v) {
    v.clear();
    for (uint64_t n = head(snapshot::kList, 1); n > 0 && ok_; --n) get(v.emplace_back());
  }
  void get(std::string& v) {
    v.resize(head(snapshot::kText, 1));
    raw(v.data(), v.size());
  }
  template <class K, class V>
  void get(std::map<K, V>& v) {
    v.clear();
    for (uint64_t n = head(snapshot::kMap, 1); n > 0 && ok_; --n) {
      K key{};
      get(key);
      get(v[key]);
    }
  }
  template <class T>
  void get(std::optional<T>& v) {
    const uint64_t there = head(snapshot::kOptional, 1);
    expect(there <= 1);
    if (!ok_ || there == 0) return v.reset();
    if (!v) v.emplace();
    get(*v);
  }

  std::span<const uint8_t> bytes_;
  bool ok_ = true;
};

}  // namespace qray
