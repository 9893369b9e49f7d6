// Pictures that a service answers with, for tests.
#pragma once

#include "core/base/file.h"
#include "core/image/image_io.h"
#include "tests/server/test_service.h"
#include "tests/support/render.h"

namespace qray::server::test {

struct PictureAnswer {
  Image image{1, 1, 3};
  ImageMetadata metadata;
};

inline PictureAnswer get_picture(const TestService& s, const std::string& path) {
  const auto answer = s.client().Get(path);
  if (!answer || answer->status != 200) {
    ADD_FAILURE() << path << ": " << (answer ? answer->body : "no answer");
    return {};
  }
  const bool png = answer->get_header_value("Content-Type") == "image/png";
  const auto file = s.scratch / (png ? "answer.png" : "answer.exr");
  EXPECT_TRUE(write_file_atomic(file, Bytes(answer->body.begin(), answer->body.end())).ok());
  return {read_image(file).value(), read_image_metadata(file).value()};
}

using qray::test::same_bits;

}  // namespace qray::server::test
