// Where the files that come with qray are: scenes, the page, the contract. Any thread.
#pragma once

#include <filesystem>
#include <string_view>

namespace qray {

// `share/qray/<name>` beside the running program's `bin`, when it was installed; else `source`, in
// the tree that it was built from.
std::filesystem::path installed_or(std::string_view name, const std::filesystem::path& source);
// The same for a program that is in the folder `bin`.
std::filesystem::path installed_or(std::string_view name, const std::filesystem::path& source,
                                   const std::filesystem::path& bin);

}  // namespace qray
