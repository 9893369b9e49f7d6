#include "server/jobs/tile_stream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/image/rgb9e5.h"

namespace qray::server {
namespace {

TEST(TileStream, IsAsDocumented) {
  Film film(70, 10);
  std::vector<Rgb> sums(60, Rgb{1, 0.5f, 0});  // the second tile: 6 x 10
  film.add(1, sums, 2);
  const Bytes bytes = encode_tiles(70, 10, film.tiles_since(0, 10));
  ByteReader in(bytes);
  EXPECT_EQ(in.u8(), 'Q');
  EXPECT_EQ(in.u8(), 'R');
  EXPECT_EQ(in.u8(), 'T');
  EXPECT_EQ(in.u8(), '1');
  EXPECT_EQ(in.u32(), 70u);
  EXPECT_EQ(in.u32(), 10u);
  EXPECT_EQ(in.u64(), 1u);  // cursor
  EXPECT_EQ(in.u32(), 1u);  // tiles
  EXPECT_EQ(in.u32(), 0u);  // left out
  EXPECT_EQ(in.u32(), 64u);
  EXPECT_EQ(in.u32(), 0u);
  EXPECT_EQ(in.u32(), 6u);
  EXPECT_EQ(in.u32(), 10u);
  EXPECT_EQ(in.u32(), 2u);  // samples
  const uint32_t crc = in.u32();
  EXPECT_EQ(crc, crc32c(std::span(bytes).subspan(in.offset())));
  for (int i = 0; i < 60; ++i) {
    const Rgb c = unpack_rgb9e5(in.u32());
    EXPECT_NEAR(c.r, 0.5f, 1e-3f);
    EXPECT_NEAR(c.g, 0.25f, 1e-3f);
    EXPECT_EQ(c.b, 0);
  }
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(in.remaining(), 0u);
}

TEST(TileStream, NoTiles) { EXPECT_EQ(encode_tiles(0, 0, {}).size(), 28u); }

}  // namespace
}  // namespace qray::server
