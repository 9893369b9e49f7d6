#include "tests/support/places.h"

namespace qray::test {

std::filesystem::path source_dir() { return QRAY_SOURCE_DIR; }
std::filesystem::path program(const std::string& name) {
  return std::filesystem::path(QRAY_BIN_DIR) / name;
}
std::filesystem::path testdata_dir() { return QRAY_TESTDATA_DIR; }

}  // namespace qray::test
