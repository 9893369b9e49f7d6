#include "core/base/sha256.h"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace qray {
namespace {

std::string hex_of(std::string_view text) {
  return sha256(std::vector<uint8_t>(text.begin(), text.end())).hex();
}

// FIPS 180-4's examples.
TEST(Sha256, PublishedVectors) {
  EXPECT_EQ(hex_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hex_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hex_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hex_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PartsAddUp) {
  Sha256 hash;
  for (const uint8_t letter : {'a', 'b', 'c'}) hash.add(std::vector<uint8_t>{letter});
  EXPECT_EQ(hash.finish().hex(), hex_of("abc"));
}

}  // namespace
}  // namespace qray
