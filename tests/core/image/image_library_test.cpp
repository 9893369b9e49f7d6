#include "core/image/image_library.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

TEST(ImageLibrary, WhatCannotBeLoadedIsAnErrorThatNamesTheFile) {
  const test::ScratchFolder folder;
  const auto gone = folder / "gone.so", no_library = folder / "text.so";
  ASSERT_TRUE(write_file_atomic(no_library, Bytes(100, uint8_t{'a'})).ok());
  for (const auto& file : {gone, no_library, std::filesystem::path("libm.so.6")}) {
    const auto library = open_image_library(file);
    ASSERT_FALSE(library.ok()) << file;
    EXPECT_EQ(library.error().code, ErrorCode::kIo);
    EXPECT_EQ(library.error().where, file.string());
    EXPECT_TRUE(library.error().message.starts_with("cannot load what reads and writes pictures: "))
        << library.error().message;
  }
}

}  // namespace
}  // namespace qray
