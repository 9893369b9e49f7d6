// What is the same in the page of every chart. Pieces of HTML, CSS and JavaScript.
#pragma once

namespace qray {

extern const char* const kPageStyle;
extern const char* const kPageTerms;   // what the words of table and plot mean
extern const char* const kPageScript;  // the split view; without it all pictures stand in rows

}  // namespace qray
