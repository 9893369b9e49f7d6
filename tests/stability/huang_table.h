// Tables as tests of the suite need them: learned by a small job, and those of the thesis' method
// read and written state by state. One thread.
#pragma once

#include <string>
#include <vector>

#include "core/guide/huang.h"
#include "tests/support/render.h"

namespace qray::test {

// What a variant learns from a job of `samples` a pixel; empty for `none`. A seed of its own. The
// job ends where learning does: the passes after that would not change the table.
std::optional<TableFile> learned_table(const PreparedScene& scene, RenderSettings settings,
                                       std::string_view variant, int samples = 64);

// The method keeps the thesis' 26 values a state.
inline bool is_huang(std::string_view method) { return table_method(method) == "huang"; }
// Every such method. The others have neither alpha nor gamma.
inline std::vector<std::string> huang_methods() {
  std::vector<std::string> methods(method_names().begin(), method_names().end());
  std::erase_if(methods, [](const std::string& method) { return !is_huang(method); });
  return methods;
}

// One record of the section HQ26 (proto/table_file.md).
struct HuangState {
  uint64_t key = 0;
  HuangGuide::Values q{};
  std::array<uint32_t, kDirections26> count{};
};
std::vector<HuangState> huang_states(const TableFile& table);
void set_huang_states(TableFile& table, const std::vector<HuangState>& states);
float largest_value(const TableFile& table);  // NaN if one is

}  // namespace qray::test
