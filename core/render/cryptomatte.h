// Cryptomatte 1.2 (Friedman and Jones 2015): for each pixel which things it shows, by hashes of
// their names, and how much of it each covers. Pure.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/image/picture_layers.h"

namespace qray {

// What stands for a name: its hash, whose bits are those of a number that is neither infinite, nor
// none, nor denormal.
uint32_t cryptomatte_id(std::string_view name);

// One kind of things: its pixels as they are added, then its layers.
class Cryptomatte {
 public:
  static constexpr int kRanks = 6;  // things that a pixel tells of; two to a layer

  // `names`: of the things, by number; several may have one name.
  Cryptomatte(int width, int height, std::string layer, std::vector<std::string> names);

  // `things`: that the pixel's rays met, -1: none. Different pixels: any thread.
  void set(int x, int y, std::span<const int> things);

  // "CryptoObject00" on, of channels "rgba": hash, coverage, hash, coverage, the largest first.
  std::vector<PictureLayer> take_layers();
  ImageMetadata metadata() const;  // the layer's name and how it is to be read; the manifest

 private:
  std::string name_;
  std::vector<std::string> names_;
  std::vector<uint32_t> ids_;  // parallel
  std::vector<PictureLayer> layers_;
};

}  // namespace qray
