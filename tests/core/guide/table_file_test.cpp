#include "core/guide/table_file.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TableFile example() {
  TableFile t;
  t.header.id = "0123456789abcdef0123456789abcdef";
  t.header.parents = {"p1", "p2"};
  t.header.method = "huang";
  t.header.program = "1.2.3";
  t.header.geometry.bytes[3] = 7;
  t.header.lights.bytes[31] = 9;
  t.header.samples_seen = 1ull << 40;
  t.sections = {{"ABCD", {1, 2, 3}}, {"EFGH", {}}};
  return t;
}

TEST(TableFile, ComesBackAsItWas) {
  const TableFile in = example();
  const Result<TableFile> out = decode_table(encode_table(in));
  ASSERT_TRUE(out.ok()) << out.error().text();
  EXPECT_EQ(out.value().header.id, in.header.id);
  EXPECT_EQ(out.value().header.parents, in.header.parents);
  EXPECT_EQ(out.value().header.geometry, in.header.geometry);
  EXPECT_EQ(out.value().header.lights, in.header.lights);
  EXPECT_EQ(out.value().header.samples_seen, in.header.samples_seen);
  ASSERT_EQ(out.value().sections.size(), 2u);
  EXPECT_EQ(out.value().sections[0].bytes, in.sections[0].bytes);
  EXPECT_EQ(encode_table(out.value()), encode_table(in));
  for (const uint32_t version : kTableVersions) {
    TableFile older = in;
    older.header.version = version;
    const Bytes bytes = encode_table(older);
    ASSERT_TRUE(decode_table(bytes).ok());
    EXPECT_EQ(encode_table(decode_table(bytes).value()), bytes) << "so that its id stays its own";
  }
}

TEST(TableFile, NoFlippedBitPasses) {
  const Bytes good = encode_table(example());
  for (size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<uint8_t>(1u << (bit % 8));
    const Result<TableFile> out = decode_table(bad);
    // A section's tag has no checksum: another tag is the guide's to refuse.
    if (out.ok()) {
      EXPECT_TRUE(out.value().sections[0].tag != "ABCD" || out.value().sections[1].tag != "EFGH")
          << "bit " << bit;
    }
  }
}

TEST(TableFile, NoCutOffFilePasses) {
  const Bytes good = encode_table(example());
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decode_table(std::span(good).first(size)).ok()) << size;
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_FALSE(decode_table(longer).ok());
}

TEST(TableFile, ErrorsSayWhere) {
  Bytes bad = encode_table(example());
  for (uint8_t version : {uint8_t{1}, uint8_t{99}}) {  // 1: records were others
    bad[8] = version;
    const Result<TableFile> out = decode_table(bad);
    ASSERT_FALSE(out.ok());
    EXPECT_EQ(out.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(out.error().where, "table, byte 8");
    EXPECT_EQ(out.error().message,
              "table format version " + std::to_string(version) + ", expected 2, 4, 7, 8 or 11");
  }
}

}  // namespace
}  // namespace qray
