// What a glTF document says of its scenes, nodes, meshes, accessors, buffer views, textures and
// samplers, as plain data: types and ranges are checked, every index is in range, but for
// broken animations, images, textures and samplers, which fail where they are used. The rest
// (materials, cameras, extensions) is read from the JSON where it is used. Any thread.
#pragma once

#include <map>

#include "core/import/import_failure.h"
#include "core/import/json_tree.h"
#include "core/scene/motion.h"

namespace qray {

// Numbers of the specification that other files of the importer need.
enum GltfComponent : int {
  kGltfByte = 5120,
  kGltfUnsignedByte = 5121,
  kGltfShort = 5122,
  kGltfUnsignedShort = 5123,
  kGltfUnsignedInt = 5125,
  kGltfFloat = 5126,
};
enum GltfMode : int { kGltfPoints = 0, kGltfTriangles = 4, kGltfTriangleFan = 6 };
enum GltfSampling : int { kGltfNearest = 9728, kGltfClamp = 33071, kGltfMirror = 33648 };

// Items of which some may be broken: that is an error where one is used, and only then.
template <class T>
class GltfList {
 public:
  void push_back(T item) { items_.push_back(std::move(item)); }
  void push_back_broken(Error error) {
    broken_.emplace(items_.size(), std::move(error));
    items_.emplace_back();
  }
  size_t size() const { return items_.size(); }
  const T& operator[](size_t i) const {
    if (const auto it = broken_.find(i); it != broken_.end()) throw ImportFailure{it->second};
    return items_[i];
  }
  const std::map<size_t, Error>& broken() const { return broken_; }

 private:
  std::vector<T> items_;
  std::map<size_t, Error> broken_;
};

// An index of -1: there is none. Sizes, counts and offsets are below 2^31.
struct GltfModel {
  struct View {
    int buffer = 0;
    size_t byte_offset = 0, byte_length = 0;
    size_t byte_stride = 0;  // 0: elements lie close together
  };
  // Elements within a view.
  struct Part {
    int view = -1;
    size_t byte_offset = 0;
    int component_type = kGltfFloat;
  };
  struct Accessor {
    Part elements;
    int components = 0;  // 1 to 4; 16: a 4 x 4 matrix; 0: another matrix
    size_t count = 0;
    bool normalized = false;
    size_t sparse_count = 0;  // 0: not sparse
    Part sparse_indices, sparse_values;
  };
  struct Primitive {
    std::map<std::string, int> attributes;  // accessors
    int indices = -1;                       // an accessor with a view
    int material = -1;
    std::vector<std::map<std::string, int>> targets;  // what a morph adds: accessors
    int mode = kGltfTriangles;
  };
  struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
    std::vector<double> weights;  // of the targets; what is missing is 0
  };
  struct Skin {
    std::vector<int> joints;    // nodes
    int inverse_matrices = -1;  // an accessor, a matrix for each joint
  };
  struct Node {
    int mesh = -1, camera = -1, skin = -1;
    std::vector<int> children;
    NodePose rest;  // its weights are instead of the mesh's
  };
  struct Channel {
    int node = -1;
    std::string path;             // "translation", "rotation", "scale", "weights", or unknown
    int input = -1, output = -1;  // accessors
    Track::Between between = Track::Between::kLinear;
  };
  struct Image {
    int view = -1;
  };
  struct Texture {
    int source = -1, sampler = -1;
  };
  struct Sampler {
    int mag_filter = -1, wrap_s = -1, wrap_t = -1;  // -1: not said
  };

  int scene = -1;
  std::vector<std::vector<int>> scenes;  // the nodes of each
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Accessor> accessors;
  std::vector<View> views;
  std::vector<Skin> skins;
  GltfList<std::vector<Channel>> animations;
  GltfList<Image> images;
  GltfList<Texture> textures;
  GltfList<Sampler> samplers;
};

// Throws ImportFailure with the place, and where the document requires an extension that nothing
// here reads.
GltfModel read_gltf_model(const JsonNode& root);

}  // namespace qray
