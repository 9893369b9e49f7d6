// Which bits this process makes: two whose texts are equal make the same ones of the same work.
// Functions of the system's library (sines, powers) choose their code by the processor, so that two
// processors may differ though the build is one. Any thread.
#pragma once

#include <string>

namespace qray::server {

std::string bits_of_machine();

}  // namespace qray::server
