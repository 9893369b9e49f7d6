// The failure modes of docs/stability.md, and what a test says about one of them. With the
// environment variable QRAY_STABILITY_REPORT each statement goes to the file that it names, one
// line of tab-separated fields (failure_mode.cpp lists them), from which report.sh makes the pages;
// without it statements go nowhere. Several tests and processes may write at once.
#pragma once

#include <string>
#include <string_view>

namespace qray::test {

class FailureMode {
 public:
  // `name`: one of the list in failure_mode.cpp, and the name of its page in docs/stability/.
  explicit FailureMode(std::string_view name);

  // Whether statements go anywhere. Where not, a figure that no expectation needs may be left out.
  static bool reports();

  // A figure for the page's tables, which have a row for each scene and a column for each method.
  // `scene`: what tells this picture from the others of this page; may be empty.
  void mean(std::string_view method, std::string_view scene, std::string_view figure) const {
    write("mean", method, scene, figure);
  }
  void error(std::string_view method, std::string_view scene, std::string_view figure) const {
    write("error", method, scene, figure);
  }
  // Anything else that was measured. `method` empty: for a statement that no method changes.
  void says(std::string_view method, std::string_view measured) const {
    write("says", method, "", measured);
  }

 private:
  void write(std::string_view kind, std::string_view method, std::string_view scene,
             std::string_view text) const;

  size_t place_;  // in the list
};

// As printf.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

}  // namespace qray::test
