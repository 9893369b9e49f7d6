// The materials of an OBJ file, which uses the names a, b and c.
#include "tests/fuzz/load.h"

namespace qray::fuzz {
namespace {

class Target {
 public:
  Target() {
    folder_.add_schema_corpus();
    scene_ = folder_.write("scene.obj",
                           "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n"
                           "usemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1 2 3\nusemtl c\nf 3 2 1\n");
  }

  void run(std::string_view input) const {
    folder_.write("a.mtl", input);
    expect_scene_or_error(scene_);
  }

 private:
  Folder folder_;
  std::filesystem::path scene_;
};

}  // namespace
}  // namespace qray::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const qray::fuzz::Target target;
  target.run(qray::fuzz::as_text({data, size}));
  return 0;
}
