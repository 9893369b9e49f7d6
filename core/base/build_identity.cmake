# Writes build_identity.cpp (OUT): a hash of the C++ sources and included networks of SOURCE, of its
# build rules, and of OPTIONS (compiler and flags). Leaves the file alone when it is the same.
cmake_minimum_required(VERSION 3.25)
set(all "${OPTIONS}")
foreach(folder core proto server)
  file(GLOB_RECURSE files RELATIVE ${SOURCE}
    ${SOURCE}/${folder}/*.h ${SOURCE}/${folder}/*.cpp ${SOURCE}/${folder}/*.qrw
    ${SOURCE}/${folder}/CMakeLists.txt)
  list(APPEND sources ${files})
endforeach()
list(SORT sources)
foreach(file CMakeLists.txt ${sources})
  file(SHA256 ${SOURCE}/${file} hash)
  string(APPEND all "\n${file} ${hash}")
endforeach()
string(SHA256 identity "${all}")
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT
"#include \"core/base/build_identity.h\"

namespace qray {
const char* build_identity() { return \"@identity@\"; }
}  // namespace qray
")
