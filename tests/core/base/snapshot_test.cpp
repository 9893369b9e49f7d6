#include "core/base/snapshot.h"

#include <gtest/gtest.h>

#include "core/math/vec.h"

namespace qray {
namespace {

enum class Colour : uint16_t { kRed = 1, kBlue = 0x0203 };

struct Part {
  uint8_t small = 0;
  uint64_t large = 0;  // seven bytes of padding before it, which are not written
  bool flag = false;
  std::array<float, 2> pair{};
  int16_t row[2]{};
  Rgb light;
  bool operator==(const Part&) const = default;
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.small, self.large, self.flag, self.pair, self.row, self.light);
  }
};

struct State {
  int32_t number = 0;
  double real = 0;
  bool flag = false;
  Colour colour = Colour::kRed;
  std::string text;
  std::vector<float> floats;
  std::vector<Part> parts;
  std::vector<std::string> words;
  std::map<std::string, uint32_t> counts;
  std::optional<Vec3> there, absent;
  int64_t row[2]{};
  std::array<uint8_t, 3> bytes{};

  bool operator==(const State& o) const {
    return number == o.number && real == o.real && flag == o.flag && colour == o.colour &&
           text == o.text && floats == o.floats && parts == o.parts && words == o.words &&
           counts == o.counts && there == o.there && absent == o.absent && row[0] == o.row[0] &&
           row[1] == o.row[1] && bytes == o.bytes;
  }
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.number, self.real, self.flag, self.colour, self.text, self.floats, self.parts,
            self.words, self.counts, self.there, self.absent, self.row, self.bytes);
  }
};

template <class... T>
Bytes written(const T&... values) {
  Bytes bytes;
  SnapshotWriter out(
      [&](std::span<const uint8_t> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  out(values...);
  return bytes;
}

template <class T>
std::optional<T> read(const Bytes& bytes) {
  SnapshotReader in(bytes);
  T value{};
  in(value);
  if (!in.whole()) return {};
  return value;
}

State some_state(size_t parts = 2) {
  State s{-5, 0.25, true, Colour::kBlue, "text", {1, -2, 3}, {}, {"", "word"}, {}, {}, {}, {}, {}};
  for (size_t i = 0; i < parts; ++i)
    s.parts.push_back({static_cast<uint8_t>(i),
                       i << 40,
                       i % 2 == 1,
                       {1.5f, static_cast<float>(i)},
                       {-1, 2},
                       Rgb(static_cast<float>(i))});
  s.counts = {{"a", 7}, {"b", 8}};
  s.there = Vec3{1, 2, 3};
  s.row[1] = -9;
  s.bytes = {4, 5, 6};
  return s;
}

TEST(Snapshot, WhatIsReadIsWhatWasWritten) {
  // 5,000 parts fill some blocks of the writer.
  for (const size_t parts : {0u, 1u, 2u, 5000u}) {
    const State state = some_state(parts);
    const std::optional<State> back = read<State>(written(state));
    ASSERT_TRUE(back) << parts;
    EXPECT_EQ(*back, state) << parts;
  }
}

TEST(Snapshot, VectorsKeepTheirCapacity) {
  std::vector<uint32_t> numbers{1, 2, 3};
  numbers.reserve(1000);
  const auto back = read<std::vector<uint32_t>>(written(numbers));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, numbers);
  EXPECT_EQ(back->capacity(), numbers.capacity());
}

// These bytes are in files: whoever changes them raises kStateFormat (core/render/checkpoint.h).
TEST(Snapshot, BytesOnPaper) {
  std::vector<Part> parts(1);
  parts[0] = {0xaa, 0x0102030405060708, true, {1.0f, -2.0f}, {-1, 2}, Rgb(1, 0, 0)};
  std::vector<uint16_t> numbers{1, 0x0203};
  numbers.shrink_to_fit();
  const Bytes bytes = written(int32_t{-2}, 1.0f, true, Colour::kBlue, std::string("ab"), numbers,
                              std::optional<uint8_t>(9), parts);
  const uint32_t numbers_kinds = crc32c(Bytes{0x42});
  const uint32_t part_kinds =
      crc32c(Bytes{0x41, 0x48, 0x11, 0x24, 0x24, 0x32, 0x32, 0x24, 0x24, 0x24});
  ByteWriter expected;
  expected.bytes(Bytes{0x34, 0xfe, 0xff, 0xff, 0xff});         // signed, 4 bytes
  expected.bytes(Bytes{0x24, 0, 0, 0x80, 0x3f});               // floating point, 4 bytes
  expected.bytes(Bytes{0x11, 1});                              // bool
  expected.bytes(Bytes{0x42, 3, 2});                           // unsigned, 2 bytes
  expected.bytes(Bytes{4, 2, 0, 0, 0, 0, 0, 0, 0, 'a', 'b'});  // text
  expected.u8(1);                                              // vector: size, capacity, kinds
  expected.u64(2);
  expected.u64(2);
  expected.u32(numbers_kinds);
  expected.bytes(Bytes{1, 0, 3, 2});
  expected.bytes(Bytes{6, 1, 0, 0, 0, 0, 0, 0, 0, 0x41, 9});  // optional
  expected.u8(1);
  expected.u64(1);
  expected.u64(1);
  expected.u32(part_kinds);
  expected.bytes(Bytes{0xaa, 8, 7, 6, 5, 4, 3, 2, 1, 1});
  expected.bytes(Bytes{0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0xff, 0xff, 2, 0});
  expected.bytes(Bytes{0, 0, 0x80, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(bytes, expected.data());
}

// One that gained, lost or changed a member.
struct LongerPart : Part {
  uint8_t more = 0;
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    Part::exchange(self, archive);
    archive(self.more);
  }
};
struct OtherPart : Part {
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.large, self.small, self.flag, self.pair, self.row, self.light);
  }
};

TEST(Snapshot, AnotherLayoutIsRefused) {
  const std::vector<Part> parts = some_state().parts;
  EXPECT_TRUE(read<std::vector<Part>>(written(parts)));
  EXPECT_FALSE(read<std::vector<LongerPart>>(written(parts)));
  EXPECT_FALSE(read<std::vector<OtherPart>>(written(parts)));
  EXPECT_FALSE(read<std::vector<LongerPart>>(written(std::vector<Part>())));
  EXPECT_FALSE(read<Part>(written(parts)));
  EXPECT_FALSE(read<uint32_t>(written(int32_t{1})));
  EXPECT_FALSE(read<float>(written(uint32_t{1})));
  EXPECT_FALSE(read<double>(written(1.0f)));
  EXPECT_FALSE(read<bool>(written(uint8_t{1})));
  EXPECT_FALSE(read<std::vector<uint8_t>>(written(std::string("abc"))));
  EXPECT_FALSE((read<std::array<uint8_t, 2>>(written(std::array<uint8_t, 3>{}))));
  EXPECT_FALSE(read<uint8_t>(written(uint8_t{1}, uint8_t{2})));
}

TEST(Snapshot, CutOffAnywhereItIsRefused) {
  const Bytes good = written(some_state());
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(read<State>({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}))
        << size;
}

// Without a checksum a flipped value cannot be told; it must be read as that state or not at all.
TEST(Snapshot, AnyFlippedBitIsReadOrRefusedButHarmsNothing) {
  const Bytes good = written(some_state());
  size_t refused = 0;
  for (size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
    if (!read<State>(bad)) ++refused;
  }
  EXPECT_GT(refused, good.size() * 2);  // tags, sizes, bools
}

}  // namespace
}  // namespace qray
