// Which pixels of a pass ask the guide, and from which it learns. A value; any thread.
#pragma once

#include <cstdint>

namespace qray {

struct GuidedPixels {
  static constexpr uint64_t kPart = 16;  // of the pixels, one in so many where only a part is meant
  static constexpr uint64_t kFew = 8;    // of those that ask, one in so many where few are learned

  bool guided = false;    // paths ask the guide
  bool learning = false;  // it learns from them
  bool part = false;      // both hold for one pixel in kPart, spread evenly
  bool few = false;       // it learns from one in kFew of those, others in each pass
  uint64_t pass = 0;      // its number

  bool serves(int x, int y) const { return !part || spread(x, y) % kPart == 0; }
  bool learns(int x, int y) const {
    return learning && serves(x, y) && (!few || (spread(x, y) + pass) % kFew == 0);
  }

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.guided, self.learning, self.part, self.few, self.pass);
  }

 private:
  static constexpr int kLatticeShift = 6;  // a row's pixels lie between those of its neighbours
  static uint64_t spread(int x, int y) { return static_cast<uint64_t>(x + kLatticeShift * y); }
};

}  // namespace qray
