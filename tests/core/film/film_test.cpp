#include "core/film/film.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>

namespace qray {
namespace {

std::vector<Rgb> flat(const TileRect& rect, float value) {
  return std::vector<Rgb>(static_cast<size_t>(rect.width * rect.height), Rgb{value});
}

TEST(Film, TilesCoverThePictureOnce) {
  const Film film(130, 65);
  std::set<std::pair<int, int>> seen;
  for (int i = 0; i < film.tile_count(); ++i) {
    const TileRect r = film.tile(i);
    for (int y = r.y; y < r.y + r.height; ++y)
      for (int x = r.x; x < r.x + r.width; ++x) EXPECT_TRUE(seen.insert({x, y}).second);
  }
  EXPECT_EQ(film.tile_count(), 6);
  EXPECT_EQ(seen.size(), 130u * 65u);
}

TEST(Film, DevelopsTheMeanOfAllSamples) {
  Film film(10, 3);
  film.add(0, flat(film.tile(0), 2.0f), 1);
  film.add(0, flat(film.tile(0), 10.0f), 3);
  EXPECT_FLOAT_EQ(film.develop().at(9, 2, 1), 3.0f);
}

TEST(Film, WhatWasThereCountsAsMuchAsItIsWorth) {
  Film film(70, 3);
  for (int tile = 0; tile < 2; ++tile) film.add(tile, flat(film.tile(tile), 8.0f), 4);  // mean 2
  const uint64_t version = film.version();
  film.fade(0.25f);
  EXPECT_EQ(film.version(), version) << "the means are as they were";
  EXPECT_FLOAT_EQ(film.develop().at(69, 2, 1), 2.0f);
  film.add(1, flat(film.tile(1), 18.0f), 3);  // mean 6, weight 3 against 1
  EXPECT_FLOAT_EQ(film.develop().at(69, 2, 1), 5.0f);
  EXPECT_EQ(film.tiles_since(version, 9).tiles[0].samples, 7u);
}

TEST(Film, WhatWasSeenDirectlyIsAPartOfTheSums) {
  Film film(70, 3);
  film.add(0, flat(film.tile(0), 8.0f), 4, {}, flat(film.tile(0), 4.0f));
  film.fade(0.25f);
  film.add(0, flat(film.tile(0), 18.0f), 3, {}, flat(film.tile(0), 9.0f));
  film.add(1, flat(film.tile(1), 18.0f), 3);
  EXPECT_FLOAT_EQ(film.develop().at(9, 2, 1), 5.0f);
  EXPECT_FLOAT_EQ(film.seen().at(9, 2, 1), 2.5f);
  EXPECT_FLOAT_EQ(film.seen().at(69, 2, 1), 0) << "nothing, where none is told";
}

TEST(Film, PixelsMayHaveSamplesMoreOrLessOrNone) {
  Film film(4, 1);
  const std::vector<Rgb> sums{Rgb{6.0f}, Rgb{}, Rgb{8.0f}, Rgb{}};
  film.add(0, sums, 2, std::vector<uint32_t>{3, 0, 1, 0});
  film.add(0, sums, 2, std::vector<uint32_t>{1, 0, 3, 0});
  const Image image = film.develop();
  EXPECT_FLOAT_EQ(image.at(0, 0, 0), 3);
  EXPECT_FLOAT_EQ(image.at(1, 0, 0), 0);
  EXPECT_FLOAT_EQ(image.at(2, 0, 0), 4);
}

TEST(Film, APassCanWeighTheSameHoweverManySamplesAPixelHad) {
  Film film(3, 1, {.bounces = 1});
  const std::vector<Rgb> sums{Rgb{6.0f}, Rgb{2.0f}, Rgb{}}, fours(3, Rgb{4.0f});
  film.add(0, fours, 4, {}, fours, fours);                                       // means of 1
  film.add(0, sums, 2, std::vector<uint32_t>{3, 1, 0}, sums, sums, /*each=*/2);  // of 2
  for (const Image& image : {film.develop(), film.seen(), film.layer(0)}) {
    EXPECT_FLOAT_EQ(image.at(0, 0, 0), (4 * 1 + 2 * 2) / 6.0f);
    EXPECT_FLOAT_EQ(image.at(1, 0, 0), (4 * 1 + 2 * 2) / 6.0f);
    EXPECT_FLOAT_EQ(image.at(2, 0, 0), 1);
  }
}

TEST(Film, UntouchedTilesAreBlackAndUnlisted) {
  Film film(128, 64);
  film.add(1, flat(film.tile(1), 4.0f), 2);
  const Film::Changes changes = film.tiles_since(0, 10);
  ASSERT_EQ(changes.tiles.size(), 1u);
  EXPECT_EQ(changes.tiles[0].index, 1);
  EXPECT_EQ(changes.tiles[0].samples, 2u);
  EXPECT_EQ(film.develop().at(0, 0, 0), 0.0f);
  EXPECT_EQ(film.develop().at(64, 0, 0), 2.0f);
}

TEST(Film, CursorWalksThroughChangesWithALimit) {
  Film film(64 * 5, 64);
  for (int i : {3, 1, 4, 0}) film.add(i, flat(film.tile(i), 1), 1);
  Film::Changes changes = film.tiles_since(0, 3);
  EXPECT_EQ(changes.left_out, 1);
  ASSERT_EQ(changes.tiles.size(), 3u);
  EXPECT_EQ(changes.tiles[0].index, 3);
  changes = film.tiles_since(changes.cursor, 3);
  ASSERT_EQ(changes.tiles.size(), 1u);
  EXPECT_EQ(changes.tiles[0].index, 0);
  EXPECT_TRUE(film.tiles_since(changes.cursor, 3).tiles.empty());
  film.add(3, flat(film.tile(3), 1), 1);
  EXPECT_EQ(film.tiles_since(changes.cursor, 3).tiles.size(), 1u);
}

TEST(Film, AReaderThatFollowsTheCursorEndsWithEveryTilesLastState) {
  Film film(64 * 8, 64);
  constexpr int kRounds = 400;
  std::vector<std::thread> writers;
  for (int w = 0; w < 2; ++w)
    writers.emplace_back([&, w] {
      for (int round = 0; round < kRounds; ++round)
        for (int i = w; i < 8; i += 2) film.add(i, flat(film.tile(i), 1), 1);
    });
  std::vector<uint32_t> last(8);
  uint64_t cursor = 0;
  bool complete = false;
  for (int reads = 0; !complete && reads < 10'000'000; ++reads) {
    const Film::Changes changes = film.tiles_since(cursor, 3);
    for (const auto& t : changes.tiles) last[static_cast<size_t>(t.index)] = t.samples;
    cursor = changes.cursor;
    complete = changes.tiles.empty() && cursor == 8 * kRounds;
  }
  for (std::thread& t : writers) t.join();
  EXPECT_EQ(last, std::vector<uint32_t>(8, kRounds));
}

}  // namespace
}  // namespace qray
