// Tables of the thesis' 26 values to try a sampler on, degenerate ones included.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/guide/huang.h"
#include "tests/support/random.h"

namespace qray::test {

struct NamedValues {
  std::string name;
  HuangGuide::Values values;
};

// n: the hemisphere's normal, to place one value straight above and one straight below.
inline std::vector<NamedValues> huang_tables(Vec3 n, uint64_t seed) {
  Random random(seed);
  const size_t top = static_cast<size_t>(nearest_direction26(n));
  const size_t bottom = static_cast<size_t>(nearest_direction26(-n));
  std::vector<NamedValues> tables(6);
  tables[0].name = "random";
  tables[1].name = "one above the rest";
  tables[2].name = "all equal";
  tables[3].name = "all zero";
  tables[4].name = "largest below the horizon";
  tables[5].name = "geometric";
  for (size_t a = 0; a < kDirections26; ++a) {
    tables[0].values[a] = random.next();
    tables[1].values[a] = a == top ? 1.0f : 0.02f * random.next();
    tables[2].values[a] = 1;
    tables[3].values[a] = 0;
    tables[4].values[a] = a == bottom ? 1.0f : 0.1f * random.next();
    tables[5].values[a] = std::ldexp(1.0f, -static_cast<int>(a));
  }
  return tables;
}

}  // namespace qray::test
