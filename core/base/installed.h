// Where the files that come with qray are: scenes, the page, the contract, what is loaded later,
// the programs compiled for newer processors. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace qray {

// `path` (such as "lib/qray/x.so") in the prefix of the running program; else `other`. A prefix
// holds programs in `bin`, and in kNewerPrograms those for newer processors.
std::filesystem::path beside_program(const std::filesystem::path& path,
                                     const std::filesystem::path& other);
// The same for another program.
std::filesystem::path beside_program(const std::filesystem::path& path,
                                     const std::filesystem::path& other,
                                     const std::filesystem::path& program);

// `share/qray/<name>` beside the program, when it was installed; else `source`, in the tree that it
// was built from.
std::filesystem::path installed_or(std::string_view name, const std::filesystem::path& source);

// The programs that need a processor of x86-64-v3 (AVX2, made since 2013).
constexpr std::string_view kNewerPrograms = "lib/qray/x86-64-v3";

// For the first line of main(): goes on as the program of the same name in kNewerPrograms, in the
// same process, if it is installed, this processor runs it and this program was compiled for less.
void run_program_of_processor(char** argv);
// "0.1.0 for x86-64-v3": this program's version, and the processors that it needs if it does not
// run on all of its architecture.
std::string version_for_processor();

}  // namespace qray
