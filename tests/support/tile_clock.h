// A clock that tells a second more for each tile that was rendered. One thread renders.
#pragma once

#include "core/base/clock.h"
#include "core/render/render_observer.h"

namespace qray::test {

class TileClock final : public Clock, public RenderObserver {
 public:
  double seconds() const override { return tiles_; }
  void on_tile(const RenderProgress&) override { ++tiles_; }

 private:
  int tiles_ = 0;
};

}  // namespace qray::test
