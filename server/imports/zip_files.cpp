#include "server/imports/zip_files.h"

#include <zip.h>

namespace qray::server {

Status zip_files(const std::filesystem::path& path,
                 const std::vector<std::filesystem::path>& files) {
  const Error failed{ErrorCode::kIo, "the archive cannot be written", path.filename().string()};
  int error = 0;
  zip_t* zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_EXCL, &error);
  if (!zip) return failed;
  for (const std::filesystem::path& file : files) {
    zip_source_t* source = zip_source_file(zip, file.c_str(), 0, -1);
    const zip_int64_t index =
        source ? zip_file_add(zip, file.filename().c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (index < 0) {
      if (source) zip_source_free(source);
      zip_discard(zip);
      return failed;
    }
    zip_set_file_compression(zip, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
  }
  if (zip_close(zip) == 0) return {};
  zip_discard(zip);
  return failed;
}

}  // namespace qray::server
