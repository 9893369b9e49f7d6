// An HTML page with places that data fills, in a small part of Mustache's language:
//   {{name}}                   a text, escaped
//   {{#name}} ... {{/name}}    once for each item of a list
//   {{^name}} ... {{/name}}    where the list is empty
// A name is looked up in the item, then in what is around it. Any thread.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace qray {

struct HtmlData {
  std::map<std::string, std::string> texts;
  std::map<std::string, std::vector<HtmlData>> lists;

  // A list of one or none, for a part of the page that may be missing.
  void show_if(const std::string& name, bool shown, HtmlData item = {}) {
    lists[name].assign(shown ? 1 : 0, std::move(item));
  }
};

// Text for HTML, in attributes too.
std::string html_escape(std::string_view text);

// pre: every place of the page has data, every list an end.
std::string fill_html(std::string_view page, const HtmlData& data);

}  // namespace qray
