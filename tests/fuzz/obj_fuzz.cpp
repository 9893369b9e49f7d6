// Wavefront OBJ. a.mtl lies beside it.
#include "tests/fuzz/load.h"

namespace qray::fuzz {
namespace {

class Target {
 public:
  Target() {
    folder_.add_schema_corpus();
    folder_.write("a.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKe 5 5 5\nmap_Kd checker.ppm\n");
  }

  void run(std::string_view input) const {
    expect_scene_or_error(folder_.write("scene.obj", input));
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
