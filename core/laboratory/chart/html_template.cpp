#include "core/laboratory/chart/html_template.h"

#include "core/base/check.h"

namespace qray {
namespace {

struct Scope {
  const HtmlData& data;
  const Scope* outer;
};

template <class T>
const T& look_up(const Scope* scope, std::map<std::string, T> HtmlData::*members,
                 const std::string& name) {
  const T* found = nullptr;
  for (; scope && !found; scope = scope->outer) {
    const auto& known = scope->data.*members;
    if (const auto it = known.find(name); it != known.end()) found = &it->second;
  }
  QRAY_CHECK(found);
  return *found;
}

void fill(std::string_view page, const Scope& scope, std::string& out) {
  for (;;) {
    const size_t begin = page.find("{{");
    out += page.substr(0, begin);
    if (begin == std::string_view::npos) return;
    page.remove_prefix(begin + 2);
    const size_t end = page.find("}}");
    QRAY_CHECK(end != std::string_view::npos);
    std::string name(page.substr(0, end));
    page.remove_prefix(end + 2);
    const char kind = name[0];
    if (kind != '#' && kind != '^') {
      out += html_escape(look_up(&scope, &HtmlData::texts, name));
      continue;
    }
    name.erase(0, 1);
    const std::string close = "{{/" + name + "}}";
    const size_t size = page.find(close);
    QRAY_CHECK(size != std::string_view::npos);
    const std::string_view part = page.substr(0, size);
    const std::vector<HtmlData>& items = look_up(&scope, &HtmlData::lists, name);
    if (kind == '^' && items.empty()) fill(part, scope, out);
    for (size_t i = 0; kind == '#' && i < items.size(); ++i) fill(part, {items[i], &scope}, out);
    page.remove_prefix(size + close.size());
  }
}

}  // namespace

std::string html_escape(std::string_view text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string fill_html(std::string_view page, const HtmlData& data) {
  std::string out;
  fill(page, {data, nullptr}, out);
  return out;
}

}  // namespace qray
