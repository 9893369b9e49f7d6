// Points, directions and colours that may differ by rounding.
#pragma once

#include <gtest/gtest.h>

#include <type_traits>

namespace qray::test {

// Each component of `a` is within `error` of that of `b`.
template <class V>
void expect_near(const V& a, const std::type_identity_t<V>& b, float error = 1e-5f) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], error) << "component " << i;
}

}  // namespace qray::test
