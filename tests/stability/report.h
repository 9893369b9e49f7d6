// What a failure mode is, what must hold there, and what each method was measured to do: one row of
// docs/stability.md. Statements go to the file named by QRAY_STABILITY_REPORT, one line each, tab
// separated (order, title, must hold, method, measured); without it they go nowhere. report.sh
// makes the document. Several tests and processes may write at once.
#pragma once

#include <string>
#include <string_view>

namespace qray::test {

class Row {
 public:
  // `order`: ten times the row's place in the list of README.md. Rows of one order are one row.
  Row(int order, std::string_view title, std::string_view must_hold)
      : order_(order), title_(title), must_hold_(must_hold) {}

  // `method` empty: for a statement that no method changes. Statements of one method are joined.
  void says(std::string_view method, std::string_view measured) const;

 private:
  int order_;
  std::string title_, must_hold_;
};

// As printf.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

}  // namespace qray::test
