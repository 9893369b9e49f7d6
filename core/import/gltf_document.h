// A .gltf or .glb file, checked: its JSON as a tree with places and as a model, and the bytes of
// its buffers, data URIs and pictures. Throws ImportFailure. One thread.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "core/import/gltf_model.h"

namespace qray {

class GltfDocument {
 public:
  explicit GltfDocument(const std::filesystem::path& path);
  GltfDocument(const GltfDocument&) = delete;
  GltfDocument& operator=(const GltfDocument&) = delete;

  const std::string& file() const { return file_; }  // "room.gltf", of messages
  JsonNode root() const { return {tree_, file_ + ":"}; }
  JsonNode at(const char* list, int index) const;  // pre: a checked index
  const GltfModel& model() const { return model_; }
  size_t count(const char* list) const;

  // pre: a checked index. Fails where the view is not within its buffer, and that within its file.
  std::span<const uint8_t> view_bytes(int view) const;
  // Another view, of bytes that were unpacked; its index. `place`: of what says so.
  int add_view(const JsonNode& place, Bytes bytes, size_t stride = 0);

  // What a picture is made of: a file's path, or bytes with a name for messages.
  struct Picture {
    std::filesystem::path path;
    std::shared_ptr<const Bytes> bytes;
  };
  Picture read_picture(int image);

 private:
  std::span<const uint8_t> split_glb();
  void read_buffers();
  void unpack_views();
  Bytes read_data_uri(const JsonNode& uri) const;
  std::filesystem::path find_file(const JsonNode& uri) const;

  std::string file_;
  std::filesystem::path folder_;  // canonical
  Bytes text_;                    // the file
  std::span<const uint8_t> binary_;
  bool has_binary_ = false;
  JsonValue tree_;
  GltfModel model_;
  std::vector<Bytes> owned_;
  std::vector<std::span<const uint8_t>> buffers_;
  std::map<int, Picture> pictures_;
  uint64_t bytes_left_;  // that other files, pictures and unpacked views may have
};

}  // namespace qray
