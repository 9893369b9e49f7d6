#include "tests/stability/huang_table.h"

#include "core/base/check.h"
#include "core/settings/variant.h"

namespace qray::test {

std::optional<TableFile> learned_table(const PreparedScene& scene, RenderSettings settings,
                                       std::string_view variant, int samples) {
  settings = apply_variant(variant, std::move(settings)).value();
  settings.samples = samples;
  settings.seed = 99'991;
  return render(scene, learning_passes_of(settings)).job.table;
}

std::vector<HuangState> huang_states(const TableFile& table) {
  QRAY_CHECK(table.sections.size() == 2);
  ByteReader in(table.sections[1].bytes);
  std::vector<HuangState> states(in.u64());
  for (HuangState& state : states) {
    state.key = in.u64();
    for (size_t a = 0; a < kDirections26; ++a) {
      state.q[a] = in.f32();
      state.count[a] = in.u32();
    }
  }
  QRAY_CHECK(in.ok() && in.remaining() == 0);
  return states;
}

void set_huang_states(TableFile& table, const std::vector<HuangState>& states) {
  ByteWriter out;
  out.u64(states.size());
  for (const HuangState& state : states) {
    out.u64(state.key);
    for (size_t a = 0; a < kDirections26; ++a) {
      out.f32(state.q[a]);
      out.u32(state.count[a]);
    }
  }
  table.sections[1].bytes = out.take();
}

float largest_value(const TableFile& table) {
  float largest = 0;
  for (const HuangState& state : huang_states(table))
    for (float q : state.q)
      if (!(q <= largest)) largest = q;  // and stays NaN
  return largest;
}

}  // namespace qray::test
