#include "tests/stability/report.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>

namespace qray::test {
namespace {

// A cell of the table is one line, and ends at a bar.
std::string cell(std::string_view text) {
  std::string safe(text);
  for (char& c : safe)
    if (c == '\t' || c == '\n' || c == '|') c = ' ';
  return safe;
}

}  // namespace

void Row::says(std::string_view method, std::string_view measured) const {
  const char* path = std::getenv("QRAY_STABILITY_REPORT");
  if (!path) return;
  const std::string line = std::to_string(order_) + '\t' + cell(title_) + '\t' + cell(must_hold_) +
                           '\t' + cell(method) + '\t' + cell(measured) + '\n';
  // One write at the file's end is not torn by those of other processes.
  const int file = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0 || ::write(file, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    ADD_FAILURE() << "cannot write to " << path;
  if (file >= 0) ::close(file);
}

std::string formatted(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace qray::test
