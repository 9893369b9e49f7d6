// glTF as JSON. A buffer of 256 bytes and a picture lie beside it.
#include "tests/fuzz/load.h"

namespace qray::fuzz {
namespace {

class Target {
 public:
  Target() {
    folder_.add_schema_corpus();
    std::string bytes;
    for (int i = 0; i < 64; ++i)
      bytes += std::string_view(i % 4 == i / 16 ? "\0\0\x80\x3f" : "\0\0\0\0", 4);
    folder_.write("a.bin", bytes);
  }

  void run(std::string_view input) const {
    expect_scene_or_error(folder_.write("scene.gltf", input));
  }

 private:
  Folder folder_;
};

}  // namespace
}  // namespace qray::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const qray::fuzz::Target target;
  target.run(qray::fuzz::as_text({data, size}));
  return 0;
}
