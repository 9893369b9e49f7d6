// A name for this process that no other has had, on this machine or on another: for files that
// several machines write into one folder, and for who holds what. Any thread.
#pragma once

#include <string>

namespace qray {

const std::string& process_name();  // "4711-9f3a2b1c5d6e7f80"

}  // namespace qray
