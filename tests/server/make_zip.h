// Zip archives, good ones and others, for tests.
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zip.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace qray::server::test {

struct ZipEntry {
  std::string name, content;
  mode_t mode = S_IFREG | 0644;
};

inline std::string file_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The archive's bytes; `scratch` is a folder to make them in.
inline std::string make_zip(const std::filesystem::path& scratch,
                            const std::vector<ZipEntry>& entries) {
  const std::filesystem::path file = scratch / "made.zip";
  std::filesystem::remove(file);
  zip_t* zip = zip_open(file.c_str(), ZIP_CREATE | ZIP_EXCL, nullptr);
  EXPECT_TRUE(zip);
  for (const ZipEntry& e : entries) {
    zip_source_t* source = zip_source_buffer(zip, e.content.data(), e.content.size(), 0);
    const zip_int64_t index = zip_file_add(zip, e.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    EXPECT_GE(index, 0) << e.name;
    // Of one time, so that the same entries give the same bytes.
    zip_file_set_mtime(zip, static_cast<zip_uint64_t>(index), 1'000'000'000, 0);
    zip_file_set_external_attributes(zip, static_cast<zip_uint64_t>(index), 0, ZIP_OPSYS_UNIX,
                                     static_cast<zip_uint32_t>(e.mode) << 16);
  }
  EXPECT_EQ(zip_close(zip), 0) << zip_strerror(zip);
  return file_text(file);
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  EXPECT_EQ(from.size(), to.size());
  EXPECT_NE(text.find(from), std::string::npos) << from;
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace qray::server::test
