// The loader's verdict on each file named: "ok <path>" or "bad <path>\t<error>", a line each. For
// agree.mjs, which compares it with the schema's.
#include <cstdio>

#include "core/import/load_scene.h"

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const auto loaded = qray::load_scene(argv[i]);
    if (loaded.ok())
      std::printf("ok %s\n", argv[i]);
    else
      std::printf("bad %s\t%s\n", argv[i], loaded.error().text().c_str());
  }
}
