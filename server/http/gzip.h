// Bytes as gzip has them (RFC 1952): the same bytes give the same. Any thread.
#pragma once

#include "core/base/byte_io.h"

namespace qray::server {

Bytes gzip(const Bytes& bytes);

}  // namespace qray::server
