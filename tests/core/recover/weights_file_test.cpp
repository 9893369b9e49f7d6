#include "core/recover/weights_file.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/recover/pyramid.h"

namespace qray {
namespace {

WeightsFile some_weights() {
  WeightsFile w;
  w.program = "test";
  w.scene = "room";
  w.geometry = sha256(Bytes{1, 2, 3});
  w.steps = 600;
  w.held_out = {0.5f, 0.25f};
  w.network = untrained_network(3);
  w.id = weights_id(w);
  return w;
}

TEST(WeightsFile, ComesBackAsItWas) {
  const WeightsFile w = some_weights();
  const Bytes bytes = encode_weights(w);
  const Result<WeightsFile> read = decode_weights(bytes);
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read.value().id, w.id);
  EXPECT_EQ(read.value().scene, "room");
  EXPECT_TRUE(read.value().geometry == w.geometry);
  EXPECT_EQ(read.value().steps, 600u);
  EXPECT_EQ(read.value().held_out, w.held_out);
  EXPECT_EQ(read.value().network.values, w.network.values);
  EXPECT_EQ(encode_weights(read.value()), bytes);
  EXPECT_LT(bytes.size(), size_t{512} << 10);
}

TEST(WeightsFile, AnyCutAndAnyFlippedBitIsRefused) {
  const Bytes bytes = encode_weights(some_weights());
  for (size_t size = 0; size < bytes.size(); size += size < 300 ? 1 : 9973)
    EXPECT_FALSE(decode_weights(std::span(bytes).first(size)).ok()) << size;
  for (size_t bit = 0; bit < 8 * bytes.size(); bit += bit < 2400 ? 1 : 39989) {
    Bytes damaged = bytes;
    damaged[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
    EXPECT_FALSE(decode_weights(damaged).ok()) << "bit " << bit;
  }
  Bytes longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(decode_weights(longer).ok());
}

TEST(WeightsFile, WhatMayNotStandInItIsRefusedUnderARightChecksum) {
  const auto refused = [](auto&& change) {
    WeightsFile w = some_weights();
    change(w);
    w.id = weights_id(w);
    return !decode_weights(encode_weights(w)).ok();
  };
  EXPECT_FALSE(refused([](WeightsFile&) {}));
  for (float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 2e4f})
    EXPECT_TRUE(refused([&](WeightsFile& w) { w.network.values[7] = bad; })) << bad;
  EXPECT_TRUE(refused([](WeightsFile& w) { w.held_out[0] = -1; }));
  EXPECT_TRUE(refused([](WeightsFile& w) { w.network.values.pop_back(); }));
  EXPECT_TRUE(refused([](WeightsFile& w) { w.network = {}; }));
  WeightsFile wrong = some_weights();
  wrong.id = std::string(32, '0');
  EXPECT_FALSE(decode_weights(encode_weights(wrong)).ok());
}

TEST(WeightsFile, AnotherVersionOrLayoutIsSaidToBeOne) {
  for (const auto& [at, expected] : {std::pair{8u, "expected 4"}, {12u, "expected 2"}}) {
    Bytes bytes = encode_weights(some_weights());
    bytes[at] = 9;
    const Result<WeightsFile> read = decode_weights(bytes);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(read.error().text().find(expected), std::string::npos) << read.error().text();
  }
  Bytes older = encode_weights(some_weights());
  older[8] = 3;  // with another network beside it
  EXPECT_EQ(decode_weights(older).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace qray
