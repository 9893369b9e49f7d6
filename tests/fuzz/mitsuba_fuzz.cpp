// Mitsuba's XML. Meshes, pictures, a spectrum and a file to include lie beside it.
#include "tests/fuzz/load.h"

namespace qray::fuzz {
namespace {

class Target {
 public:
  Target() {
    folder_.add_schema_corpus();
    folder_.add("tests/fuzz/corpus/serialized/two_shapes.serialized", "a.serialized");
    folder_.write("a.spd", "400 0.1\n550 0.9\n700 0.2\n");
    folder_.write("part.xml",
                  "<scene version=\"0.6.0\"><bsdf type=\"$kind\" id=\"part\"/></scene>\n");
  }

  void run(std::string_view input) const {
    expect_scene_or_error(folder_.write("scene.xml", input));
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
