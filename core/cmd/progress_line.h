// Progress on stderr: a bar that redraws itself on a terminal, else a line now and then. May be
// called often and by several threads, one at a time; it writes at most ten times a second.
#pragma once

#include <string>
#include <string_view>

#include "core/base/clock.h"
#include "core/render/render_loop.h"

namespace qray::cmd {

class ProgressLine {
 public:
  explicit ProgressLine(bool quiet = false);

  // `done`: what fraction is in words, such as "12 views"; may be empty.
  void show(std::string_view phase, double fraction, std::string_view done, double seconds);
  void finish();  // leaves the bar's line

 private:
  bool quiet_, terminal_, drawn_ = false;
  double next_ = 0;  // seconds of clock_, before which nothing is written
  SteadyClock clock_;
};

std::string samples_words(uint64_t samples);  // "12 samples a pixel"

class ProgressObserver final : public RenderObserver {
 public:
  explicit ProgressObserver(ProgressLine& line) : line_(line) {}
  void on_tile(const RenderProgress& progress) override;
  void on_pass(const RenderProgress& progress, const RenderStats&, const Guide*) override {
    on_tile(progress);
  }

 private:
  ProgressLine& line_;
};

}  // namespace qray::cmd
