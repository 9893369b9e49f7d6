// Our own scene format. A mesh, a picture and a sky lie beside the file.
#include "tests/fuzz/load.h"

namespace qray::fuzz {
namespace {

class Target {
 public:
  Target() { folder_.add_schema_corpus(); }

  void run(std::string_view input) const {
    expect_scene_or_error(folder_.write("scene.json", input));
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
