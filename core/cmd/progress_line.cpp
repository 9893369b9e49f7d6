#include "core/cmd/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace qray::cmd {
namespace {

constexpr double kBarPeriodSeconds = 0.1, kLinePeriodSeconds = 5;
constexpr size_t kBarCharacters = 30;

}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {
  if (!terminal_) next_ = clock_.seconds() + kLinePeriodSeconds;
}

void ProgressLine::show(std::string_view phase, double fraction, std::string_view done,
                        double seconds) {
  const double now = clock_.seconds();
  if (quiet_ || now < next_) return;
  next_ = now + (terminal_ ? kBarPeriodSeconds : kLinePeriodSeconds);
  fraction = std::clamp(fraction, 0.0, 1.0);
  const std::string label(phase), words(done);
  if (!terminal_) {
    std::fprintf(stderr, "%s: %.0f %%, %s%s%.1f s\n", label.c_str(), 100 * fraction, words.c_str(),
                 words.empty() ? "" : ", ", seconds);
    return;
  }
  const auto full = static_cast<size_t>(fraction * kBarCharacters);
  const std::string bar = std::string(full, '#') + std::string(kBarCharacters - full, '.');
  std::fprintf(stderr, "\r[%s] %3.0f %%  %-10s %22s  %7.1f s\033[K", bar.c_str(), 100 * fraction,
               label.c_str(), words.c_str(), seconds);
  drawn_ = true;
}

void ProgressLine::finish() {
  if (drawn_) std::fputc('\n', stderr);
  drawn_ = false;
}

std::string samples_words(uint64_t samples) { return std::to_string(samples) + " samples a pixel"; }

void ProgressObserver::on_tile(const RenderProgress& progress) {
  line_.show(progress.learning ? "learning" : "rendering", progress.fraction,
             samples_words(progress.samples_per_pixel), progress.seconds);
}

}  // namespace qray::cmd
