// What was added to the trees of a copy, as bytes. Of each node that was hit: its distance from the
// one before, from 1 on; which of its quadrants were, a bit each; of each of these n and s. Behind
// the last one a 0. All are varints.
#include "core/base/varint.h"
#include "core/guide/direction_tree.h"

namespace qray {

void DirectionTrees::take_sums(ByteWriter& out) {
  size_t next = 0;  // behind the last one written
  for (size_t i = 0; i < sums_.size(); ++i) {
    Quad& quad = sums_[i];
    uint64_t hit = 0;
    for (int q = 0; q < 4; ++q) hit |= uint64_t{quad.n[q] > 0} << q;
    if (hit == 0) continue;
    put_varint(out, i + 1 - next);
    next = i + 1;
    put_varint(out, hit);
    for (int q = 0; q < 4; ++q) {
      if (quad.n[q] == 0) continue;
      put_varint(out, quad.n[q]);
      put_signed_varint(out, quad.s[q]);
    }
    quad = {};
  }
  put_varint(out, 0);
}

bool DirectionTrees::read_sums(ByteReader& in, std::vector<Added>& added) const {
  for (uint64_t next = 0;;) {
    uint64_t step = 0, hit = 0, n = 0;
    if (!get_varint(in, step) || step > sums_.size() - next) return false;
    if (step == 0) return true;
    next += step;
    if (!get_varint(in, hit) || hit == 0 || hit > 15) return false;
    for (int q = 0; q < 4; ++q) {
      if (!(hit >> q & 1)) continue;
      Added& one = added.emplace_back();
      one.node = next - 1;
      one.quadrant = q;
      if (!get_varint(in, n) || n > UINT32_MAX || !get_signed_varint(in, one.sums.s)) return false;
      one.sums.n = static_cast<uint32_t>(n);
    }
  }
}

void DirectionTrees::add_sums(const std::vector<Added>& added) {
  for (const Added& one : added) {
    sums_[one.node].s[one.quadrant] += one.sums.s;
    sums_[one.node].n[one.quadrant] += one.sums.n;
  }
}

}  // namespace qray
