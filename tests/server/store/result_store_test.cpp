#include "server/store/result_store.h"

#include <gtest/gtest.h>

#include <climits>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

// Every tile has its own samples and colours; tile `skipped` has none.
void fill(Film& film, int skipped = -1) {
  for (int i = film.tile_count() - 1; i >= 0; --i) {
    if (i == skipped) continue;
    const TileRect rect = film.tile(i);
    std::vector<Rgb> sums(static_cast<size_t>(rect.width * rect.height));
    for (size_t k = 0; k < sums.size(); ++k) {
      sums[k] = Rgb{0.1f * static_cast<float>(k), static_cast<float>(i), 1e-3f};
    }
    film.add(i, sums, static_cast<uint32_t>(3 + i));
    if (i == 1) film.add(i, sums, 3);
  }
}

void expect_same(const Film::Changes& a, const Film::Changes& b) {
  EXPECT_EQ(a.cursor, b.cursor);
  EXPECT_EQ(a.left_out, b.left_out);
  ASSERT_EQ(a.tiles.size(), b.tiles.size());
  for (size_t i = 0; i < a.tiles.size(); ++i) {
    EXPECT_EQ(a.tiles[i].index, b.tiles[i].index);
    EXPECT_EQ(a.tiles[i].version, b.tiles[i].version);
    EXPECT_EQ(a.tiles[i].samples, b.tiles[i].samples);
    EXPECT_TRUE(a.tiles[i].mean == b.tiles[i].mean) << i;
  }
}

TEST(Picture, TilesAreThoseOfTheFilm) {
  Film film(200, 70);
  for (int index = 0; index < film.tile_count(); ++index) {
    const TileRect a = film.tile(index), b = tile_rect(200, 70, index);
    EXPECT_TRUE(a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height) << index;
  }
}

TEST(ResultStore, GivesTheSameTilesAfterARestart) {
  const qray::test::ScratchFolder scratch;
  Film film(200, 70);
  fill(film, /*skipped=*/2);
  ASSERT_TRUE(ResultStore(scratch.path()).save(JobId{1}, film, {{"seed", "7"}}).ok());

  ResultStore restarted(scratch.path());
  const auto picture = restarted.load(JobId{1});
  ASSERT_TRUE(picture.ok()) << picture.error().text();
  for (uint64_t since = 0; since <= film.version() + 1; ++since) {
    for (int limit : {0, 1, 3, INT_MAX}) {
      expect_same(picture.value()->tiles_since(since, limit), film.tiles_since(since, limit));
    }
  }
  const auto file = scratch / "results/j000001/image.exr";
  EXPECT_EQ(read_image_metadata(file).value()["seed"], "7");
}

TEST(ResultStore, MissingAndDamaged) {
  const qray::test::ScratchFolder scratch;
  Film film(10, 10);
  fill(film);
  ASSERT_TRUE(ResultStore(scratch.path()).save(JobId{1}, film, {}).ok());
  ResultStore store(scratch.path());
  EXPECT_EQ(store.load(JobId{2}).error().code, ErrorCode::kNotFound);
  const auto marks = scratch / "results/j000001/tiles.bin";
  Bytes bytes = read_file(marks, 1 << 20).value();
  for (size_t at = 0; at < bytes.size(); ++at) {
    Bytes damaged = bytes;
    damaged[at] ^= 0x40;
    ASSERT_TRUE(write_file_atomic(marks, damaged).ok());
    EXPECT_FALSE(ResultStore(scratch.path()).load(JobId{1}).ok()) << at;
  }
  bytes.pop_back();
  ASSERT_TRUE(write_file_atomic(marks, bytes).ok());
  EXPECT_FALSE(ResultStore(scratch.path()).load(JobId{1}).ok());
}

TEST(ResultStore, KeepsTheLastPicturesInMemory) {
  const qray::test::ScratchFolder scratch;
  Film film(10, 10);
  fill(film);
  ResultStore store(scratch.path(), /*cache_bytes=*/3000);  // two pictures of 1,216 bytes
  for (uint64_t id = 1; id <= 3; ++id) ASSERT_TRUE(store.save(JobId{id}, film, {}).ok());
  std::filesystem::remove_all(scratch / "results");
  EXPECT_FALSE(store.load(JobId{1}).ok());
  EXPECT_TRUE(store.load(JobId{2}).ok());
  EXPECT_TRUE(store.load(JobId{3}).ok());
}

TEST(ResultStore, FramesAreKeptApartAndGoTogether) {
  const qray::test::ScratchFolder scratch;
  Film film(10, 10), other(10, 10);
  fill(film);
  fill(other, /*skipped=*/0);
  ResultStore store(scratch.path());
  ASSERT_TRUE(store.save(JobId{1}, film, {{"frame", "0"}}).ok());
  ASSERT_TRUE(store.save({JobId{1}, 7}, other, {{"frame", "7"}}).ok());
  ASSERT_TRUE(store.save_frames(JobId{1}, "[]").ok());
  ResultStore restarted(scratch.path());
  EXPECT_TRUE(restarted.load({JobId{1}, 7}).ok());
  EXPECT_EQ(restarted.load({JobId{1}, 1}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(restarted.load_frames(JobId{1}).value(), "[]");
  EXPECT_EQ(read_image_metadata(scratch / "results/j000001/image.exr").value()["frame"], "0");
  restarted.remove(JobId{1});
  EXPECT_FALSE(restarted.load(JobId{1}).ok());
  EXPECT_FALSE(restarted.load({JobId{1}, 7}).ok());
  EXPECT_FALSE(restarted.load_frames(JobId{1}).ok());
}

}  // namespace
}  // namespace qray::server
