// Where the sources, the programs and other people's scenes lie. Compiled in one file, so that
// tests need not be built again where a checkout is moved. Any thread.
#pragma once

#include <filesystem>
#include <string>

namespace qray::test {

std::filesystem::path source_dir();
std::filesystem::path program(const std::string& name);  // "qrayd"
// May be absent: tests that want it then skip with a message.
std::filesystem::path testdata_dir();

}  // namespace qray::test
