// For tests whose claim is about bits or pictures: under a sanitizer, several times as slow, they
// run the same code over fewer samples. The build without one makes the claim for the usual number.
#pragma once

namespace qray::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace qray::test
