// Where the files that come with qray are: scenes, the page, the contract, what is loaded later.
// Any thread.
#pragma once

#include <filesystem>
#include <string_view>

namespace qray {

// `path` (such as "lib/qray/x.so") in the folder that holds the running program's `bin`; else
// `other`.
std::filesystem::path beside_program(const std::filesystem::path& path,
                                     const std::filesystem::path& other);
// The same for a program that is in the folder `bin`.
std::filesystem::path beside_program(const std::filesystem::path& path,
                                     const std::filesystem::path& other,
                                     const std::filesystem::path& bin);

// `share/qray/<name>` beside the program, when it was installed; else `source`, in the tree that it
// was built from.
std::filesystem::path installed_or(std::string_view name, const std::filesystem::path& source);

}  // namespace qray
