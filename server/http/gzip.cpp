#include "server/http/gzip.h"

#include <zlib.h>

#include <new>

#include "core/base/check.h"

namespace qray::server {

Bytes gzip(const Bytes& bytes) {
  constexpr int kGzipWindow = MAX_WBITS + 16;  // zlib's way to ask for a gzip header
  constexpr int kUsualMemory = 8;
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindow, kUsualMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  Bytes out(deflateBound(&stream, bytes.size()));
  stream.next_in = const_cast<Bytef*>(bytes.data());  // zlib's interface; it only reads
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  const int state = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  QRAY_CHECK(state == Z_STREAM_END);  // deflateBound() is enough for one call
  return out;
}

}  // namespace qray::server
